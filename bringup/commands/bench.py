"""`bench`: measure a part of the robot.

A benchmark has `add_arguments(parser)` and `run(arguments) -> dict`, which prints what it measured
and returns it for `--json`.
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from arjuna_core.errors import InputFileError, nearest
from arjuna_core.files.whole_file import writing

EXAMPLES = ("bench slam",)

_ROOT = Path(__file__).resolve().parents[2]
_FOLDER = _ROOT / "tests" / "bench"


def names() -> list[str]:
    """Return the benchmarks there are; none outside a checkout."""
    return sorted(path.stem for path in _FOLDER.glob("[a-z]*.py"))


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME", help=f"one of: {', '.join(names())}")
    parser.add_argument("options", nargs=argparse.REMAINDER, help="its own; see NAME --help")


def run(arguments: argparse.Namespace) -> int:
    """Run the benchmark that is named."""
    measure(arguments.name, arguments.options)
    return 0


def measure(name: str, argv: Sequence[str]) -> None:
    """Run a benchmark.

    Raises:
        InputFileError: There is no such benchmark, or the JSON file cannot be written.
    """
    if name not in names():
        known = nearest(name, names()) if names() else "they come with a checkout of Arjuna"
        raise InputFileError(_FOLDER / f"{name}.py", f"no such benchmark; {known}")
    sys.path.insert(0, str(_ROOT))
    module = importlib.import_module(f"tests.bench.{name}")
    parser = argparse.ArgumentParser(
        prog=f"python -m bringup bench {name}", description=(module.__doc__ or "").split("\n")[0]
    )
    module.add_arguments(parser)
    parser.add_argument("--json", type=Path, metavar="FILE", help="where to write the numbers")
    arguments = parser.parse_args(argv)
    result = module.run(arguments)
    if arguments.json is not None:
        with writing(arguments.json):
            arguments.json.parent.mkdir(parents=True, exist_ok=True)
            arguments.json.write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
