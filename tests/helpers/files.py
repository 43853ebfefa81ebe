"""Small files of a test."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from arjuna_core.files.shipped import shipped_file


def written(folder: Path, text: str, name: str = "params.yaml") -> Path:
    """Write a file, below folders of its own too, and return its path."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def changed(folder: Path, file: str, *changes: tuple[str, str]) -> Path:
    """Write a shipped file, texts of it replaced by others in turn, and return its path."""
    text = shipped_file(file).read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return written(folder, text, Path(file).name)


def write_all(folder: Path, files: Mapping[str, str]) -> None:
    """Write files by their texts."""
    for name, text in files.items():
        written(folder, text, name)
