"""Small files of a test."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path


def written(folder: Path, text: str, name: str = "params.yaml") -> Path:
    """Write a file, below folders of its own too, and return its path."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def write_all(folder: Path, files: Mapping[str, str]) -> None:
    """Write files by their texts."""
    for name, text in files.items():
        written(folder, text, name)
