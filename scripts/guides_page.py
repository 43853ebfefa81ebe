"""Writes docs/guides.md from the tables in guides/: `python -m scripts.guides_page`.

A table is a text file: `# GUIDE`, `## TABLE`, and rows `what the guide has | what does it | test`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "guides.md"
ORDER = ("arjuna", "fusion", "ros2", "turtlebot3", "where_am_i")
_INTRO = """# The guides, row by row

Everything that the five guides name in their tables of topics, commands, parameters and errors,
what does it here, and the test that proves it. Written by `python -m scripts.guides_page` from
`guides/*/table.txt`; tests check that it is current, that every test is there and that every
parameter exists. The lessons themselves are in [tutorial/](tutorial/README.md).
"""


@dataclass(frozen=True)
class Row:
    """One row.

    Attributes:
        theirs: What the guide has.
        here: What does it here.
        test: A test's file, and its name behind `::` where it is one of many.
    """

    theirs: str
    here: str
    test: str


def read(path: Path) -> tuple[str, dict[str, list[Row]]]:
    """Return a guide's title, and its tables by their names.

    Raises:
        ValueError: A line is neither heading nor row.
    """
    title, rows = "", list[Row]()
    tables: dict[str, list[Row]] = {}
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if line.startswith("## "):
            rows = tables.setdefault(line[3:], [])
        elif line.startswith("# "):
            title = line[2:]
        elif line:
            parts = line.split(" | ")
            if len(parts) != 3:
                raise ValueError(f"{path}:{number}: expected 'theirs | here | test', got {line!r}")
            rows.append(Row(*parts))
    return title, tables


def table_of(guide: str) -> Path:
    """Return where a guide's tables are."""
    return ROOT / "guides" / guide / "table.txt"


def page() -> str:
    """Return the page."""
    return "\n".join([_INTRO, *(line for guide in ORDER for line in _guide(guide))]) + "\n"


def _guide(guide: str) -> Iterator[str]:
    title, tables = read(table_of(guide))
    yield f"## {title}"
    for name, rows in tables.items():
        yield f"\n### {name}\n"
        yield "| theirs | here | proved by |"
        yield "|---|---|---|"
        for row in rows:
            file, _, test = row.test.partition("::")
            shown = test or Path(file).stem
            yield f"| {row.theirs} | {row.here} | [{shown}](../{file}) |"
    yield ""


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
