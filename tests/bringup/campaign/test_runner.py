"""Runs of a stand-in for the robot: judged, resumed, each failure with its reason."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
import threading
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from bringup.campaign.comparison import compared
from bringup.campaign.outcome import Outcome
from bringup.campaign.plan import Campaign, CampaignError, Level, runs_of
from bringup.campaign.pool import Ended, Job, LocalPool
from bringup.campaign.report import PAGE, PAPER, TABLE, outcomes_in, write_page, write_table
from bringup.campaign.runner import run_all

# folder, --seed N: seed 2 fails, 3 breaks, 4 hangs
_PROGRAM = """
import json, pathlib, sys, threading
folder, _, seed = sys.argv[1:]
if seed == "3":
    sys.exit("no such thing")
if seed == "4":
    threading.Event().wait(60)
touches = 1 if seed == "2" else 0
(pathlib.Path(folder) / "r.json").write_text(json.dumps(
    {"reached": True, "drive": {"touches": touches, "time_s": 10.0 + int(seed)}, "log": [1, 2]}))
"""


def _campaign(seeds: int, limit: float = 30.0) -> Campaign:
    factors = {"seed": tuple(Level(str(n), {"seed": n}) for n in range(seeds))}
    success = {"reached": True, "drive.touches": {"at_most": 0}}
    return Campaign("made", ("{folder}",), "r.json", factors, success, (), limit)


def _run(
    campaign: Campaign, folder: Path, reported: list[Outcome] | None = None, jobs: int = 2
) -> list[Outcome]:
    program = (sys.executable, "-c", _PROGRAM)
    ended = (reported if reported is not None else []).append
    pool = LocalPool(jobs, program)
    return run_all(campaign, runs_of(campaign), folder, pool, ended, threading.Event())


@pytest.fixture(scope="module")
def four(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Outcome]]:
    """The folder and the outcomes of four runs, two at a time."""
    folder = tmp_path_factory.mktemp("four")
    return folder, _run(_campaign(4), folder)


def test_runs_are_judged_by_their_results(four: tuple[Path, list[Outcome]]) -> None:
    folder, outcomes = four
    assert [one.success for one in outcomes] == [True, True, False, False]
    assert outcomes[1].figures == {"reached": 1.0, "drive.touches": 0.0, "drive.time_s": 11.0}
    assert outcomes[2].reason == "drive.touches 1, not at most 0"
    assert outcomes[3].reason == "exit code 1, no result; no such thing"
    assert (folder / "3_3" / "log.txt").read_text(encoding="utf-8") == "no such thing\n"


_FORKS = """
import json, os, sys, threading
from pathlib import Path
from bringup.campaign.plan import Campaign, Level, runs_of
from bringup.campaign.pool import Forks, LocalPool
from bringup.campaign.runner import run_all

def main():
    Path(sys.argv[1], "r.json").write_text(json.dumps({"parent": os.getppid()}))
    return 0

forks = Forks(main, lambda: print("warm", flush=True))
factors = {"seed": tuple(Level(str(n), {"seed": n}) for n in range(2))}
success = {"parent": os.getpid()}
campaign = Campaign("made", ("{folder}",), "r.json", factors, success)
program = sys.executable, "-m", "made"
for _ in range(2):  # the second time nothing is left to run
    stop, folder = threading.Event(), Path(sys.argv[1])
    pool = LocalPool(2, program, forks)
    found = run_all(campaign, runs_of(campaign), folder, pool, lambda one: None, stop)
    print([one.success for one in found], flush=True)
"""


def test_runs_are_forks_of_what_is_imported_once(tmp_path: Path) -> None:
    words = [sys.executable, "-c", _FORKS, str(tmp_path)]  # what runs tests has threads
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.splitlines() == ["warm", "[True, True]", "[True, True]"]


def test_a_run_without_end_is_ended(tmp_path: Path) -> None:
    endless = {"seed": (Level("4", {"seed": 4}),)}
    (outcome,) = _run(dataclasses.replace(_campaign(1, limit=1.0), factors=endless), tmp_path)
    assert outcome.reason == "took longer than 1 s"


def test_what_has_been_run_is_not_run_again(tmp_path: Path) -> None:
    first = _run(_campaign(3), tmp_path)
    (tmp_path / "1_1" / "outcome.json").unlink()
    (tmp_path / "0_0" / "log.txt").unlink()
    reported: list[Outcome] = []
    again = _run(_campaign(3), tmp_path, reported)
    assert [one.name for one in reported] == ["0_0", "2_2", "1_1"]
    assert not (tmp_path / "0_0" / "log.txt").exists()
    assert [one.figures for one in again] == [one.figures for one in first]


def test_a_folder_is_of_one_campaign(tmp_path: Path) -> None:
    _run(_campaign(1), tmp_path)
    with pytest.raises(CampaignError, match="has the runs of another campaign"):
        _run(_campaign(2), tmp_path)


def test_a_campaign_broken_off_leaves_no_outcome(tmp_path: Path) -> None:
    campaign, stop = _campaign(1), threading.Event()
    stop.set()
    pool = LocalPool(1)
    assert run_all(campaign, runs_of(campaign), tmp_path, pool, lambda outcome: None, stop) == []


class _Dying:
    """A pool whose workers die under a run as often as it is said."""

    slots, capacity = 2, 3

    def __init__(self, deaths: dict[str, int]) -> None:
        self._deaths, self._going = deaths, list[Job]()
        self.started: list[str] = []
        self.most = 0

    def start(self, job: Job) -> None:
        self.started.append(job.run.name)
        self._going.append(job)
        self.most = max(self.most, len(self._going))

    def ended(self, timeout: float) -> list[Ended]:
        job = self._going.pop(0)
        name = job.run.name
        if self._deaths.get(name, 0) > 0:
            self._deaths[name] -= 1
            return [Ended(job, None, f"node of {name} died")]
        job.folder.mkdir(exist_ok=True)
        return [Ended(job, Outcome(name, {}, True, "", 1.0, {}))]

    def stop(self) -> None:
        self._going.clear()


def test_a_run_whose_worker_dies_is_tried_thrice_then_lost(tmp_path: Path) -> None:
    campaign, pool, lost = _campaign(6), _Dying({"1_1": 2, "4_4": 3}), list[Ended]()
    given = campaign, runs_of(campaign), tmp_path
    ended: list[Outcome] = []
    found = run_all(*given, pool, ended.append, threading.Event(), lost.append)
    assert [one.name for one in found] == ["0_0", "1_1", "2_2", "3_3", "5_5"]
    assert sorted(one.name for one in ended) == sorted(one.name for one in found)
    assert [(end.job.run.name, end.cause) for end in lost] == [("4_4", "node of 4_4 died")]
    assert [pool.started.count(f"{n}_{n}") for n in range(6)] == [1, 3, 1, 1, 3, 1]
    assert pool.most == pool.capacity
    again = _Dying({})
    assert len(run_all(*given, again, ended.append, threading.Event())) == 6
    assert again.started == ["4_4"]  # what was lost has no outcome


def test_table_and_page_hold_every_run_and_are_the_same_whatever_the_jobs(
    tmp_path: Path, four: tuple[Path, list[Outcome]]
) -> None:
    folder, outcomes = four
    write_table(folder, outcomes)
    table = pq.read_table(folder / TABLE).to_pydict()
    assert table["seed"] == ["0", "1", "2", "3"]
    assert table["drive.time_s"] == [10.0, 11.0, 12.0, None]
    written = []
    for each, found in (four, (tmp_path, _run(_campaign(4), tmp_path, jobs=1))):
        write_page(each, _campaign(4), found)
        paths = [each / PAGE, *sorted((each / PAPER).iterdir())]
        written.append({path.name: path.read_bytes() for path in paths})
    assert written[0] == written[1]
    page = written[0][PAGE].decode()
    assert "<td>2 of 4</td><td>15.0 to 85.0 %</td>" in page
    assert '<a href="3_3/">3_3</a>' in page
    assert page.count("data:image/png") == 3


def test_two_campaigns_are_compared(tmp_path: Path, four: tuple[Path, list[Outcome]]) -> None:
    _run(_campaign(2), tmp_path / "other")
    lines = compared(outcomes_in(four[0]), outcomes_in(tmp_path / "other"))
    assert lines[1].split() == ["success", "2", "of", "4", "2", "of", "2", "0.467"]
    assert lines[-1].split()[:3] == ["drive.time_s", "11", "10.5"]
    with pytest.raises(CampaignError, match="holds no runs"):
        outcomes_in(tmp_path / "nowhere")
