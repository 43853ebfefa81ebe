"""The commands of `arjuna`, a file each: docs/extending.md says how to add one.

A file's first line is "`name`: what it does.", which the first page shows. It has `EXAMPLES`, words
to type after `python -m bringup`, shown by its `--help`; `configure(parser)`, argparse only, so
that `--help` is instant; and `run(arguments)`, which imports what it needs, raises ArjunaError
where an input cannot be used, and returns the exit code.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

_FOLDER = Path(__file__).parent
_HEADINGS = {
    "Learn": "lesson homework grade class",
    "Run the robot": "sim slam nav robot demo",
    "Drive": "teleop avoid goto tour explore initial-pose save-map",
    "See": "view",
    "Look into it": "doctor top tf params messages",
    "The world": "entity world",
    "Recordings": "record play info replay",
    "Measure": "calibrate goals bench campaign tune",
}
_OTHERS = "Others"


def _files() -> dict[str, Path]:
    found = (path for path in sorted(_FOLDER.rglob("*.py")) if path.stem != "__init__")
    return {path.stem.replace("_", "-"): path for path in found}


def _abouts() -> dict[str, dict[str, str]]:
    """Return what each command does, by the first page's headings and in its order."""
    abouts = {}
    for name, path in _files().items():
        with path.open(encoding="utf-8") as file:
            abouts[name] = file.readline().partition(": ")[2].strip().strip('"').rstrip(".")
    page = {
        heading: {name: abouts.pop(name) for name in names.split()}
        for heading, names in _HEADINGS.items()
    }
    return {**page, _OTHERS: abouts} if abouts else page


COMMANDS = _abouts()


def module_of(command: str) -> Any:
    """Import a command's file."""
    parts = _files()[command].relative_to(_FOLDER).with_suffix("").parts
    return importlib.import_module(".".join(("bringup.commands", *parts)))
