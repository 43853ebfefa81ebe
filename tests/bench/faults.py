"""Every fault of a topic on the way to a goal, in lock-step: what the robot does, by the truth."""

from __future__ import annotations

import argparse
import math
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import numpy as np
from action_msgs.msg import GoalStatus
from nav2_msgs.action import NavigateToPose

from arjuna_core.files.shipped import shipped_file
from arjuna_core.ros.convert import pose_stamped
from arjuna_core.ros.local.actions import action_client
from arjuna_core.se2 import SE2
from bringup.lockstep import LockStep
from bringup.parameters import options
from bringup.parameters.files import Parameters, merged, shipped_parameters
from bringup.scenarios.drive import Drive, placed
from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SIM_GROUP
from tests.helpers.faults import Faults
from tests.helpers.nav.faults import BLIND, SURVIVED, TOLERATED, Trial

_TRIALS = {**BLIND, **TOLERATED, **SURVIVED}
_GOALS = (SE2(1.5, 1.0, 0.5), SE2(3.0, 1.2, 0.0), SE2(1.0, -1.0, 1.5))
_TICK, _STILL = 0.02, 0.001  # [s], [m] a tick
_DELAY_MIN = 2.0  # until the fault begins, at the earliest [s]
_PATIENCE = 90.0  # until a goal has ended [s]
_REACHED = 0.3  # [m]


@dataclass(frozen=True)
class Run:
    """The result of one drive.

    Attributes:
        reached: Whether the robot is where it says that it is.
        ended: Whether the goal ended at all.
        touches: Contacts with the world.
        stood_after: From the fault to the last motion within it [s]; None where it moved on.
    """

    reached: bool
    reason: str
    ended: bool
    touches: int
    stood_after: float | None

    @property
    def right(self) -> bool:
        """True if the mission ended right, or with the reason."""
        return self.ended and (self.reached or bool(self.reason))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--seeds", type=int, default=3, metavar="N", help="runs of each fault")
    parser.add_argument("--only", metavar="TEXT", default="", help="faults that have this in them")
    parser.add_argument("--lasts", type=float, default=4.0, help="each fault [s] (%(default)s)")
    options.add(parser, "--seed")
    parser.set_defaults(seed=0)


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Drive with each fault.

    Returns:
        `runs`, `touches`, `reached`, `ended_right` (there, or with the reason), `wrong` (the
        faults and seeds of the others) and `faults`: of each its `reached`, `touches` and
        `stands_within_s`, the longest.
    """
    from rclpy.logging import LoggingSeverity, set_logger_level

    set_logger_level("", LoggingSeverity.FATAL)
    total: dict[str, Any] = {"runs": 0, "touches": 0, "reached": 0, "ended_right": 0, "wrong": []}
    total["faults"] = {}
    for name, trial in _TRIALS.items():
        if arguments.only not in name:
            continue
        seeds = range(arguments.seed, arguments.seed + arguments.seeds)
        runs = [_run(trial, seed, arguments.lasts) for seed in seeds]
        _add(total, name, trial, runs)
        total["wrong"] += [f"{name}, {s}" for s, r in zip(seeds, runs, strict=True) if not r.right]
    print(f"{total['ended_right']} of {total['runs']} right, {total['touches']} touches")
    return total


def _add(total: dict[str, Any], name: str, trial: Trial, runs: list[Run]) -> None:
    stood = [math.inf if run.stood_after is None else run.stood_after for run in runs]
    touches, reached = sum(run.touches for run in runs), sum(run.reached for run in runs)
    right = sum(run.right for run in runs)
    for key, value in (("runs", len(runs)), ("touches", touches), ("reached", reached)):
        total[key] += value
    total["ended_right"] += right
    longest = max(stood) if trial.stands_within is not None and math.isfinite(max(stood)) else None
    total["faults"][name] = {"reached": reached, "touches": touches, "stands_within_s": longest}
    stands = "" if longest is None else f", stands within {longest:.2f} s"
    reasons = "; ".join(sorted({run.reason for run in runs if run.reason}))
    print(
        f"{name:25} {right}/{len(runs)} right, {reached} there, {touches} touches{stands} {reasons}"
    )


def _run(trial: Trial, seed: int, lasts: float) -> Run:
    with closing(LockStep(_parameters(seed))) as robot:
        robot.start(SIM_GROUP, LOCALIZATION_GROUP, NAVIGATION_GROUP)
        robot.run(1.0)
        return _driven(robot, trial, np.random.default_rng(seed), lasts)


def _parameters(seed: int) -> Parameters:
    room = {"map_server": {"yaml_filename": str(shipped_file("maps/arjuna_room.yaml"))}}
    return merged(shipped_parameters(), room, placed(SE2()), {"sim": {"seed": seed}})


def _driven(robot: LockStep, trial: Trial, rng: np.random.Generator, lasts: float) -> Run:
    """Send a goal, let the fault come and go, and wait for the goal's end.

    Ticks are counted, not time: a fault may stop the clock.
    """
    drive = Drive(robot)
    faults = Faults([*robot.process.nodes, robot.process.node], rng, lambda: robot.now)
    goal = _GOALS[int(rng.integers(len(_GOALS)))]
    client = action_client(robot.client, NavigateToPose, "navigate_to_pose")
    robot.run_until(client.server_is_ready, 5.0, "navigation")
    sent = client.send_goal_async(NavigateToPose.Goal(pose=pose_stamped(goal, "map", 0.0)))
    robot.run_until(sent.done, 5.0, "an answer")
    result = sent.result().get_result_async()
    robot.run(_DELAY_MIN + float(rng.uniform(0.0, 1.0)))
    faults.put(trial.topic, trial.fault)
    moved = 0
    for tick in range(round(lasts / _TICK)):
        before = drive.length
        robot.step()
        faults.run_due()
        moved = tick + 1 if drive.length - before > _STILL else moved
    faults.clear()
    for _ in range(round(_PATIENCE / _TICK)):
        if result.done():
            break
        robot.step()
    return _judged(result, drive, goal, None if moved * _TICK >= lasts else moved * _TICK)


def _judged(result: Any, drive: Drive, goal: SE2, stood_after: float | None) -> Run:
    if not result.done():
        return Run(False, "", False, drive.touches, stood_after)
    answer = result.result()
    succeeded = answer.status == GoalStatus.STATUS_SUCCEEDED
    there = succeeded and drive.truth.distance(goal) < _REACHED
    reason = "" if succeeded else answer.result.error_msg
    return Run(there, reason, True, drive.touches, stood_after)
