"""Files of docks."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.errors import InputFileError
from arjuna_core.se2 import SE2
from arjuna_nav.docking.database import DOCKS, read_docks, unknown_types


def test_docks_are_read_from_a_file(tmp_path: Path) -> None:
    file = tmp_path / "docks.yaml"
    text = "docks: {home: {type: a, frame: odom, pose: [1, 2.0, 0.5], typ: b}}"
    file.write_text(text, encoding="utf-8")
    warned: list[str] = []
    docks = read_docks(file, warned.append)
    assert warned == [f"{file}: home: unknown parameter 'typ'; the nearest is 'type'"]
    assert docks["home"].docked == SE2(1.0, 2.0, 0.5)
    assert unknown_types(docks, ["a", "b"]) == []
    assert "valid: b" in unknown_types(docks, ["b"])[0]
    assert DOCKS.resolve("opennav_docking::Dock").Config().frame == "map"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("docks: [1]", "expected 'docks"),
        ("{}", "expected 'docks"),
        ("docks: {home: {type: a}}", "pose' is missing"),
        ("docks: {home: {pose: [1, 2]}}", "has 2 numbers"),
        ("docks: {home: {pose: [.nan, 2, 3]}}", "not a number"),
    ],
)
def test_a_file_without_docks_says_what_is_wrong(tmp_path: Path, text: str, says: str) -> None:
    file = tmp_path / "docks.yaml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputFileError, match=says):
        read_docks(file, lambda sentence: None)
