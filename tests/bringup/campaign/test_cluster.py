"""A stand-in for the robot on a Ray cluster of this machine: files, versions, deaths, ports."""

from __future__ import annotations

import contextlib
import importlib.util
import itertools
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import bringup
from arjuna_core.errors import ArjunaError
from bringup.campaign.cluster import cluster_pool
from bringup.campaign.outcome import Outcome
from bringup.campaign.plan import Campaign, Level, runs_of
from bringup.campaign.pool import Ended, LocalPool
from bringup.campaign.runner import run_all
from tests.helpers.ray_cluster import ray_cluster

# Ray itself is imported once its environment is set.
_MISSING = importlib.util.find_spec("ray") is None
pytestmark = [
    pytest.mark.skipif(_MISSING, reason="needs the extra `cluster`"),
    pytest.mark.xdist_group("ray"),
    pytest.mark.timeout(300),
]

_ROOT = Path(bringup.__file__).resolve().parents[1]
# It notes that it began in a file that does not travel, and reads files and a module that do.
_PROGRAM = """
import json, pathlib, sys, threading
folder, noted, seconds, _, map_file, _, params, _, seed = sys.argv[1:]
with open(noted.removeprefix("noted:"), "a") as stream:
    print(seed, file=stream, flush=True)
threading.Event().wait(float(seconds))
import own_plugin
image = pathlib.Path(map_file).parent / "image.txt"
pathlib.Path(folder, "sub").mkdir(exist_ok=True)
pathlib.Path(folder, "sub", "copy.bin").write_bytes(bytes(range(256)))
pathlib.Path(folder, "r.json").write_text(json.dumps(
    {"image": len(image.read_text()), "made": own_plugin.made(int(seed))}))
"""
_WORDS = (sys.executable, "-c", _PROGRAM)


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    with ray_cluster({}, {}) as made:
        yield made


@pytest.fixture
def working(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with a map, parameters and a plug-in, which no worker stands in."""
    folder = tmp_path / "home"
    (folder / "maps").mkdir(parents=True)
    (folder / "maps" / "room.yaml").write_text("image: image.txt\nresolution: 0.05\n")
    (folder / "maps" / "image.txt").write_text("a wall")
    (folder / "own.yaml").write_text("Own: {plugin: 'own_plugin:Own'}\n")
    (folder / "own_plugin.py").write_text("def made(seed):\n    return 2 * seed\n")
    monkeypatch.chdir(folder)
    return folder


def _campaign(working: Path, seeds: int, seconds: float = 0.0) -> Campaign:
    map_file = str(working / "maps" / "room.yaml")  # one absolute path, one relative
    files = ("--map", map_file, "--params", "own.yaml")
    command = ("{folder}", f"noted:{working.parent / 'noted'}", str(seconds), *files)
    factors = {"seed": tuple(Level(str(n), {"seed": n}) for n in range(seeds))}
    return Campaign(
        "made", command, "r.json", factors, {"image": 6}, timeout=60.0, cpus=1.0, memory=100.0
    )


def _started(working: Path) -> Counter[str]:
    """Return how often each seed was run."""
    return Counter((working.parent / "noted").read_text(encoding="utf-8").split())


def _begun_on(node: Any, working: Path) -> set[str]:
    """Return the seeds whose runs are on a node and have noted that they began."""
    raylet = node.all_processes["raylet"][0].process.pid
    lines = []
    for process in _descendants(raylet):
        with contextlib.suppress(OSError):  # it ended meanwhile
            lines.append(Path(f"/proc/{process}/cmdline").read_text(encoding="utf-8").split("\0"))
    seeds = {words[-2] for words in lines if any(word.startswith("noted:") for word in words)}
    noted = working.parent / "noted"
    return seeds & set(_started(working)) if noted.exists() else set()


def _run(
    address: str,
    campaign: Campaign,
    folder: Path,
    ended: Callable[[Outcome], None] = lambda outcome: None,
) -> tuple[list[Outcome], list[Ended], list[str]]:
    """Return the outcomes, the runs that were lost and what was shown."""
    lost, shown = list[Ended](), list[str]()
    with cluster_pool(address, campaign, 2, shown.append, _WORDS) as pool:
        given = campaign, runs_of(campaign), folder, pool, ended
        return run_all(*given, threading.Event(), lost.append), lost, shown


def test_runs_on_workers_write_what_they_write_alone(cluster: Any, working: Path) -> None:
    campaign = _campaign(working, 4)
    there, here = working.parent / "there", working.parent / "here"
    outcomes, lost, shown = _run(cluster.address, campaign, there)
    given = campaign, runs_of(campaign), here, LocalPool(2, _WORDS), lambda outcome: None
    alone = run_all(*given, threading.Event())
    assert not lost
    assert all(one.success for one in outcomes)
    assert [(one.name, one.figures) for one in outcomes] == [(o.name, o.figures) for o in alone]
    for name in ("r.json", "sub/copy.bin", "log.txt"):
        files = [folder / "2_2" / name for folder in (there, here)]
        assert files[0].read_bytes() == files[1].read_bytes()
    assert "it asks for a token" in shown[0]


def test_a_node_that_dies_costs_no_run(cluster: Any, working: Path) -> None:
    node = cluster.add_node(num_cpus=1)

    def ended(outcome: Outcome) -> None:
        """Kill the node as it has just begun a run, however late it came."""
        if node in cluster.worker_nodes:
            before, deadline = _begun_on(node, working), time.monotonic() + 60.0
            while not _begun_on(node, working) - before and time.monotonic() < deadline:
                threading.Event().wait(0.05)
            cluster.remove_node(node, allow_graceful=False)

    outcomes, lost, _ = _run(cluster.address, _campaign(working, 9, 1.5), working / "out", ended)
    assert node not in cluster.worker_nodes
    assert [one.success for one in outcomes] == [True] * 9
    assert not lost
    started = _started(working)
    assert max(started.values()) == 2  # what it ran was run once more, elsewhere
    assert sum(started.values()) == 10


_DRIVER = """
import sys, threading
from pathlib import Path
from bringup.campaign.cluster import cluster_pool
from bringup.campaign.plan import runs_of
from bringup.campaign.runner import run_all
from tests.bringup.campaign.test_cluster import _WORDS, _campaign
campaign = _campaign(Path.cwd(), 6, 1.0)
with cluster_pool(sys.argv[1], campaign, 2, print, _WORDS) as pool:
    stop = threading.Event()
    run_all(campaign, runs_of(campaign), Path("out").resolve(), pool,
            lambda one: print("ended", one.name, flush=True), stop)
"""


def test_a_driver_that_is_killed_resumes(cluster: Any, working: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(_ROOT)}
    words = [sys.executable, "-c", _DRIVER, cluster.address]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=environment) as driver:
        assert driver.stdout is not None
        lines = (line for line in driver.stdout if line.startswith("ended"))
        ended = list(itertools.islice(lines, 2))
        driver.send_signal(signal.SIGKILL)
    assert len(ended) == 2
    before = {line.split()[1].partition("_")[0] for line in ended}
    outcomes, lost, _ = _run(cluster.address, _campaign(working, 6, 1.0), working / "out")
    assert [one.success for one in outcomes] == [True] * 6
    assert not lost
    started = _started(working)
    assert max(started.values()) <= 2
    assert all(started[seed] == 1 for seed in before)


def test_a_worker_of_another_version_is_refused_by_name(working: Path) -> None:
    other = working.parent / "other"
    for name in ("arjuna_core", "arjuna_sim", "arjuna_slam", "arjuna_nav", "bringup"):
        shutil.copytree(_ROOT / name, other / name, ignore=shutil.ignore_patterns("__pycache__"))
    with (other / "arjuna_nav" / "__init__.py").open("a") as stream:
        stream.write("# changed\n")
    campaign = _campaign(working, 4, 1.0)
    with ray_cluster({"env_vars": {"PYTHONPATH": str(other)}}) as cluster:
        with pytest.raises(ArjunaError, match=r"no node can run this: node \S+ has Arjuna 0\.1\.0"):
            _run(cluster.address, campaign, working / "none")
        cluster.add_node(num_cpus=1)
        outcomes, lost, shown = _run(cluster.address, campaign, working / "out")
    assert len(outcomes) == 4
    assert not lost
    refused = [line for line in shown if line.startswith("refused: ")]
    assert len(refused) <= 1
    assert all(re.search(r"Arjuna 0\.1\.0 \(files \w+\), not 0\.1\.0", line) for line in refused)


def _descendants(process: int) -> set[int]:
    parents = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            words = stat.read_text(encoding="utf-8").rpartition(")")[2].split()
        except OSError:
            continue  # it ended meanwhile
        parents[int(stat.parent.name)] = int(words[1])
    found = {process}
    while more := {child for child, parent in parents.items() if parent in found} - found:
        found |= more
    return found


_OTHER_VERSION = """
import sys, ray
try:
    ray.init(address=sys.argv[1], logging_level="error")
except Exception as error:
    print("refused", type(error).__name__)
"""


@pytest.mark.skipif(shutil.which("ss") is None, reason="needs ss")
def test_a_cluster_of_this_machine_alone_is_closed(working: Path) -> None:
    import ray

    with cluster_pool("auto", _campaign(working, 1), 1, print, _WORDS):
        address = ray.get_runtime_context().gcs_address
        done = subprocess.run(["ss", "-Hltnp"], capture_output=True, text=True, check=True)
        ours = _descendants(os.getpid())
        listening = [
            line.split()[3]
            for line in done.stdout.splitlines()
            if ours & {int(process) for process in re.findall(r"pid=(\d+)", line)}
        ]
        words = [sys.executable, "-c", _OTHER_VERSION, address]
        environment = {**os.environ, "RAY_AUTH_TOKEN": "1" * 64}
        other_version = subprocess.run(words, capture_output=True, text=True, env=environment)
    assert len(listening) > 4
    assert [one for one in listening if "127.0.0.1" not in one] == []
    assert other_version.stdout.startswith("refused")


@pytest.mark.parametrize(
    ("address", "problem"),
    [
        ("127.0.0.1:1", "no Ray cluster at 127.0.0.1:1: "),
        ("lab", "'lab' is no cluster; valid: HOST"),
    ],
)
def test_no_cluster_at_an_address_is_an_error(address: str, problem: str, working: Path) -> None:
    with (
        pytest.raises(ArjunaError, match=re.escape(problem)),
        cluster_pool(address, _campaign(working, 1), 1, print),
    ):
        pass


def test_a_cluster_that_does_not_start_is_an_error(
    working: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import ray

    def init(**options: Any) -> None:
        raise Exception("The current node timed out during startup. This could happen because")

    monkeypatch.setattr(ray, "init", init)
    problem = "may be too busy or lack memory: The current node timed out during startup$"
    with (
        pytest.raises(ArjunaError, match=problem),
        cluster_pool("auto", _campaign(working, 1), 1, print),
    ):
        pass
