"""Folders of temporary files."""

from __future__ import annotations

import os
from pathlib import Path

from arjuna_core.files.whole_file import own_folder


def test_a_folder_ends_with_its_process_or_with_the_next(tmp_path: Path) -> None:
    gone = 4194304  # above the greatest number of a process
    names = {f"arjuna-a-{os.getpid()}-x", f"arjuna-b-{gone}-x", "arjuna-a-", f"arjuna-ab-{gone}-x"}
    for name in (*names, f"arjuna-a-{gone}-x"):
        (tmp_path / name / "full").mkdir(parents=True)
    with own_folder("a", tmp_path) as folder:
        assert Path(folder).name.startswith(f"arjuna-a-{os.getpid()}-")
        assert {path.name for path in tmp_path.iterdir()} == {*names, Path(folder).name}
    assert {path.name for path in tmp_path.iterdir()} == names
