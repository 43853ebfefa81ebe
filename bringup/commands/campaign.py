"""`campaign`: one command many times, and what the runs say together."""

from __future__ import annotations

import argparse
import contextlib
import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

from bringup.parameters import options

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bringup.campaign.outcome import Outcome
    from bringup.campaign.plan import Campaign
    from bringup.campaign.pool import Forks, Pool

EXAMPLES = (
    "campaign campaigns/goals.yaml",
    "campaign campaigns/navigation_suite.yaml --level controller mine params=my_controller.yaml",
    "campaign campaigns/goals.yaml --cluster 10.0.0.5:6379 --verify 5",
    "campaign --compare out/one out/other",
)


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file", type=Path, nargs="?", metavar="FILE", help="such as campaigns/demo.yaml"
    )
    options.add(parser, "--out", help="where all goes (out/campaigns/ and its name)")
    options.add(parser, "--jobs", "--cluster")
    parser.add_argument(
        "--verify", type=int, metavar="K", default=0,
        help="run K runs that have ended once more on this machine; their files must be the same",
    )  # fmt: skip
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
    parser.add_argument("--worker", type=int, help=argparse.SUPPRESS)  # a cluster's; its parent


def run(arguments: argparse.Namespace) -> int:
    """Run a campaign, going on where it was broken off; return 0 where every run succeeded."""
    from arjuna_core.errors import ArjunaError
    from arjuna_core.files.whole_file import writing
    from bringup.campaign.comparison import compared
    from bringup.campaign.plan import CampaignError, load_campaign
    from bringup.campaign.report import outcomes_in
    from bringup.campaign.worker import serve
    from bringup.terminal import show

    if arguments.worker is not None:
        serve(_forks(arguments), arguments.worker)
        return 0
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
    with writing(folder, CampaignError):
        return _run(campaign, folder.resolve(), arguments)


def _run(campaign: Campaign, folder: Path, arguments: argparse.Namespace) -> int:
    from bringup.campaign.plan import runs_of
    from bringup.campaign.pool import Progress
    from bringup.campaign.report import PAGE, share_text, write_page, write_table
    from bringup.campaign.runner import run_all
    from bringup.terminal import show, stopped_by_signals

    runs = runs_of(campaign)
    with pool_of(campaign, arguments, _forks(arguments)) as pool:
        stop, progress = stopped_by_signals(), Progress(len(runs), pool)
        outcomes = run_all(
            campaign, runs, folder, pool, progress.ended, stop, progress.lost, progress.show
        )
    if outcomes:
        write_table(folder, outcomes)
        write_page(folder, campaign, outcomes)
    _, share, interval = share_text(outcomes)
    show(f"{campaign.name}: {share} succeeded ({interval}, 95 %); see {folder / PAGE}")
    same = stop.is_set() or _verified(campaign, outcomes, folder, arguments)
    whole = len(outcomes) == len(runs) and all(one.success for one in outcomes)
    return 0 if whole and same else 1


def pool_of(
    campaign: Campaign, arguments: argparse.Namespace, forks: Forks | None = None
) -> contextlib.AbstractContextManager[Pool]:
    """Return where a command's runs are run: `--cluster`, else `--jobs` processes of here."""
    from bringup.campaign.cluster import cluster_pool
    from bringup.campaign.pool import LocalPool
    from bringup.terminal import show

    if arguments.cluster is not None:
        return cluster_pool(arguments.cluster, campaign, arguments.jobs, show)
    return contextlib.nullcontext(LocalPool(arguments.jobs, forks=forks))


def _verified(
    campaign: Campaign, outcomes: Sequence[Outcome], folder: Path, arguments: argparse.Namespace
) -> bool:
    """Show which of some runs that ran once more give other files; return whether none does."""
    from bringup.campaign.pool import LocalPool
    from bringup.campaign.runner import differing
    from bringup.terminal import show

    if not arguments.verify or not outcomes:
        return True
    pool = LocalPool(arguments.jobs, forks=_forks(arguments))
    found = differing(campaign, outcomes, folder, arguments.verify, pool)
    for name, files in found.items():
        show(f"{name}: {f'differs in {files}' if files else 'the same bytes'}")
    same = sum(not files for files in found.values())
    show(f"{same} of {len(found)} runs gave the same bytes once more on this machine")
    return same == len(found)


def _forks(arguments: argparse.Namespace) -> Forks | None:
    from bringup.campaign.pool import forks_of
    from bringup.stack import DEMO_GROUPS

    return forks_of(arguments, DEMO_GROUPS)
