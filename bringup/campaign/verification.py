"""Runs that have ended, once more on this machine: their files must be the same bytes."""

from __future__ import annotations

import json
import tempfile
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_bytes, read_json
from bringup.campaign.outcome import Outcome
from bringup.campaign.plan import LARGEST, Campaign, runs_of
from bringup.campaign.pool import LOG, Job, Pool
from bringup.campaign.runner import run_jobs

_OF_THE_CLOCK = ("wall_", "real_time_factor")
"""How keys of a result begin that say how fast the machine was."""
_OTHERS = (LOG, "outcome.json")


def differing(
    campaign: Campaign, outcomes: Sequence[Outcome], folder: Path, count: int, pool: Pool
) -> dict[str, str]:
    """Return the files that differ, by run, "" where none does, of a count of runs, evenly spread.

    Compared are all files but the log; of the result, all but how fast the machine was.
    """
    ended = {one.name for one in outcomes}
    runs = [run for run in runs_of(campaign) if run.name in ended]
    chosen = [runs[i * len(runs) // min(count, len(runs))] for i in range(min(count, len(runs)))]
    with tempfile.TemporaryDirectory(prefix=".verify-", dir=folder) as again:
        jobs = iter([Job(campaign, run, Path(again) / run.name) for run in chosen])
        for _ in run_jobs(lambda: next(jobs, None), pool, threading.Event()):
            pass
        return {
            run.name: ", ".join(_differing(campaign, folder / run.name, Path(again) / run.name))
            for run in chosen
        }


def _differing(campaign: Campaign, one: Path, other: Path) -> Iterator[str]:
    for name in sorted(_files(one) | _files(other)):
        result = name == campaign.result
        contents = [
            _result(each / name) if result else _bytes(each / name) for each in (one, other)
        ]
        if contents[0] != contents[1]:
            yield name


def _files(folder: Path) -> set[str]:
    paths = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)) for path in paths if path.name not in _OTHERS}


def _bytes(path: Path) -> bytes | None:
    return read_bytes(path, LARGEST) if path.exists() else None


def _result(path: Path) -> bytes | None:
    """Return a result without the clock's values; None where there is none."""
    try:
        return json.dumps(_timeless(read_json(path))).encode()
    except InputFileError:
        return None


def _timeless(value: Any) -> Any:
    if isinstance(value, list):
        return [_timeless(each) for each in value]
    if isinstance(value, dict):
        kept = {key: each for key, each in value.items() if not key.startswith(_OF_THE_CLOCK)}
        return {key: _timeless(each) for key, each in kept.items()}
    return value
