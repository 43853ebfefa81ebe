"""The outcome of a run: its result, judged by the campaign's criteria of success."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_json
from arjuna_core.files.whole_file import write_atomically

_FILE = "outcome.json"


@dataclass(frozen=True)
class Outcome:
    """The outcome of a run.

    Attributes:
        levels: The label of each factor's level.
        reason: Why not; "" if it does.
        wall_s: How long it took [s].
        figures: Numbers of its result, truths as 0 and 1, by dotted key.
    """

    name: str
    levels: Mapping[str, str]
    success: bool
    reason: str
    wall_s: float
    figures: Mapping[str, float]


def judged(result: Mapping[str, Any], success: Mapping[str, Any]) -> str:
    """Return where a result misses values, or `at_least` and `at_most`, by key; "" for nowhere."""
    lacks = []
    for key, wanted in success.items():
        bounds = wanted if isinstance(wanted, dict) else {"is": wanted}
        lacks += [
            f"{key} is {result.get(key)}, not {how.replace('_', ' ')} {bound}".replace(" is ", " ")
            for how, bound in bounds.items()
            if not _fits(result.get(key), how, bound)
        ]
    return "; ".join(lacks)


def _fits(value: Any, how: str, bound: Any) -> bool:
    if how == "is":
        return bool(value == bound)
    if not isinstance(value, int | float):
        return False
    return bool(value >= bound if how == "at_least" else value <= bound)


def figures_of(flat: Mapping[str, Any]) -> dict[str, float]:
    """Return the values that are numbers or truths."""
    return {key: float(value) for key, value in flat.items() if isinstance(value, int | float)}


def write_outcome(folder: Path, outcome: Outcome) -> None:
    """Write an outcome into its run's folder: a run that has one is done."""
    text = json.dumps(dataclasses.asdict(outcome), indent=2)
    write_atomically(folder / _FILE, f"{text}\n".encode())


def read_outcome(folder: Path) -> Outcome | None:
    """Return the outcome of a run's folder; None where it has not ended."""
    try:
        return Outcome(**read_json(folder / _FILE))
    except (InputFileError, TypeError):
        return None


def forget(folder: Path) -> None:
    """Remove a run's outcome, so that it is run again."""
    (folder / _FILE).unlink(missing_ok=True)
