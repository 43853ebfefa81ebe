"""The page docs/extending.md, as the tests read it that follow it."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]


def section(heading: str) -> str:
    """Return the text below a heading of the page."""
    page = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
    return page.partition(f"## {heading}\n")[2].partition("\n## ")[0]


def files_of(heading: str) -> list[Path]:
    """Return the files that a section links to."""
    return [ROOT / name for name in re.findall(r"\]\(\.\./(.+?)\)", section(heading))]
