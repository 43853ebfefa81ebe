"""Pages that scripts write: reference and guides."""

from __future__ import annotations

import argparse
import ast
from pathlib import Path

import pytest

from bringup.commands import COMMANDS
from scripts.guides_page import ORDER, PAGE, ROOT, page, read, table_of
from scripts.reference import FOLDER, commands, messages
from scripts.reference.commands import _of
from scripts.reference.messages import _errors, _said

REMEDY = "run: python -m scripts.reference"
_SOURCE = '''
class ArjunaError(Exception): ...
class Broken(ArjunaError): ...
class Other(Exception): ...
def act(path):
    """Do."""
    problem = f"{path} has no | wheels"
    if path:
        raise Broken(problem)
    node.get_logger().warning(f"{path}: left " + "alone for now")
    raise Other("nobody sees this")
def found():
    problems = [f"{one} is odd here" for one in two]
    problems.append("and one more problem")
    raise ArjunaError(*problems)
def check():
    yield Finding(f"the {thing} stands still", "push it hard")
'''


def test_the_page_of_commands_is_current() -> None:
    assert (FOLDER / "commands.md").read_text(encoding="utf-8") == commands.page(), REMEDY


def test_the_page_of_messages_is_current() -> None:
    assert (FOLDER / "messages.md").read_text(encoding="utf-8") == messages.page(), REMEDY


def test_every_command_has_its_section() -> None:
    text = commands.page()
    assert all(f"### `{name}`\n" in text for group in COMMANDS.values() for name in group)


def test_options_and_actions_are_listed_with_their_values() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("file", nargs="?", help="what to read")
    parser.add_argument("-o", "--out", metavar="FOLDER", default="x", help="where (%(default)s)")
    parser.add_argument("--level", choices=("a", "b"), help="how much")
    parser.add_argument("--secret", help=argparse.SUPPRESS)
    below = parser.add_subparsers().add_parser("do", help="does it")
    below.add_argument("--both", nargs=2, metavar="N", help="two")
    assert list(_of(parser, "act")) == [
        "| option | meaning |",
        "|---|---|",
        "| `[file]` | what to read |",
        "| `-o FOLDER`, `--out FOLDER` | where (x) |",
        "| `--level a\\|b` | how much |",
        "",
        "`act do`: does it.\n",
        "| option | meaning |",
        "|---|---|",
        "| `--both N N` | two |",
        "",
    ]


def test_messages_are_found_wherever_they_are_made() -> None:
    tree = ast.parse(_SOURCE)
    assert set(_said(tree, _errors([tree]))) == {
        ("... has no | wheels", "error"),
        ("...: left alone for now", "warning"),
        ("... is odd here", "error"),
        ("and one more problem", "error"),
        ("the ... stands still: push it hard", "finding"),
    }


ROWS = [row for guide in ORDER for rows in read(table_of(guide))[1].values() for row in rows]


def test_the_page_is_current() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run: python -m scripts.guides_page"


def test_every_guide_has_its_tables() -> None:
    assert {path.parent.name for path in (ROOT / "guides").glob("*/params.yaml")} == set(ORDER)
    assert len(ROWS) > 250
    assert all(row.theirs and row.here and row.test for row in ROWS)


def test_named_tests_are_there() -> None:
    for test in sorted({row.test for row in ROWS}):
        file, _, name = test.partition("::")
        assert f"def {name or 'test_'}" in (ROOT / file).read_text(encoding="utf-8"), test


def test_a_line_that_is_no_row_is_named(tmp_path: Path) -> None:
    path = tmp_path / "table.txt"
    path.write_text("# A\n\n## B\n\nx | y\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"table\.txt:5: expected 'theirs \| here"):
        read(path)
