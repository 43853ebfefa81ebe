"""The pace of everything in one table: demo, steps, deliveries, starts, kernels; over commits."""

from __future__ import annotations

import argparse
import cProfile
import importlib
import json
import os
import re
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing, redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from nav_msgs.msg import Odometry

from arjuna_core.errors import ArjunaError
from arjuna_core.files.shipped import shipped_file
from arjuna_core.ros import qos
from arjuna_core.ros.process import Process, Transport
from arjuna_core.se2 import SE2
from bringup.cli import parse
from bringup.client.goals import Goals
from bringup.commands import COMMANDS
from bringup.lockstep import LockStep
from bringup.parameters.files import merged, shipped_parameters
from bringup.scenarios.drive import placed
from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SIM_GROUP
from tests.bench import run as measured
from tests.bench import sim
from tests.bench.stack import started
from tests.helpers.nav.navfn_maps import rooms
from tests.helpers.nav.planners import make
from tests.helpers.sampling import Samples
from tests.sim.builders import ROOM, simulator

KNOWN = Path(__file__).with_suffix(".json")
_ROOT = Path(__file__).resolve().parents[2]
_SAID, _FAILS = 0.05, 0.25  # growth since the last record
_DELIVERIES, _ROUNDS = 2000, 3
_CALLS = "calls a step"
KERNELS = (
    ("NavFn 4000^2, far", "planner", "--sizes --maps 0", "arrays/rooms 4000, far/ratio", 0.7),
    ("NavFn 4000^2, 5 m", "planner", "", "arrays/rooms 4000, 5 m/ms", 10.0),
    ("costmap update", "costmap", "--edge 1000", "local_scan", 0.5),
    ("MPPI 2000 x 56", "controller", "--only mppi", "mppi/ms", 1.0),
    *(
        (f"MPPI {batch}", "controller", "", f"mppi {batch}/ratio", 1.0)
        for batch in (500, 1000, 2000)
    ),
)
"""Name, benchmark, its options (none: of the row before), number, and goal [ms, or ratio]."""


class SlowerError(ArjunaError):
    """A step takes many more calls than in the last record."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument(
        "--short", action="store_true", help=f"only counts to compare with {KNOWN.name}, for CI"
    )
    parser.add_argument(
        "--record", action="store_true", help=f"with --short: write {KNOWN.name} for later runs"
    )
    parser.add_argument(
        "--functions", type=int, default=0, help="show so many functions that take the steps' time"
    )
    parser.add_argument(
        "--history", type=Path, metavar="FILE", help="append a row; plot all beside it, as .png"
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Measure and print one table.

    Returns:
        Each row's number by its name; of the short form the counts that `speed.json` holds.
    """
    if arguments.short:
        return _short(arguments.record)
    result: dict[str, float] = {}
    for name, value, unit, goal in _rows(arguments.functions):
        result[name] = value
        print(
            f"{name:34}{value:10.3f} {unit:16}{'' if goal is None else f'goal {goal:g}'}",
            flush=True,
        )
    if arguments.history is not None:
        _append(arguments.history, result)
    return result


def _rows(functions: int) -> Iterator[tuple[str, float, str, float | None]]:
    """Yield name, value, unit and goal."""
    _, alone = sim.paired_factors(simulator(ROOM), 30.0)
    yield "mj_step alone", alone, "x of a core", None
    yield from _demo(alone, functions)
    for transport in ("local", "dds"):
        yield f"delivery, {transport}", 1e6 * _delivery(transport), "us", None
    for command in (name for group in COMMANDS.values() for name in group):
        yield f"{command} --help", _help(command), "CPU s", None
    room = str(shipped_file("maps/arjuna_room.yaml"))
    for words in (("sim",), ("nav", "--map", room), ("slam",)):
        start_time = time.monotonic()
        with started(*words):
            yield f"{words[0]} to active", time.monotonic() - start_time, "s", None
    yield from _kernels()


def _demo(alone: float, functions: int) -> Iterator[tuple[str, float, str, float | None]]:
    with TemporaryDirectory() as folder:
        chosen = parse(["demo", "--seed", "0", "--out", folder, "--log-level", "error"])
        start_time, spent = time.monotonic(), time.process_time()
        with Samples() as samples:
            if chosen.run(chosen) != 0:
                raise ArjunaError("the demo failed; see above")
        cpu, wall = time.process_time() - spent, time.monotonic() - start_time
        simulated = json.loads((Path(folder) / "report.json").read_text())["sim_time_s"]
    yield "demo", simulated / wall, "x real time", 10.0
    yield "demo, CPU", cpu, "s", None
    yield "demo, CPU by mj_step's", cpu * alone / simulated, "x", None
    total = sum(samples.parts.values())
    for part in sorted(samples.parts, key=samples.parts.__getitem__, reverse=True):
        goal = 15.0 if part == "plumbing" else None
        yield f"step: {part}", 100.0 * samples.parts[part] / total, "% of the steps", goal
    for node in sorted(samples.nodes, key=samples.nodes.__getitem__, reverse=True):
        yield f"node: {node}", 1e3 * samples.nodes[node] / simulated, "CPU ms / s", None
    for name in sorted(samples.functions, key=samples.functions.__getitem__, reverse=True)[
        :functions
    ]:
        yield name, 100.0 * samples.functions[name] / total, "% of the steps", None


def _delivery(transport: Transport) -> float:
    """Return the CPU time of one message from a node to another of its process [s]."""
    received: list[Any] = []
    process = Process("bench", isolated=True, transport=transport)
    with closing(process):
        node = process.make_node("bench_node")
        node.create_subscription(Odometry, "bench", received.append, qos.DEFAULT)
        publisher, message = node.create_publisher(Odometry, "bench", qos.DEFAULT), Odometry()
        process.drain()
        start_time = time.process_time()
        for _ in range(_DELIVERIES):
            publisher.publish(message)
            process.drain()
        spent = time.process_time() - start_time
        node.destroy_node()
    assert len(received) == _DELIVERIES, f"{len(received)} of {_DELIVERIES} arrived"
    return spent / _DELIVERIES


def _help(*words: str) -> float:
    """Return the CPU time of a command's `--help` [s]."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "bringup", *words, "--help"]
    subprocess.run(command, cwd=_ROOT, env=environment, stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def _kernels() -> Iterator[tuple[str, float, str, float | None]]:
    numbers: dict[str, Any] = {}
    for name, bench, options, where, goal in KERNELS:
        if options:
            numbers = _bench(bench, options)
        value: Any = numbers
        for key in where.split("/"):
            value = value.get(key, {})
        if value != {}:  # there is no compiler for the peer
            yield name, value, "x of C arrays" if where.endswith("ratio") else "ms", goal
    yield "Hybrid Reeds-Shepp, 18 m", 1e3 * _hybrid(), "ms", 8.0


def _bench(name: str, options: str) -> dict[str, Any]:
    return measured(importlib.import_module(f"tests.bench.{name}"), *options.split())


def _hybrid() -> float:
    costmap, planner = rooms(500, 0), make("smac hybrid")

    def plan() -> None:
        result = planner.plan(costmap, SE2(1.0, 1.0), SE2(14.0, 14.0))
        assert len(result.path), result.message

    plan()
    return min(_cpu(plan) for _ in range(5))


def _cpu(call: Callable[[], object]) -> float:
    before = time.process_time()
    call()
    return time.process_time() - before


def _short(record: bool) -> dict[str, Any]:
    """Print counts that depend little on the machine, and what grew since the last record.

    Raises:
        SlowerError: The calls grew by more than a quarter.
    """
    _drive(lambda: None)  # what is imported and compiled at first
    profile = cProfile.Profile()
    steps = _drive(profile.enable)[1]
    profile.disable()
    counts = {_CALLS: sum(entry.callcount for entry in profile.getstats()) / steps}
    measures = {"mj_step": lambda: 1.0 / sim.paired_factors(simulator(ROOM), 20.0)[1], **_COUNTED}
    with redirect_stdout(StringIO()):
        rounds = [{name: one() for name, one in measures.items()} for _ in range(_ROUNDS)]
    best = {name: min(one[name] for one in rounds) for name in measures}
    counts |= {f"{name} by mj_step's": best[name] / best["mj_step"] for name in _COUNTED}
    known = json.loads(KNOWN.read_text(encoding="utf-8")) if KNOWN.exists() else {}
    growths = {name: count / known.get(name, count) - 1.0 for name, count in counts.items()}
    for name, count in counts.items():
        remark = "  GREW" if growths[name] > _SAID else ""
        print(f"{name:42}{count:10.4g}{growths[name]:+8.1%}{remark}")
    if record:
        rounded = {name: float(f"{count:.5g}") for name, count in counts.items()}
        KNOWN.write_text(json.dumps(rounded, indent=2) + "\n", encoding="utf-8")
    elif growths[_CALLS] > _FAILS:  # it alone is the same on every machine
        grown = f"{_CALLS} {growths[_CALLS]:+.0%}"
        raise SlowerError(f"more than in {KNOWN.name}: {grown}; find out why, or --record")
    return counts


def _drive(on_start: Callable[[], None]) -> tuple[float, int]:
    """Return the CPU time of a simulated second of a drive to a goal [s], and its steps."""
    on_map = {"map_server": {"yaml_filename": str(shipped_file("maps/arjuna_room.yaml"))}}
    with closing(LockStep(merged(shipped_parameters(), placed(SE2()), on_map))) as robot:
        robot.start(SIM_GROUP, LOCALIZATION_GROUP, NAVIGATION_GROUP)
        robot.run(1.0)
        start_time = robot.now
        on_start()
        spent = _cpu(lambda: Goals(robot).navigate(SE2(2.0, -1.5, 1.0), 60.0))
        passed = robot.now - start_time
        return spent / passed, round(passed / robot.sim.config.tick)


_COUNTED: dict[str, Callable[[], float]] = {
    "a simulated second of lock-step": lambda: _drive(lambda: None)[0],
    "a local delivery": lambda: _delivery("local"),
    "arjuna --help": _help,
    "nav --help": lambda: _help("nav"),
    "costmap update": lambda: _bench("costmap", "--edge 400 --repeats 30")["local_scan"] / 1e3,
    "MPPI command": lambda: _bench("controller", "--only mppi --commands 60")["mppi"]["ms"] / 1e3,
}
"""CPU times [s] of the short form."""


def _append(path: Path, result: dict[str, float]) -> None:
    """Append a commit's numbers as a line of JSON, and plot each by its first over the commits."""
    from matplotlib.figure import Figure

    command = ["git", "describe", "--always", "--dirty"]
    commit = subprocess.check_output(command, cwd=_ROOT, text=True).strip()
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps({"commit": commit, **result}) + "\n")
    rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    figure = Figure(figsize=(16.0, 20.0), layout="constrained")
    panels = ("demo|step|mj_step|delivery", "node", ".*(--help|to active)", ".")
    for axes, panel in zip(figure.subplots(len(panels)), panels, strict=True):
        for name in [
            name for name in result if next(p for p in panels if re.match(p, name)) == panel
        ]:
            first = next(row[name] for row in rows if name in row)
            axes.plot([row.get(name, np.nan) / first for row in rows], marker=".", label=name)
        axes.set_ylabel("by the first commit's")
        axes.set_xticks(range(len(rows)), [row["commit"] for row in rows], rotation=90)
        axes.legend(fontsize=7, ncols=2, loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.savefig(path.with_suffix(".png"), dpi=80)
