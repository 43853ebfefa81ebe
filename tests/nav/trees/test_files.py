"""The files that the names of behavior trees mean."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.files.shipped import shipped_file
from arjuna_nav.trees.blackboard import TreeError
from arjuna_nav.trees.files import tree_file

NAME = "navigate_to_pose.xml"


def test_a_shipped_tree_never_stands_for_one_of_ones_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home, other, nav2 = (tmp_path / name for name in ("home", "other", "nav2_bt_navigator"))
    for folder in (home, other, nav2):
        folder.mkdir()
        (folder / NAME).touch()
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.chdir(home)
    folders = (str(tmp_path / "trees"),)
    shipped = shipped_file("behavior_trees") / NAME
    assert tree_file(str(home / NAME), folders) == home / NAME
    for name in (NAME, str(nav2 / NAME), f"/of/another/machine/{NAME}"):
        assert tree_file(name, folders) == shipped
    with pytest.raises(TreeError, match=r"'bt_folder'\) or the user's home"):
        tree_file(str(other / NAME), folders)
