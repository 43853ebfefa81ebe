"""Times of each controller's commands on one core, and its drive through a slalom."""

from __future__ import annotations

import argparse
import ctypes
import math
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import load
from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_nav.controllers import Controller, ControlStatus
from arjuna_nav.controllers.mppi.config import MppiConfig
from arjuna_nav.costmap import Costmap
from tests.helpers.nav import mppi_peer
from tests.helpers.nav.controllers import PARAMETERS, make
from tests.nav.worlds import Unicycle, block, costmap_of, empty_grid

_SIZES: dict[str, dict[str, Any]] = {
    "mppi": {"batch_size": 2000, "time_steps": 56},
    "dwb": {"vx_samples": 20, "vtheta_samples": 20},
}
_NOTES = {"mppi": "2000 x 56", "dwb": "20 x 20"}
_BATCHES = 500, 1000, 2000  # beside the arrays in C
_WINDOW = 5.0  # edge of the costmap, 100 x 100 cells [m]
_TIMEOUT = 90.0  # of the slalom [s]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument(
        "--commands", type=int, default=300, help="commands timed of each (%(default)s)"
    )
    parser.add_argument(
        "--only", nargs="*", choices=list(PARAMETERS), help="these controllers alone"
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Time every controller.

    Returns:
        For each controller the median and the 99th percentile of a command's time on the processor
        [ms], and of the slalom its time [s], its greatest distance from the path [m] and whether
        it arrived; nan where it did not.
    """
    result = {}
    print(f"{'controller':32}{'size':>10}{'median':>10}{'p99':>10}   slalom")
    for name in arguments.only or PARAMETERS:
        plain = name.removesuffix(" under the shim")
        median, worst = _times(make(name, **_SIZES.get(plain, {})), arguments.commands)
        seconds, off = _slalom(make(name, **_SIZES.get(plain, {})))
        result[name] = {"ms": median, "p99_ms": worst, "slalom_s": seconds, "slalom_off_m": off}
        size = _NOTES.get(plain, "")
        print(
            f"{name:32}{size:>10}{median:8.3f}ms{worst:8.3f}ms   {seconds:5.1f} s, {off:.2f} m off"
        )
    if arguments.only in (None, ["mppi"]):
        result |= against_arrays(arguments.commands)
    return result


def against_arrays(commands: int) -> dict[str, dict[str, float]]:
    """Time MPPI's commands in turn with those of its array version in C; none without a compiler.

    Returns:
        For each batch the median times of the processor [ms] and their ratio, and the greatest
        difference of the commands [m/s or rad/s].
    """
    library = mppi_peer.compiled()
    if library is None:
        print("MPPI by arrays: no C compiler")
        return {}
    return {f"mppi {batch}": _in_turn(library, batch, commands) for batch in _BATCHES}


def _in_turn(library: ctypes.CDLL, batch: int, commands: int) -> dict[str, float]:
    given: dict[str, Any] = {"batch_size": batch, "time_steps": 56}
    own = {name: value for name, value in PARAMETERS["mppi"].items() if name != "plugin"}
    controller, costmap = make("mppi", **given), costmap_of(_cluttered())
    peer, path = mppi_peer.ArrayMppi(library, load(MppiConfig, {**own, **given})), _course()
    spent, off, robot = [], 0.0, Unicycle(SE2.from_array(path[0]))
    for k in range(commands + 20):
        if k % 60 == 0:
            robot.pose = SE2.from_array(path[0])
            controller.set_path(path)
            peer.set_path(path)
        started = time.process_time()
        command = controller.compute(robot.pose, robot.velocity, costmap, k * 0.05).velocity
        between = time.process_time()
        other = peer.compute(robot.pose, robot.velocity, costmap)
        spent.append((between - started, time.process_time() - between))
        assert other is not None, "the peer sees a collision"
        off = max(off, abs(command.x - other.x), abs(command.yaw_rate - other.yaw_rate))
        robot.drive(command)
    peer.close()
    ours, theirs = (1e3 * float(each) for each in np.median(spent[20:], axis=0))
    print(
        f"mppi {batch} x 56: {ours:.3f} ms, arrays in C {theirs:.3f} ms: {ours / theirs:.2f}"
        f"   commands differ by {off:.4f} at most"
    )
    return {"ms": ours, "arrays_ms": theirs, "ratio": ours / theirs, "differ": off}


def _times(controller: Controller, commands: int) -> tuple[float, float]:
    """Return the median and the 99th percentile of a command's time [ms] in a cluttered window."""
    costmap = costmap_of(_cluttered())
    path = _course()
    robot = Unicycle(SE2.from_array(path[0]))
    controller.set_path(path)
    spent = []
    for k in range(commands + 20):
        if k % 60 == 0:  # in the middle of its work, never at the end
            robot.pose = SE2.from_array(path[0])
            controller.set_path(path)
        before = time.process_time()
        command = controller.compute(robot.pose, robot.velocity, costmap, k * 0.05)
        spent.append(1e3 * (time.process_time() - before))
        robot.drive(command.velocity)
    return float(np.median(spent[20:])), float(np.percentile(spent[20:], 99))


def _course() -> NDArray[np.float64]:
    x = np.arange(0.8, 4.3, 0.05)
    return _facing(np.column_stack((x, 2.5 + 0.4 * np.sin(2.0 * x))))


def _cluttered() -> OccupancyGrid:
    grid = empty_grid(_WINDOW, _WINDOW)
    rng = np.random.default_rng(3)
    for x, y in rng.uniform(0.2, _WINDOW - 0.4, (40, 2)):
        if abs(y - 2.5) > 1.0:
            block(grid, float(x), float(y), 0.2, 0.2)
    return grid


def _slalom(controller: Controller) -> tuple[float, float]:
    """Return how long a slalom round three boxes takes [s], and how far off the path it is [m]."""
    costmap, path = _slalom_course()
    robot = Unicycle(SE2.from_array(path[0]))
    controller.set_path(path)
    goal, off = SE2.from_array(path[-1]), 0.0
    for k in range(int(_TIMEOUT / robot.period)):
        result = controller.compute(robot.pose, robot.velocity, costmap, k * robot.period)
        ok = result.status is ControlStatus.SUCCEEDED
        robot.drive(result.velocity if ok else type(result.velocity)())
        gaps = np.hypot(path[:, 0] - robot.pose.x, path[:, 1] - robot.pose.y)
        off = max(off, float(gaps.min()))
        if robot.pose.distance(goal) < 0.2:
            return (k + 1) * robot.period, off
    return math.nan, off


def _slalom_course() -> tuple[Costmap, NDArray[np.float64]]:
    grid = empty_grid(10.0, 4.0)
    for k, x in enumerate((2.5, 5.0, 7.5)):
        block(grid, x - 0.15, 1.85 + (0.3 if k % 2 else -0.3), 0.3, 0.3)
    along = np.arange(1.0, 9.0, 0.05)
    wave = np.cos((along - 2.5) * math.pi / 2.5)
    return costmap_of(grid), _facing(np.column_stack((along, 2.0 + 0.6 * wave)))


def _facing(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points as poses that look along them."""
    steps = np.diff(points, axis=0)
    yaw = np.arctan2(steps[:, 1], steps[:, 0])
    return np.column_stack((points, np.append(yaw, yaw[-1])))
