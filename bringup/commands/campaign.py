"""`campaign`: one command many times, and what the runs say together."""

from __future__ import annotations

import argparse
import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

from bringup.parameters import options

if TYPE_CHECKING:
    from collections.abc import Callable

    from bringup.campaign.outcome import Outcome
    from bringup.campaign.plan import Campaign

EXAMPLES = (
    "campaign campaigns/goals.yaml",
    "campaign campaigns/navigation_suite.yaml --level controller mine params=my_controller.yaml",
    "campaign --compare out/one out/other",
)


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file", type=Path, nargs="?", metavar="FILE", help="such as campaigns/demo.yaml"
    )
    options.add(parser, "--out", help="where all goes (out/campaigns/ and its name)")
    options.add(parser, "--jobs")
    parser.add_argument(
        "--level",
        nargs="+",
        action="append",
        default=[],
        metavar=("FACTOR", "LABEL"),
        help="a further level of a factor, and its options as NAME=VALUE; may be given again",
    )
    parser.add_argument(
        "--compare", type=Path, nargs=2, metavar="FOLDER", help="two campaigns that have been run"
    )


def run(arguments: argparse.Namespace) -> int:
    """Run a campaign, going on where it was broken off; return 0 where every run succeeded."""
    from arjuna_core.errors import ArjunaError
    from bringup.campaign.comparison import compared
    from bringup.campaign.plan import load_campaign
    from bringup.campaign.report import outcomes_in
    from bringup.terminal import show

    if arguments.compare is not None:
        first, second = map(outcomes_in, arguments.compare)
        for line in compared(first, second):
            show(line)
        return 0
    if arguments.file is None or arguments.jobs < 1:
        raise ArjunaError("say which campaign to run, with at least one job; --help has both")
    if importlib.util.find_spec("pyarrow") is None:  # said before hours of runs, not after
        raise ModuleNotFoundError(name="pyarrow")
    campaign = load_campaign(arguments.file)
    for factor, label, *given in arguments.level:
        campaign = campaign.with_level(factor, label, given)
    folder = arguments.out or Path("out/campaigns") / campaign.name
    return _run(campaign, folder, arguments.jobs, vars(arguments).get("main"))


def _run(campaign: Campaign, folder: Path, jobs: int, main: Callable[[], int] | None) -> int:
    from bringup.campaign.plan import CampaignError, runs_of
    from bringup.campaign.report import PAGE, share_text, write_page, write_table
    from bringup.campaign.runner import Forks, run_all
    from bringup.terminal import show, stopped_by_signals

    runs, ended, stop = runs_of(campaign), 0, stopped_by_signals()

    def report(outcome: Outcome) -> None:
        nonlocal ended
        ended += 1
        verdict = "ok" if outcome.success else f"FAILED: {outcome.reason}"
        show(f"{ended:5} of {len(runs)}  {outcome.name:40} {outcome.wall_s:7.1f} s  {verdict}")

    try:
        folder, forks = folder.resolve(), Forks(main, _warm_up) if main is not None else None
        outcomes = run_all(campaign, runs, folder, jobs, report, stop, forks=forks)
        if outcomes:
            write_table(folder, outcomes)
            write_page(folder, campaign, outcomes)
    except OSError as error:
        raise CampaignError(folder, f"cannot be written: {error.strerror}") from error
    _, share, interval = share_text(outcomes)
    show(f"{campaign.name}: {share} succeeded ({interval}, 95 %); see {folder / PAGE}")
    return 0 if len(outcomes) == len(runs) and all(one.success for one in outcomes) else 1


def _warm_up() -> None:
    """Import what most runs need: a robot, and its pictures."""
    from bringup.processes.fork import warm_up
    from bringup.stack import (
        EXPLORER_GROUP,
        LOCALIZATION_GROUP,
        NAVIGATION_GROUP,
        SIM_GROUP,
        SLAM_GROUP,
    )

    groups = SIM_GROUP, SLAM_GROUP, LOCALIZATION_GROUP, NAVIGATION_GROUP, EXPLORER_GROUP
    warm_up(groups, also=("bringup.demo.measures", "bringup.viewing.pictures"))
