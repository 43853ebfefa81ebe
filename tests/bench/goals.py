"""Random goals on a map, driven in lock-step, judged by the truth."""

from __future__ import annotations

import argparse
import math
from contextlib import closing
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from arjuna_core.files.maps import load_map
from arjuna_core.files.shipped import shipped_file
from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2, wrap
from bringup.parameters import options
from tests.helpers.nav.drives import Drive, FreeSpace, desired_speed, placed
from tests.helpers.nav.furnished import make_room
from tests.helpers.nav.inhabited import boxes_in, settle, with_boxes
from tests.helpers.nav.journal import Journal, Ticks, believed_pose, draw, steadiness

_CLEARANCE = 0.5  # from a goal to the nearest wall: there is room to turn [m]
_SHORTEST = 1.0  # a goal nearer than that says nothing of the path [m]
_TIMEOUT_PER_METRE, _TIMEOUT = 15.0, 60.0  # [s]
_REST = 0.5  # until the robot stands still [s]
_HOUR = 3600.0
_SETTING = (
    *("seed", "world", "map", "truth", "furnished", "boxes", "people", "radius", "robot"),
    *("params", "param"),
)


@dataclass(frozen=True)
class Arrival:
    """Result of one goal.

    Attributes:
        succeeded: Whether navigation said so.
        off_m: From the goal's position, by the truth [m].
        off_rad: From the goal's heading [rad].
        believed_m: From the goal's position, by what the robot believes [m].
        length: Length of the driven path [m].
        shortest: Length of the shortest path [m].
        time: It took [s].
        touches: Contacts that began, with people by the robot's own doing.
        met: Contacts with people, whoever walked, and with what they push the robot against.
        curvature: Greatest that was commanded or driven; NaN of a robot that is not steered [1/m].
    """

    succeeded: bool
    off_m: float
    off_rad: float
    believed_m: float
    length: float
    shortest: float
    time: float
    touches: int
    met: int
    curvature: float


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    options.add(parser, *options.SIMULATION, *options.NODES, "--seed")
    parser.add_argument("--map", type=Path, metavar="FILE", help="the world's map (its own)")
    parser.add_argument(
        "--truth",
        type=Path,
        metavar="FILE",
        help="a map of all that the robot could touch, for goals and shortest paths (the map)",
    )
    parser.add_argument(
        "--furnished",
        action="store_true",
        help="in a room made up by the seed, much of it below and above the lidar's plane",
    )
    parser.add_argument("--boxes", type=int, default=0, help="that the map does not have (0)")
    parser.add_argument(
        "--people", type=int, default=0, help="who walk to and fro, each along a line (0)"
    )
    parser.add_argument("--count", type=int, default=20, help="how many goals (%(default)s)")
    parser.add_argument("--hours", type=float, help="simulated, to drive instead of --count goals")
    parser.add_argument(
        "--piece", type=float, metavar="H", help="simulated hours after which this process ends"
    )
    parser.add_argument(
        "--state",
        type=Path,
        metavar="FILE",
        help="keeps each goal: the same command again continues behind the last, whatever ended"
        " the one before; all are drawn beside it, as .png",
    )
    parser.add_argument(
        "--radius", type=float, default=0.2, help="of the robot, for the shortest path [m]"
    )
    parser.set_defaults(log_level="error", command="demo", slam=False)


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Drive to one goal after the other.

    The shortest path is the one that a robot of `--radius` could drive among all that it could
    touch, be it on the robot's map or not: who does not know pays for finding out, and no path is
    asked for that leads through what the map lacks. Its inscribed radius is less than what the
    costmaps keep free, so that the ratio holds the room that a robot leaves beside it too.

    Returns:
        `succeeded` of `count`, `touches`, of people by the robot's own doing, how often it `met`
        people at all, a steered robot's `curvature_max` [1/m], `arrival_p95_m` and
        `arrival_p95_rad` by the truth, `believed_p95_m` by the robot's own word, `path_ratio` to
        the shortest path (see above), `speed_ratio` to the desired speed and `time_per_metre_s`
        of the shortest path, of the goals reached; with `--state` how steady it was too.

    A process that continues has its own noise, drawn from the seed and its number. It puts the
    robot at rest where it was, its odometry and belief with it, and people where they were on
    their routes. Lost are AMCL's particles (drawn again about the belief), what costmaps hold
    beside the map, and who was being tracked.
    """
    from rclpy.logging import LoggingSeverity, set_logger_level

    set_logger_level("", LoggingSeverity[arguments.log_level.upper()])
    rng = np.random.default_rng(arguments.seed or 0)
    setting = {name: str(vars(arguments)[name]) for name in _SETTING}
    journal = Journal(arguments.state, setting)
    with TemporaryDirectory() as folder:
        if arguments.furnished:
            arguments.world, arguments.map, whole = make_room(Path(folder), rng)
        else:
            arguments.world = arguments.world or shipped_file("worlds/arjuna_room.world")
            arguments.map = arguments.map or shipped_file(f"maps/{arguments.world.stem}.yaml")
            whole = arguments.truth or arguments.map
        speed = _drive(arguments, load_map(whole), rng, journal, Path(folder))
    result = _figures([Arrival(**row["arrival"]) for row in journal.rows], speed)
    if arguments.state is not None:
        result.update(steadiness(journal.rows))
        draw(journal.rows, arguments.state.with_suffix(".png"))
    for name, value in result.items():
        print(f"{name:18}{value:10.4g}")
    return result


def _drive(
    arguments: argparse.Namespace,
    grid: OccupancyGrid,
    rng: np.random.Generator,
    journal: Journal,
    folder: Path,
) -> float:
    """Drive what is left of the goals; return the desired speed [m/s]."""
    from bringup.client.goals import Goals
    from bringup.lockstep import LockStep
    from bringup.parameters.files import merged
    from bringup.parameters.inputs import gather
    from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SIM_GROUP

    space = FreeSpace(grid, arguments.radius, _CLEARANCE)
    start = space.draw(rng)
    boxes = boxes_in(grid, arguments.boxes, start, rng)
    grid = with_boxes(grid, boxes)
    space = FreeSpace(grid, arguments.radius, _CLEARANCE)
    arguments.seed = (arguments.seed or 0) + journal.piece
    resume = journal.resume
    pose = SE2(*resume["believed"]) if resume else start
    parameters = merged(gather(arguments), placed(pose), journal.parameters(folder))
    with closing(LockStep(parameters)) as robot:
        robot.start(SIM_GROUP, LOCALIZATION_GROUP, NAVIGATION_GROUP)
        robot.run(journal.began + 1.0)  # the clock is at 0 until the first tick
        walked = resume.get("walked", {})
        settle(robot.sim.simulator.stage, grid, boxes, arguments.people, start, rng, walked)
        rng.bit_generator.state = resume.get("rng", rng.bit_generator.state)
        goals, ticks = Goals(robot), Ticks(robot)
        while not _is_done(arguments, journal, robot.now):
            goal, shortest = space.draw(rng), math.nan
            while not shortest >= _SHORTEST:
                goal = space.draw(rng)
                shortest = space.shortest(robot.sim.last.truth.pose, goal)
            arrival = _one(robot, goals, goal, shortest)
            journal.append(robot, rng, goal, arrival=asdict(arrival), cost=ticks.taken())
            print(_line(len(journal.rows), goal, arrival), flush=True)
    return desired_speed(parameters)


def _is_done(arguments: argparse.Namespace, journal: Journal, now: float) -> bool:
    if arguments.hours is not None:
        done = now >= arguments.hours * _HOUR
    else:
        done = len(journal.rows) >= arguments.count
    pieces = arguments.piece is not None and now - journal.began >= arguments.piece * _HOUR
    return done or (pieces and bool(journal.resume))


def _one(robot: Any, goals: Any, goal: SE2, shortest: float) -> Arrival:
    drive, start = Drive(robot), robot.now
    end = goals.navigate(goal, _TIMEOUT + _TIMEOUT_PER_METRE * shortest)
    length, time = drive.length, robot.now - start
    if not end.succeeded:
        print(f"     {end.reason}")
    robot.run(_REST)
    if drive.touched:
        print(f"     touched {', '.join(drive.touched)}")
    believed = believed_pose(robot) or SE2(math.inf)
    return Arrival(
        end.succeeded,
        drive.truth.distance(goal),
        abs(wrap(drive.truth.theta - goal.theta)),
        believed.distance(goal),
        length,
        shortest,
        time,
        drive.touches,
        drive.hits,
        drive.curvature if robot.sim.simulator.robot.model.drive.steering else math.nan,
    )


def _line(number: int, goal: SE2, one: Arrival) -> str:
    return (
        f"{number:4} ({goal.x:6.2f}, {goal.y:6.2f}) {'reached' if one.succeeded else 'FAILED '}"
        f"{one.time:7.1f} s  path {one.length:6.2f} of {one.shortest:6.2f} m"
        f"  off {one.off_m:.3f} m {one.off_rad:.3f} rad (believed {one.believed_m:.3f} m)"
        f"  touches {one.touches} met {one.met}"
        + (f" curvature {one.curvature:.3f} 1/m" if math.isfinite(one.curvature) else "")
    )


def _figures(arrivals: list[Arrival], speed: float) -> dict[str, Any]:
    reached = [one for one in arrivals if one.succeeded]

    def p95(values: list[float]) -> float:
        return float(np.percentile(values, 95)) if values else math.nan

    length = sum(one.length for one in reached)
    shortest = max(sum(one.shortest for one in reached), 1e-9)
    time = sum(one.time for one in reached)
    return {
        "succeeded": len(reached),
        "count": len(arrivals),
        "touches": sum(one.touches for one in arrivals),
        "met": sum(one.met for one in arrivals),
        "curvature_max": max((one.curvature for one in arrivals), default=math.nan),
        "arrival_p95_m": p95([one.off_m for one in reached]),
        "arrival_p95_rad": p95([one.off_rad for one in reached]),
        "believed_p95_m": p95([one.believed_m for one in reached]),
        "path_ratio": length / shortest,
        "speed_ratio": length / max(time, 1e-9) / speed,
        "time_per_metre_s": time / shortest if reached else math.nan,
    }
