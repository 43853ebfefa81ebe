"""Writes the pages of the reference."""

from __future__ import annotations

from scripts.reference import FOLDER, commands, messages, parameters, topics

PAGES = {
    "commands.md": commands.page,
    "parameters.md": parameters.page,
    "topics.md": topics.page,
    "messages.md": messages.page,
}
"""The writer of each page."""

if __name__ == "__main__":
    for name, page in PAGES.items():
        (FOLDER / name).write_text(page(), encoding="utf-8")
