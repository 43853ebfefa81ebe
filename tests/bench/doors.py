"""Doors hardly wider than the robot: played by the cores alone, or by all nodes in the physics."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from bringup.parameters import options
from bringup.parameters.files import Parameters, merged
from bringup.scenarios.doors import Door
from bringup.scenarios.drive import Drive, placed
from tests.helpers.nav.layers import Body
from tests.helpers.nav.played import Play

_WIDTHS = (0.70, 0.60, 0.50, 0.45, 0.42)
_TIMEOUT = 90.0  # of a goal [s]
_COSTMAPS = ("global_costmap/global_costmap", "local_costmap/local_costmap")


@dataclass(frozen=True)
class Passage:
    """Result of one door.

    Attributes:
        passed: Whether the goal was reached without a touch.
        time: It took [s].
        why: What navigation says where it gave up.
    """

    passed: bool
    touched: tuple[str, ...]
    time: float
    why: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    options.add(parser, *options.NODES, "--seed")
    parser.add_argument(
        "--widths", type=float, nargs="*", default=_WIDTHS, help=f"of doors {_WIDTHS} [m]"
    )
    parser.add_argument("--count", type=int, default=10, help="doors of a width (%(default)s)")
    parser.add_argument(
        "--size",
        type=float,
        nargs="+",
        default=(0.45, 0.38),
        help="of the robot: length and width, or the radius of a round one %(default)s [m]",
    )
    parser.add_argument(
        "--odom", action="store_true", help="navigate in odom, without a map; else on one"
    )
    parser.add_argument(
        "--physics", action="store_true", help="Arjuna, all its nodes and AMCL, in lock-step"
    )
    parser.set_defaults(
        log_level="fatal", command="demo", slam=False, robot=None, robot_arguments=[]
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Drive through doors.

    Returns:
        Of each width how many doors were `passed`, of all `count`, `touches`, and the mean time
        of those passed [s]; `start_blocked`, how often the start was enclosed.
    """
    result = {}
    for width in arguments.widths:
        passages = list(_through(width, arguments))
        passed = [one.time for one in passages if one.passed]
        result[f"{width:.2f}"] = {
            "passed": len(passed),
            "count": len(passages),
            "touches": sum(len(one.touched) for one in passages),
            "time_s": float(np.mean(passed)) if passed else float("nan"),
            "start_blocked": sum("no way out" in one.why for one in passages),
        }
        print(f"{width:.2f} m: {result[f'{width:.2f}']}", flush=True)
    return result


def _through(width: float, arguments: argparse.Namespace) -> Iterator[Passage]:
    for number in range(arguments.count):
        seed = (arguments.seed or 0) + number
        door = Door.draw(width, np.random.default_rng([seed, round(1000 * width)]))
        if arguments.physics:
            with TemporaryDirectory() as folder:
                one = _drive(door, seed, Path(folder), arguments)
        else:
            one = _play(door, seed, arguments)
        how = "passed" if one.passed else "TOUCHED" if one.touched else "FAILED"
        print(f"  {width:.2f} m, {seed:3}: {how:8}{one.time:6.1f} s {one.why}", flush=True)
        yield one


def _play(door: Door, seed: int, arguments: argparse.Namespace) -> Passage:
    size, grid = arguments.size, None if arguments.odom else door.map()
    body = Body.disc(size[0]) if len(size) == 1 else Body.box(size[0], size[1])
    rng = np.random.default_rng(seed)
    play = Play(door.edges(), grid, door.start, door.goal, body, rng).run(_TIMEOUT)
    through = play.arrived and door.is_through(play.robot.pose)
    touched = ("a wall",) if play.touched else ()
    return Passage(through, touched, play.time, "" if through else play.why)


def _drive(door: Door, seed: int, folder: Path, arguments: argparse.Namespace) -> Passage:
    from rclpy.logging import LoggingSeverity, set_logger_level

    from bringup.client.goals import Goals
    from bringup.lockstep import LockStep
    from bringup.parameters.inputs import gather
    from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SIM_GROUP

    set_logger_level("", LoggingSeverity[arguments.log_level.upper()])
    arguments.world, arguments.map = door.save(folder)
    own: Parameters = {name: Body.box(0.45, 0.38).parameters for name in _COSTMAPS}
    own["sim"] = {"seed": seed}
    parameters = merged(gather(arguments), placed(door.start), own)
    with closing(LockStep(parameters)) as robot:
        robot.start(SIM_GROUP, LOCALIZATION_GROUP, NAVIGATION_GROUP)
        robot.run(1.0)
        drive, start = Drive(robot), robot.now
        end = Goals(robot).navigate(door.goal, _TIMEOUT)
        passed = end.succeeded and not drive.touches and door.is_through(drive.truth)
        return Passage(passed, tuple(drive.touched), robot.now - start, end.reason)
