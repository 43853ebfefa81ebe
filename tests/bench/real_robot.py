"""`robot` beside a stand-in for a real robot's drivers, late and lossy: mapped, saved, localized.

In half of the time it maps while it drives, then it drives on the saved map with AMCL.
"""

from __future__ import annotations

import argparse
import os
import signal
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_core.se2 import SE2, wrap
from bringup.client.goals import Goals
from bringup.client.session import Connection
from bringup.parameters import options
from tests.helpers.processes import Lines
from tests.helpers.real_robot import OPTIONS, free_poses

_ACTIVE = "Managed nodes are active"
_START, _GOAL = 60.0, 90.0  # [s] at most
_POSE_PREFIX = "at "  # how the drivers' line with the true pose begins
_OF_GOALS = "navigate_to_pose: goal "  # received, and ended
_SAMPLES = 200  # goals drawn, more than are driven


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--minutes", type=float, default=10.0, help="of driving (%(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of delays and goals (%(default)s)")
    parser.add_argument(
        "--domain-id", type=options.domain_id, default=98, help="of ROS, its own (%(default)s)"
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Map, save, localize and drive to random goals all the while.

    Returns:
        `mapping` and `localized`, each with `goals` and `reached`, the greatest `position_m` and
        `yaw_rad` by which the robot truly stood beside a goal it reached, and `errors` and
        `warnings` that were said.
    """
    os.environ["ROS_DOMAIN_ID"] = str(arguments.domain_id)
    goals = iter(free_poses(np.random.default_rng(arguments.seed), _SAMPLES))
    half = arguments.minutes * 60.0 / 2
    with (
        tempfile.TemporaryDirectory() as folder,
        Lines("-m", "tests.helpers.real_robot", str(arguments.seed)) as drivers,
    ):
        world = str(Path(folder) / "map")
        drivers.wait_for(_POSE_PREFIX)
        with _robot("--slam") as robot:
            mapping = _driven(robot, drivers, goals, half)
            _done("save-map", world)
        result = {"mapping": {**mapping, **_said(robot)}}
        with _robot("--map", f"{world}.yaml") as robot:
            _done("initial-pose", "--", *map(str, _true_pose(drivers).array()))
            localized = _driven(robot, drivers, goals, half)
        result["localized"] = {**localized, **_said(robot)}
    for name, values in result.items():
        print(f"{name:12}", "  ".join(f"{key} {value}" for key, value in values.items()))
    return result


@contextmanager
def _robot(*words: str) -> Iterator[Lines]:
    """Run the stack until both managers' nodes are active, and end it as Ctrl-C does."""
    with Lines("-m", "bringup", "robot", *OPTIONS, *words) as lines:
        lines.wait_for(_ACTIVE, 2, _START)
        yield lines
        lines.process.send_signal(signal.SIGINT)
        lines.read_to_end()


def _done(*words: str) -> None:
    """Run a command of ours to its end."""
    with Lines("-m", "bringup", *words) as lines:
        assert lines.read_to_end() == 0, lines.seen


def _driven(
    robot: Lines, drivers: Lines, goals: Iterator[SE2], seconds: float
) -> dict[str, float | None]:
    """Drive from goal to goal for a time; return how many were reached, and how well."""
    count, off = 0, list[tuple[float, float]]()
    with closing(Connection("bench_real_robot")) as session:
        driver, until = Goals(session), time.monotonic() + seconds
        while time.monotonic() < until:
            goal, count = next(goals), count + 1
            if driver.navigate(goal, _GOAL).succeeded:
                stood = _true_pose(drivers)
                off.append((stood.distance(goal), abs(wrap(stood.theta - goal.theta))))
            robot.wait_for(_OF_GOALS, 2 * count)
    worst = np.max(off, axis=0).round(3) if off else (None, None)
    return {"goals": count, "reached": len(off), "position_m": worst[0], "yaw_rad": worst[1]}


def _said(robot: Lines) -> dict[str, list[str]]:
    """Return what was not as it should be."""
    return {
        "errors": robot.matching("[ERROR]") + robot.matching("Traceback"),
        "warnings": robot.matching("[WARN]"),
    }


def _true_pose(drivers: Lines) -> SE2:
    """Return the robot's true pose: the second line from now on."""
    for count in (1, 2):  # the first takes what was printed before
        lines = drivers.wait_for(_POSE_PREFIX, len(drivers.matching(_POSE_PREFIX)) + count)
    x, y, theta = map(float, lines[-1].split()[1:])
    return SE2(x, y, theta)
