"""Claims: a file is there whole or not at all, however the program that writes it ends."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import InputFileError
from arjuna_core.files.maps import load_map, save_map
from arjuna_core.files.whole_file import emptied_folder, write_atomically
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2

_CHILD = """
import os, signal, sys
from pathlib import Path
from arjuna_core.errors import InputFileError
from arjuna_core.files.maps import load_map, save_map

new, target, point, number = sys.argv[1], sys.argv[2], sys.argv[3], int(sys.argv[4])
grid = load_map(new)
calls = 0

def killing(call):
    def wrapped(*arguments):
        global calls
        calls += 1
        if calls == number:
            os.kill(os.getpid(), signal.SIGKILL)
        return call(*arguments)
    return wrapped

if point == "fsync":
    os.fsync = killing(os.fsync)
else:
    Path.replace = killing(Path.replace)
save_map(grid, target)
"""


def _grid(value: int, size: int) -> OccupancyGrid:
    data = np.full((size, size), value, np.int8)
    return OccupancyGrid(GridFrame(0.05, size, size, SE2(float(size), 0.0, 0.0)), data)


@pytest.mark.parametrize(
    ("point", "number"),
    [
        *(("fsync", number) for number in range(1, 9)),
        *(("replace", number) for number in (1, 2, 3, 4)),
    ],
)
def test_killed_while_saving_a_map_the_pair_is_the_old_or_the_new(
    tmp_path: Path, point: str, number: int
) -> None:
    for name, value, size in (("map", 0, 20), ("new", 100, 30)):
        save_map(_grid(value, size), tmp_path / name)
    argv = [str(tmp_path / "new.yaml"), str(tmp_path / "map"), point, str(number)]
    child = subprocess.run(
        [sys.executable, "-c", _CHILD, *argv], cwd=Path(__file__).resolve().parents[3], check=False
    )
    assert child.returncode == -signal.SIGKILL
    left = load_map(tmp_path / "map.yaml")
    expected = _grid(100, 30) if number > (3 if point == "fsync" else 2) else _grid(0, 20)
    assert left.frame == expected.frame
    assert np.array_equal(left.data, expected.data)
    save_map(_grid(0, 20), tmp_path / "map")  # what the killed one left is in nobody's way
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".pgm", ".pgm", ".yaml", ".yaml"]


def test_a_check_that_raises_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "file"
    write_atomically(path, b"old")

    def refuse(part: Path) -> None:
        assert part.read_bytes() == b"new"
        raise ValueError("no")

    with pytest.raises(ValueError, match="no"):
        write_atomically(path, b"new", refuse)
    assert path.read_bytes() == b"old"


def test_a_link_at_the_part_s_name_is_not_written_through(tmp_path: Path) -> None:
    foreign = tmp_path / "foreign"
    foreign.write_bytes(b"mine")
    (tmp_path / ".file.part").symlink_to(foreign)
    write_atomically(tmp_path / "file", b"new")
    assert (tmp_path / "file").read_bytes() == b"new"
    assert foreign.read_bytes() == b"mine"


def test_a_folder_is_made_and_only_the_files_named_are_taken_away(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    assert emptied_folder(folder, "x*") == folder
    for name in ("x1", "y"):
        (folder / name).touch()
    (folder / "x2").symlink_to(folder / "nowhere")
    emptied_folder(folder, "x*", "z")
    assert [path.name for path in folder.iterdir()] == ["y"]
    with pytest.raises(InputFileError, match=r"cannot be written: .*; valid: a folder that can be"):
        emptied_folder(folder / "y")
