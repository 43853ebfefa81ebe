"""Claims: the one door opens regular files alone, and bounds what is read of them.

What is put in the place of each kind of file: `tests/fuzz/test_attacks.py`.
"""

from __future__ import annotations

import gzip
import os
import re
from pathlib import Path

import pytest

from arjuna_core.errors import ArjunaError, ConfigError, InputFileError, MapError
from arjuna_core.files import input_file
from arjuna_core.files.input_file import (
    check_growth,
    head_of,
    open_file,
    read_bytes,
    read_json,
    read_lines,
    read_text,
)
from arjuna_core.files.yaml_file import read_yaml


@pytest.fixture
def path(tmp_path: Path) -> Path:
    (tmp_path / "file").write_bytes(b"12345")
    return tmp_path / "file"


@pytest.mark.parametrize("name", ["arjuna_rom.yaml", "Arjuna_room.yml"])
def test_a_missing_file_is_named_with_the_nearest_of_its_folder(tmp_path: Path, name: str) -> None:
    for other in ("arjuna_room.yaml", "office.yaml"):
        (tmp_path / other).touch()
    nearest = re.escape(f"No such file or directory; the nearest is '{tmp_path}/arjuna_room.yaml'")
    with pytest.raises(InputFileError, match=rf"{nearest}$"):
        read_text(tmp_path / name)
    with pytest.raises(InputFileError, match=r"No such file or directory$"):
        read_text(tmp_path / "none" / name)


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("a:\n\tb: 1\n", "line 2, column 1"),
        ("a:\n  b: 1\n\tc: 2\n", "line 3, column 1"),
        ("a:\r\n  b:\r\n  \tc: 2\r\n", "line 3, column 3"),
    ],
)
def test_a_tab_that_indents_yaml_is_called_one(path: Path, text: str, where: str) -> None:
    path.write_bytes(text.encode())
    with pytest.raises(InputFileError, match=f"{where}: is no YAML: a tab indents; valid: spaces"):
        read_yaml(path)


def test_a_file_is_read_up_to_its_bound(path: Path) -> None:
    assert read_bytes(path, 5) == b"12345"
    with pytest.raises(MapError, match=r"file: has 5 bytes; at most 4 are read"):
        read_bytes(path, 4, MapError)
    assert head_of(path, 3) == b"123"
    assert head_of(path.with_name("none"), 3) == b""


def test_a_file_whose_size_is_not_known_is_read_up_to_its_bound() -> None:
    assert Path("/proc/self/maps").stat().st_size == 0
    with pytest.raises(InputFileError, match="more than 100 bytes"):
        read_bytes(Path("/proc/self/maps"), 100)


def test_what_takes_too_long_is_given_up(path: Path) -> None:
    with pytest.raises(InputFileError, match="cannot be read within 0 s"):
        read_bytes(path, 5, within=0.0)


@pytest.mark.parametrize("name", ["none", "x" * 300, "a\0b", "file/below", "circle"])
def test_what_cannot_be_opened_is_refused(path: Path, name: str) -> None:
    path.with_name("circle").symlink_to(path.with_name("circle"))
    with pytest.raises(InputFileError, match="cannot be read: ") as caught:
        open_file(path.with_name("file").parent / name)
    assert len(str(caught.value)) <= 500


def test_a_pipe_put_in_place_is_refused(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pipe = path.with_name("pipe")
    os.mkfifo(pipe)
    opened = input_file._descriptor_of
    monkeypatch.setattr(input_file, "_descriptor_of", lambda name, flags: opened(str(pipe), flags))
    with pytest.raises(InputFileError, match="it is no file"):
        open_file(path)


def test_no_descriptor_is_left_open_by_what_is_refused(path: Path) -> None:
    before = list(Path("/proc/self/fd").iterdir())
    for _ in range(3):
        with pytest.raises(InputFileError, match="at most 4"):
            open_file(path, largest=4)
    assert len(list(Path("/proc/self/fd").iterdir())) == len(before)


def test_text_and_json_are_what_they_should_be(path: Path) -> None:
    assert read_text(path) == "12345"
    assert read_json(path) == 12345
    path.write_bytes(b"\xff{")
    with pytest.raises(InputFileError, match="is no UTF-8 text"):
        read_text(path)
    with pytest.raises(InputFileError, match="is no JSON"):
        read_json(path)
    path.write_text(f"[{'0,' * 1_000_000}0]")
    with pytest.raises(InputFileError, match="more than 1000000 values"):
        read_json(path)


def test_lines_are_unpacked_and_no_longer_than_they_may_be(path: Path) -> None:
    packed = path.with_name("a.log.gz")
    packed.write_bytes(gzip.compress(b"1\n22\n333"))
    assert [line for line, _ in read_lines(packed)] == [b"1\n", b"22\n", b"333"]
    assert [share for _, share in read_lines(path)] == [1.0]
    with pytest.raises(InputFileError, match="a line of more than 2 bytes"):
        list(read_lines(packed, 2))


def test_growth_is_bounded_where_it_is_large() -> None:
    check_growth(Path("a"), 1, 1000, 1000)
    check_growth(Path("a"), 10, 2000, 1000)
    with pytest.raises(MapError, match="10 bytes of it unpack to 2001 or more; valid: up to 200"):
        check_growth(Path("a"), 10, 2001, 1000, MapError)


def test_no_error_is_longer_than_can_be_read() -> None:
    errors = (
        InputFileError("a" * 4000, "b\n" * 4000, "c" * 4000),
        ArjunaError("a" * 4000 + "end"),
        ConfigError("a" * 4000),
    )
    assert [len(str(error)) for error in errors] == [500, 500, 500]
    assert re.fullmatch(r"a+ \.\.\. a+: c+ \.\.\. c+: [b ]+\.\.\.[b ]+", str(errors[0]))
    assert str(errors[1]).endswith("aend")
    assert str(InputFileError("a", "b", "c")) == "a: c: b"
