"""Worlds of the BARN challenge, crossed in lock-step by a robot like its Jackal, without a map."""

from __future__ import annotations

import argparse
import math
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from arjuna_core.se2 import SE2
from bringup.parameters import options
from bringup.scenarios.barn import AHEAD, START, make_worlds
from bringup.scenarios.drive import Drive, placed
from tests.helpers.nav.barn import REACHED, TIME_LIMIT, BarnWorld, load_worlds

_JACKAL = Path(__file__).parent / "jackal"


@dataclass(frozen=True)
class Run:
    """Result of one run.

    Attributes:
        time: Until the goal was reached [s], None where it was not.
        touched: What was touched, which ends the run.
        length: Length of the driven path [m].
        ended_at: The time of the end, however it ended [s].
        why: What navigation says where it gave up.
    """

    time: float | None
    touched: tuple[str, ...]
    length: float
    ended_at: float
    why: str = ""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    worlds = parser.add_mutually_exclusive_group(required=True)
    worlds.add_argument("--worlds", type=Path, metavar="DIR", help="BARN's worlds")
    worlds.add_argument(
        "--make", type=int, metavar="N", help="make N worlds like BARN's, by the seed"
    )
    parser.add_argument("--runs", type=int, default=1, help="of each world (%(default)s)")
    parser.add_argument("--every", type=int, default=1, help="take each so manieth world only")
    parser.add_argument(
        "--robot", type=Path, default=_JACKAL / "jackal.urdf", help="its file (a Jackal)"
    )
    parser.add_argument(
        "--slam", action="store_true", help="navigate in the map of slam_toolbox, not in odom"
    )
    options.add(parser, *options.NODES, "--seed")
    parser.set_defaults(
        log_level="fatal", command="demo", world=None, robot_arguments=[], package_path=[]
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Cross every world.

    Returns:
        The mean `success`, `score` and `time_s` of the runs that succeeded, the `touches` of all,
        and the number of `runs`.
    """
    from rclpy.logging import LoggingSeverity, set_logger_level

    set_logger_level("", LoggingSeverity[arguments.log_level.upper()])
    options.extend_search(arguments)
    arguments.params = [_JACKAL / "jackal.yaml", *arguments.params]
    runs: list[tuple[BarnWorld, Run]] = []
    with TemporaryDirectory() as folder:
        for world in _worlds(arguments, Path(folder)):
            for number in range(arguments.runs):
                runs.append((world, _cross(world, arguments, (arguments.seed or 0) + number)))
                print(_line(*runs[-1]), flush=True)
    return _figures(runs)


def _worlds(arguments: argparse.Namespace, folder: Path) -> list[BarnWorld]:
    given = arguments.worlds
    if given is None:
        given = make_worlds(folder, arguments.make, np.random.default_rng(arguments.seed or 0))
    return load_worlds(given, folder, arguments.every)


def _cross(world: BarnWorld, arguments: argparse.Namespace, seed: int) -> Run:
    from bringup.lockstep import LockStep
    from bringup.parameters.files import merged
    from bringup.parameters.inputs import gather
    from bringup.stack import NAVIGATION_GROUP, SIM_GROUP, SLAM_GROUP

    own = {"sim": {"world": str(world.world), "seed": seed}}
    parameters = merged(gather(arguments), placed(START), own)
    groups = (SLAM_GROUP, NAVIGATION_GROUP) if arguments.slam else (NAVIGATION_GROUP,)
    with closing(LockStep(parameters)) as robot:
        robot.start(SIM_GROUP, *groups)
        robot.run(1.0)
        return _drive(robot, world, "map" if arguments.slam else "odom")


def _drive(robot: Any, world: BarnWorld, frame: str) -> Run:
    """Send the goal; a touch, the goal, an end without it or the time limit ends the run."""
    from nav2_msgs.action import NavigateToPose

    from arjuna_core.ros.convert import pose_stamped
    from arjuna_core.ros.local.actions import action_client

    drive, start = Drive(robot), robot.now
    goal = START @ SE2(AHEAD, 0.0)
    request = NavigateToPose.Goal(pose=pose_stamped(SE2(AHEAD, 0.0), frame, 0.0))
    client = action_client(robot.client, NavigateToPose, "navigate_to_pose")
    robot.process.drain()
    sent = client.send_goal_async(request)
    robot.process.drain()
    ended = sent.result().get_result_async()

    def over() -> bool:
        return bool(drive.touched or ended.done() or drive.truth.distance(goal) <= REACHED)

    robot.run_until(over, TIME_LIMIT, required=False)
    took = robot.now - start
    reached = not drive.touched and drive.truth.distance(goal) <= REACHED
    why = "" if reached or not ended.done() else ended.result().result.error_msg
    return Run(took if reached else None, tuple(drive.touched), drive.length, took, why)


def _line(world: BarnWorld, one: Run) -> str:
    how = "reached" if one.time is not None else "TOUCHED" if one.touched else "FAILED "
    where = f" at {world.name}: {', '.join(one.touched)}" if one.touched else ""
    return (
        f"{world.name:10} {how} {one.ended_at:6.1f} s  score {world.score(one.time):.3f}"
        f"  path {one.length:5.1f} of {world.optimal:4.1f} m{where} {one.why}"
    )


def _figures(runs: list[tuple[BarnWorld, Run]]) -> dict[str, Any]:
    times = [one.time for _, one in runs if one.time is not None]
    result = {
        "success": len(times) / len(runs),
        "score": float(np.mean([world.score(one.time) for world, one in runs])),
        "touches": sum(len(one.touched) for _, one in runs),
        "time_s": float(np.mean(times)) if times else math.nan,
        "runs": len(runs),
    }
    for name, value in result.items():
        print(f"{name:10}{value:10.4g}")
    return result
