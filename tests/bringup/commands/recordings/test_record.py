"""Claims: sizes and times are distinguished; a recorder that starts again takes a new folder."""

from __future__ import annotations

from pathlib import Path

import pytest

from bringup.cli import parse
from bringup.commands.recordings.record import next_free


@pytest.mark.parametrize(
    ("text", "limits"),
    [
        ("500MB", (500_000_000, 0.0)),
        ("1KiB", (1024, 0.0)),
        ("90s", (0, 90.0)),
        ("2min", (0, 120.0)),
    ],
)
def test_a_file_ends_by_size_or_time(text: str, limits: tuple[int, float]) -> None:
    assert parse(["record", "--split", text]).split == limits


@pytest.mark.parametrize("text", ["5", "MB", "5 apples", "0s", "-1s"])
def test_what_is_neither_is_refused(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        parse(["record", f"--split={text}"])
    assert "is no size or time; valid: a number with one of b, kb, mb" in capsys.readouterr().err


def test_the_next_free_folder_is_taken(tmp_path: Path) -> None:
    folder = tmp_path / "bag"
    assert next_free(folder) == folder
    folder.mkdir()
    (tmp_path / "bag_2").mkdir()
    assert next_free(folder) == tmp_path / "bag_3"
