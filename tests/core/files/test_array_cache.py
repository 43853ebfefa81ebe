"""Files that are whole or not there: arrays kept, atomic writes."""

from __future__ import annotations

import dataclasses
import signal
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import InputFileError
from arjuna_core.files import array_cache
from arjuna_core.files.array_cache import Arrays, cached, content_of
from arjuna_core.files.maps import load_map, save_map
from arjuna_core.files.whole_file import emptied_folder, write_atomically
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2
from tests.helpers.killed import killed


class Maker:
    def __init__(self) -> None:
        self.count = 0

    def make(self) -> Arrays:
        self.count += 1
        return np.arange(1000.0).reshape(10, 100), np.array([self.count])


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "arjuna" / "kind"


def test_it_is_made_once_of_the_same_content() -> None:
    maker = Maker()
    first, second = (cached("kind", (b"a", b"b"), maker.make) for _ in range(2))
    assert maker.count == 1
    for one, other in zip(first, second, strict=True):
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("kind", "made_of"), [("kind", (b"ab", b"")), ("kind", (b"a", b"c")), ("other", (b"a", b"b"))]
)
def test_it_is_made_again_of_other_content(kind: str, made_of: tuple[bytes, ...]) -> None:
    maker = Maker()
    cached("kind", (b"a", b"b"), maker.make)
    assert cached(kind, made_of, maker.make)[1] == 2


@dataclasses.dataclass
class Thing:
    size: float
    values: object = ()
    _known: dict[str, int] = dataclasses.field(default_factory=dict)


def test_a_digest_is_of_all_that_values_hold() -> None:
    values = [
        *(Thing(1.0), Thing(1), Thing(2.0), Thing(1.0, "a"), Thing(1.0, ("a",)), Thing(1.0, ["a"])),
        *(Thing(1.0, np.arange(2)), Thing(1.0, np.arange(2.0)), Thing(1.0, {"a": Thing(1.0)})),
        *(["a", "b"], ["ab"], [["a"], "b"], ["a", ["b"]], {"a"}, Path("a"), b"a", None, True),
    ]
    assert len({content_of(value) for value in values}) == len(values)
    assert content_of(Thing(1.0, _known={"a": 1})) == content_of(Thing(1.0))
    with pytest.raises(TypeError, match="function is neither data nor plain"):
        content_of([Thing(1.0, content_of)])


@pytest.mark.parametrize("damage", [b"", b"PK\3\4", b"\x93NUMPY", None])
def test_it_is_made_again_of_what_is_damaged(folder: Path, damage: bytes | None) -> None:
    maker = Maker()
    cached("kind", (b"a",), maker.make)
    (kept,) = folder.glob("*.npz")
    kept.write_bytes(kept.read_bytes()[:-200] if damage is None else damage)
    assert cached("kind", (b"a",), maker.make)[1] == 2
    assert cached("kind", (b"a",), maker.make)[1] == 2


def test_no_cache_folder_is_needed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert cached("kind", (b"a",), Maker().make)[1] == 1


def test_the_least_recently_used_goes_first(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    maker = Maker()
    monkeypatch.setattr(array_cache, "_BYTES_MAX", 20_000)
    cached("kind", (b"a",), maker.make)
    cached("kind", (b"b",), maker.make)
    cached("kind", (b"a",), maker.make)  # b was used before a now
    cached("kind", (b"c",), maker.make)
    assert sum(path.stat().st_size for path in folder.iterdir()) <= 20_000
    cached("kind", (b"a",), maker.make)
    assert maker.count == 3
    cached("kind", (b"b",), maker.make)
    assert maker.count == 4


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
def test_a_map_pair_survives_a_kill_while_saving(tmp_path: Path, point: str, number: int) -> None:
    save_map(_grid(0, 20), tmp_path / "map")
    ended = killed(lambda: save_map(_grid(100, 30), tmp_path / "map"), point, number)
    assert ended == signal.SIGKILL
    left = load_map(tmp_path / "map.yaml")
    expected = _grid(100, 30) if number > (3 if point == "fsync" else 2) else _grid(0, 20)
    assert left.frame == expected.frame
    assert np.array_equal(left.data, expected.data)
    save_map(_grid(0, 20), tmp_path / "map")  # what the killed one left is in nobody's way
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".pgm", ".yaml"]


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
