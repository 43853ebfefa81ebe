"""`tune`: parameters searched by machine, trial by trial."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

from bringup.commands.campaign import pool_of
from bringup.parameters import options

if TYPE_CHECKING:
    from bringup.campaign.pool import Pool
    from bringup.tuning.plan import Tuning
    from bringup.tuning.study import Study, Tried

EXAMPLES = (
    "tune campaigns/tuning/race_track.yaml",
    "tune campaigns/tuning/race_track.yaml --trials 100",
)


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="such as campaigns/tuning/race_track.yaml"
    )
    parser.add_argument(
        "--trials", type=int, metavar="N", help="how many in all, those of earlier times too"
    )
    options.add(parser, "--out", help="where all goes (out/tuning/ and its name)")
    parser.add_argument(
        "--at-once", type=int, metavar="N", default=1,
        help="trials side by side (1); another number gives other trials, any pool the same",
    )  # fmt: skip
    options.add(parser, "--jobs", "--cluster")


def run(arguments: argparse.Namespace) -> int:
    """Run a tuning, going on where it was broken off; return 0 where all its trials were run."""
    from arjuna_core.errors import ArjunaError
    from bringup.tuning.plan import known_parameters, load_tuning

    counts = arguments.jobs, arguments.at_once, arguments.trials
    if any(count is not None and count < 1 for count in counts):
        raise ArjunaError("--jobs, --at-once and --trials are at least 1")
    tuning = load_tuning(arguments.file, known_parameters)
    if arguments.trials is not None:
        tuning = dataclasses.replace(tuning, trials=arguments.trials)
    with pool_of(tuning.campaign, arguments) as pool:
        folder = arguments.out or Path("out/tuning") / tuning.campaign.name
        return _run(tuning, folder, pool, arguments.at_once)


def _run(tuning: Tuning, folder: Path, pool: Pool, at_once: int) -> int:
    from arjuna_core.files.whole_file import writing
    from bringup.campaign.plan import CampaignError
    from bringup.terminal import show, stopped_by_signals
    from bringup.tuning.picture import PICTURE, write_picture
    from bringup.tuning.tuner import BEST, Tuner

    with writing(folder, CampaignError):
        tuner = Tuner(tuning, folder.resolve(), pool, stopped_by_signals(), at_once)

        def report(one: Tried) -> None:
            best = tuner.study.ranked()[0]
            mark = "  best so far" if one == best else ""
            show(f"{one.number + 1:5} of {tuning.trials}  {tuner.verdict(one)}{mark}")

        complete = tuner.run(report)
        for end in tuner.lost:
            show(f"LOST  {end.job.folder}: {end.cause}; the same words try it again")
        if tuner.study.tried():
            write_picture(folder, tuning, tuner.study)
            for line in [*_table(tuning, tuner.study), *(tuner.confirm() if complete else [])]:
                show(line)
            show(f"best parameters: {folder / BEST}; what mattered: {folder / PICTURE}")
    return 0 if complete else 1


def _table(tuning: Tuning, study: Study) -> list[str]:
    """Return lines with each parameter's value now, that of the best, and how much it mattered."""
    best, shares = study.ranked()[0], study.importance()
    lines = [f"\n{'':64}{'now':>10}{'best':>10}  mattered"]
    for one in tuning.dimensions:
        values = one.now, best.values[one.name]
        both = [f"{each:.4g}" if isinstance(each, float) else str(each) for each in values]
        share = f"{100.0 * shares[one.name]:5.0f} %" if shares else "     ?"
        lines.append(f"{one.name:64}{both[0]:>10}{both[1]:>10}  {share}")
    return lines
