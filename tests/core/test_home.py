"""Where caches and logs go of a user who has no home folder."""

from __future__ import annotations

import os
import stat
import tempfile
from pathlib import Path

import pytest

from arjuna_core.home import use_writable_home


@pytest.fixture(autouse=True)
def _temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "gettempdir", lambda: str(tmp_path))


def used(monkeypatch: pytest.MonkeyPatch, home: Path, **environment: str) -> dict[str, str]:
    """Return the environment thereafter, of a user whose home it may name."""
    monkeypatch.setattr(os, "environ", environment)
    monkeypatch.setattr(os.path, "expanduser", lambda path: str(home))
    use_writable_home()
    return environment


def own(tmp_path: Path) -> Path:
    return tmp_path / f"arjuna-{os.getuid()}"


def test_a_user_without_a_home_gets_a_folder_that_is_his_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = own(tmp_path)
    expected = {"XDG_CACHE_HOME": str(folder), "ROS_LOG_DIR": f"{folder}/log"}
    for _ in range(2):
        found = used(monkeypatch, tmp_path / "none", HOME="/none")
        assert found == {**expected, "HOME": "/none"}
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert used(monkeypatch, tmp_path / "none") == {**expected, "HOME": str(folder)}
    given = {"XDG_CACHE_HOME": "/cache", "ROS_LOG_DIR": "/log", "HOME": "/none"}
    assert used(monkeypatch, tmp_path / "none", **given) == given


def test_a_home_that_no_variable_names_is_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert used(monkeypatch, tmp_path) == {"HOME": str(tmp_path)}


@pytest.mark.parametrize("kind", ["open", "link", "file"])
def test_a_folder_that_another_user_may_have_made_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    """What is compiled is run from it."""
    if kind == "open":
        own(tmp_path).mkdir()
        own(tmp_path).chmod(0o777)
    elif kind == "link":
        own(tmp_path).symlink_to(tmp_path)
    else:
        own(tmp_path).touch()
    assert used(monkeypatch, tmp_path / "none", HOME="/none") == {"HOME": "/none"}
