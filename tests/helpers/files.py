"""Small files of a test."""

from __future__ import annotations

from pathlib import Path


def written(folder: Path, text: str, name: str = "params.yaml") -> Path:
    """Write a file and return its path."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path
