"""Runs a campaign on a pool, resumes where it was broken off, and verifies what has ended."""

from __future__ import annotations

import dataclasses
import json
import tempfile
import threading
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_bytes, read_json, read_text
from arjuna_core.files.whole_file import write_atomically
from bringup.campaign.outcome import Outcome, read_outcome, write_outcome
from bringup.campaign.plan import LARGEST, Campaign, CampaignError, Run, runs_of
from bringup.campaign.pool import LOG, Ended, Job, Pool

_CLAIM = "campaign.json"
_NEEDS = ("cpus", "memory")
"""What a campaign takes, which does not change what its runs are of."""


def run_all(
    campaign: Campaign,
    runs: Sequence[Run],
    folder: Path,
    pool: Pool,
    ended: Callable[[Outcome], None],
    stop: threading.Event,
    lost: Callable[[Ended], None] = lambda end: None,
    progress: Callable[[int], None] = lambda going: None,
) -> list[Outcome]:
    """Run what has not been run yet.

    Args:
        ended: Takes each outcome, those of earlier times first.
        stop: Set to break off; unfinished runs are run again next time.
        lost: Takes each run that is given up; it has no outcome and is run again next time.
        progress: Takes how many runs have started and not ended, again and again.

    Returns:
        The outcomes there are, in the order of the runs.

    Raises:
        CampaignError: The folder is another campaign's.
        OSError: A folder cannot be written.
    """
    found, waiting = resumed(campaign, runs, folder)
    for outcome in found.values():
        ended(outcome)
    for end in run_jobs(lambda: waiting.popleft() if waiting else None, pool, stop, progress):
        if end.outcome is None:
            lost(end)
        else:
            found[end.outcome.name] = end.outcome
            ended(end.outcome)
    return [found[run.name] for run in runs if run.name in found]


def resumed(
    campaign: Campaign, runs: Sequence[Run], folder: Path
) -> tuple[dict[str, Outcome], deque[Job]]:
    """Return the outcomes that a folder has, by run, and the jobs that are left.

    Raises:
        CampaignError: The folder is another campaign's.
        OSError: It cannot be written.
    """
    _claim(folder, campaign)
    found = {run.name: read_outcome(folder / run.name) for run in runs}
    waiting = (Job(campaign, run, folder / run.name) for run in runs if found[run.name] is None)
    return {name: one for name, one in found.items() if one is not None}, deque(waiting)


def run_jobs(
    next_job: Callable[[], Job | None],
    pool: Pool,
    stop: threading.Event,
    progress: Callable[[int], None] = lambda going: None,
    tries: int = 3,
    poll: float = 0.1,
) -> Iterator[Ended]:
    """Yield how jobs ended, as they do, their outcomes recorded; what is broken off is stopped.

    Args:
        next_job: Returns a job to start; None while there is none, for good once all have ended.
        tries: How often a job is run whose worker dies, before it is given up.
        poll: The longest wait for a job's end before `stop` is looked at [s].
    """
    going, again = 0, deque[Job]()
    deaths = Counter[Path]()
    try:
        while not stop.is_set():
            while going < pool.capacity and (job := again.popleft() if again else next_job()):
                pool.start(job)
                going += 1
            if not going:
                return
            for end in pool.ended(poll):
                going -= 1
                if end.outcome is not None:
                    write_outcome(end.job.folder, end.outcome)
                    yield end
                    continue
                deaths[end.job.folder] += 1
                if deaths[end.job.folder] < tries:
                    again.append(end.job)
                else:
                    yield end
            progress(going)
    finally:
        pool.stop()


def _claim(folder: Path, campaign: Campaign) -> None:
    """Write down what the folder's runs are of: no other campaign shall take them for its own."""
    content = dataclasses.asdict(campaign)
    text = json.dumps({key: content[key] for key in content if key not in _NEEDS}, indent=2)
    path = folder / _CLAIM
    if not path.exists():
        write_atomically(path, text.encode())
    elif read_text(path) != text:
        raise CampaignError(folder, "has the runs of another campaign; valid: a new folder")


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
