"""Arrays are made once of the same content, and again of what is damaged, other or gone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arjuna_core.files import array_cache
from arjuna_core.files.array_cache import Arrays, cached


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


@pytest.mark.parametrize("damage", [b"", b"PK\3\4", b"\x93NUMPY", None])
def test_it_is_made_again_of_what_is_damaged(folder: Path, damage: bytes | None) -> None:
    maker = Maker()
    cached("kind", (b"a",), maker.make)
    (kept,) = folder.glob("*.npz")
    kept.write_bytes(kept.read_bytes()[:-200] if damage is None else damage)
    assert cached("kind", (b"a",), maker.make)[1] == 2
    assert cached("kind", (b"a",), maker.make)[1] == 2


def test_it_is_made_where_nothing_can_be_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert cached("kind", (b"a",), Maker().make)[1] == 1


def test_what_was_not_used_for_longest_goes_first(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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
