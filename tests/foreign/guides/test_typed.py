"""The guides' own text, typed as it stands: files at once, all else with -m tutorial."""

from __future__ import annotations

import re
import shlex
from contextlib import ExitStack
from pathlib import Path

import pytest

from bringup import cli
from bringup.cli import parse
from tests.foreign.guides.typed import BESIDE, GUIDES, Row, beside, rows, type_row

pytestmark = pytest.mark.ros
ROWS = [row for guide in GUIDES for row in rows(guide)]
IN_PROCESS = [
    row for row in ROWS if row.is_quick and re.match(r"arjuna params [^|;&>]*$", row.typed)
]


@pytest.mark.parametrize("row", IN_PROCESS, ids=[f"{row.name} {row.file}" for row in IN_PROCESS])
def test_a_guide_s_file_does_what_it_says(
    row: Row, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / row.file).write_text(row.text, encoding="utf-8")
    code = cli.run(parse(shlex.split(row.typed)[1:]))
    given = capsys.readouterr()
    assert row.fails == "any" or code == 0
    assert re.search(row.shows, given.err + given.out)


def test_a_row_is_of_a_known_kind() -> None:
    assert {row.kind for row in ROWS} == {"command", "file", "listing", "promise"}
    assert {row.needs for row in ROWS} == {"", "hardware", "packages", "package"}
    assert {row.beside for row in ROWS} == set(BESIDE)
    assert all(row.shows or row.needs or row.typed for row in ROWS)


@pytest.mark.system
@pytest.mark.tutorial
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("name", BESIDE)
def test_what_a_guide_types_works(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "94")
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    if name == "udacity":  # what it loads is what a row before converts
        (converts,) = [row for row in ROWS if "udacity.yaml" in row.typed]
        assert type_row(converts, tmp_path)[0]
    counted = [
        row for row in ROWS if row.beside == name and not (row.needs or row.lines or row.also)
    ]
    with ExitStack() as opened:
        beside(name, tmp_path, opened)
        failed = {row.name: type_row(row, tmp_path) for row in counted}
    assert {row: printed for row, (well, printed) in failed.items() if not well} == {}
