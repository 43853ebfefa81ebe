"""The reference in docs/reference/, written from the code: `python -m scripts.reference`."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "docs" / "reference"
NOTE = "Written from the code by `python -m scripts.reference`; a test checks that it is current."


def cell(text: str) -> str:
    """Return a text as it stands in a cell of a Markdown table."""
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")


def code(text: str) -> str:
    """Return a text as code in a cell of a Markdown table."""
    return f"`{' '.join(text.split())}`".replace("|", "\\|") if text else ""
