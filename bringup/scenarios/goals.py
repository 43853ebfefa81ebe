"""Goals in a scene, driven to in lock-step and judged by the truth."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from arjuna_core.errors import ArjunaError
from arjuna_core.files.maps import load_map
from arjuna_core.files.shipped import shipped_file
from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2, wrap
from bringup.scenarios import barn
from bringup.scenarios.doors import Door
from bringup.scenarios.drive import Drive, desired_speed, placed
from bringup.scenarios.furnished import make_room
from bringup.scenarios.people import boxes_in, settle, with_boxes
from bringup.scenarios.space import FreeSpace
from bringup.terminal import show


@dataclass(frozen=True)
class Scene:
    """Where goals are driven to.

    Attributes:
        world: Its file.
        map: The robot's map; None where it navigates in odom, without one.
        grid: All that the robot could touch.
        start: Of the robot; drawn if None.
        goals: In the world; drawn if there are none.
    """

    world: Path
    map: Path | None
    grid: OccupancyGrid
    start: SE2 | None = None
    goals: tuple[SE2, ...] = ()


def _furnished(arguments: argparse.Namespace, folder: Path, rng: np.random.Generator) -> Scene:
    world, seen, whole = make_room(folder, rng)
    return Scene(world, seen, load_map(whole))


def _door(arguments: argparse.Namespace, folder: Path, rng: np.random.Generator) -> Scene:
    door = Door.draw(arguments.width, rng)
    return Scene(*door.save(folder), door.map(), door.start, (door.goal,))


def _field(arguments: argparse.Namespace, folder: Path, rng: np.random.Generator) -> Scene:
    kind = barn.KINDS[int(rng.integers(len(barn.KINDS)))]
    world, grid = barn.make_world(folder, 0, kind, rng)
    return Scene(world, None, grid, barn.START, (barn.START @ SE2(barn.AHEAD, 0.0),))


def _of_file(arguments: argparse.Namespace, folder: Path, rng: np.random.Generator) -> Scene:
    world = arguments.world or shipped_file("worlds/arjuna_room.world")
    own = arguments.map or shipped_file(f"maps/{world.stem}.yaml")
    return Scene(world, own, load_map(arguments.truth or own))


SCENES: dict[str | None, Callable[[argparse.Namespace, Path, np.random.Generator], Scene]] = {
    None: _of_file,
    "furnished": _furnished,
    "door": _door,
    "field": _field,
}
"""The scenes by name; the one without a name is a world's file with its map."""


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
        touched_at: Where the robot was when each contact began.
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
    touched_at: tuple[SE2, ...]

    @property
    def clean(self) -> bool:
        """True if the goal was reached without a touch."""
        return self.succeeded and not self.touches

    @property
    def score(self) -> float:
        """The shortest path's length over the time [m/s]; 0 if the goal was not reached cleanly."""
        return self.shortest / self.time if self.clean else 0.0


def drive_to_goals(arguments: argparse.Namespace) -> dict[str, Any]:
    """Drive to one goal after the other.

    The shortest path is the one that a robot of `--radius` could drive among all that it could
    touch, be it on the robot's map or not: who does not know pays for finding out, and no path is
    asked for that leads through what the map lacks. Its inscribed radius is less than what the
    costmaps keep free, so that the ratio holds the room that a robot leaves beside it too.

    Returns:
        The mean `score` of the goals: the shortest path's length over the time [m/s], 0 where a
        goal was not reached or something touched; `succeeded` and `missed`
        of `count`, `touches`, of people by the robot's own doing, how often it `met` people at
        all, a steered robot's `curvature_max` [1/m], `arrival_p95_m` and `arrival_p95_rad` by the
        truth, `believed_p95_m` by the robot's own word, `path_ratio` to the shortest path (see
        above), `speed_ratio` to the desired speed and `time_per_metre_s` of the shortest path, of
        the goals reached.

    Raises:
        ArjunaError: A file cannot be used, or the map has no room for goals.
    """
    from rclpy.logging import LoggingSeverity, set_logger_level

    set_logger_level("", LoggingSeverity[arguments.log_level.upper()])
    arguments.command = "demo"  # whose nodes and parameters the robot has
    rng = np.random.default_rng(arguments.seed or 0)
    with TemporaryDirectory() as folder:
        scene = SCENES[arguments.scene](arguments, Path(folder), rng)
        return _figures(*_drive(arguments, scene, rng))


def _drive(
    arguments: argparse.Namespace, scene: Scene, rng: np.random.Generator
) -> tuple[list[Arrival], float]:
    from bringup.lockstep import LockStep
    from bringup.parameters.files import merged
    from bringup.parameters.inputs import gather
    from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SIM_GROUP

    space = FreeSpace(scene.grid, arguments.radius)
    start = scene.start or space.draw(rng)
    boxes = boxes_in(scene.grid, arguments.boxes, start, rng)
    grid = with_boxes(scene.grid, boxes)
    space = FreeSpace(grid, arguments.radius)
    arguments.world, arguments.map = scene.world, scene.map
    parameters = merged(gather(arguments), placed(start))
    if scene.map is None:
        parameters = merged(parameters, _in_odom(parameters))
    localization = () if scene.map is None else (LOCALIZATION_GROUP,)
    arrivals: list[Arrival] = []
    with closing(LockStep(parameters)) as robot:
        robot.start(SIM_GROUP, *localization, NAVIGATION_GROUP)
        robot.run(1.0)
        settle(robot.sim.simulator.stage, grid, boxes, arguments.people, start, rng)
        course = _Course(robot, space, None if scene.map else start, arguments.out)
        goals = scene.goals or tuple(_drawn(space, start, arguments.count, rng))
        for before, goal in zip((start, *goals), goals, strict=False):
            arrivals.append(course.drive(before, goal))
            show(_line(len(arrivals), goal, arrivals[-1]))
    return arrivals, desired_speed(parameters)


def _in_odom(parameters: Any, size: int = 30) -> dict[str, Any]:
    """Return the parameters that navigate without a map, in a rolling costmap of a size [m]."""
    name = "global_costmap/global_costmap"
    layers = [one for one in parameters[name].get("plugins", []) if one != "static_layer"]
    rolling = {"global_frame": "odom", "rolling_window": True, "width": size, "height": size}
    return {name: {**rolling, "plugins": layers}, "bt_navigator": {"global_frame": "odom"}}


def _drawn(
    space: FreeSpace,
    start: SE2,
    count: int,
    rng: np.random.Generator,
    shortest: float = 1.0,
    tries: int = 1000,
) -> Iterator[SE2]:
    """Yield goals, each so far from the one before [m]: a nearer one says nothing of the path."""
    for _ in range(count):
        space.draw(rng)  # seeds keep the goals that they have always had
        draws = (space.draw(rng) for _ in range(tries))
        goal = next((one for one in draws if space.shortest(start, one) >= shortest), None)
        if goal is None:
            raise ArjunaError(f"the map has no goals {shortest:g} m from each other")
        yield goal
        start = goal


class _Course:
    """Drives a robot to goals, and keeps the recordings of some drives that fail.

    Args:
        odom: Where the world has the origin of odom, in which goals are given; None for map.
        out: Where recordings go; None for none.
        kept: How many recordings are kept at most.
    """

    def __init__(
        self, robot: Any, space: FreeSpace, odom: SE2 | None, out: Path | None, kept: int = 3
    ) -> None:
        from bringup.client.goals import Goals

        self._robot, self._space, self._out, self._kept = robot, space, out, kept
        self._frame, self._T_world_frame = ("map", SE2()) if odom is None else ("odom", odom)
        self._goals, self._number = Goals(robot), 0

    def drive(self, before: SE2, goal: SE2) -> Arrival:
        """Drive to a goal from where the robot is, which is near the goal before."""
        from bringup.recording.recorder import demo_recorder

        self._number += 1
        path = None if self._out is None else self._out / f"goal_{self._number}.mcap"
        if path is None or self._kept == 0:
            return self._driven(before, goal, lambda: None)
        with closing(demo_recorder(self._robot.process, path)) as recorder:
            arrival = self._driven(before, goal, recorder.poll)
        if arrival.clean:
            path.unlink()
        else:
            self._kept -= 1
            self._draw(path, goal, arrival.touched_at)
        return arrival

    def _draw(self, recording: Path, goal: SE2, touched_at: Sequence[SE2]) -> None:
        from arjuna_core.bags.reader import Bag
        from bringup.viewing.pictures import draw_snapshot
        from bringup.viewing.snapshot import snapshot_of

        snapshot, T_frame_world = snapshot_of(Bag(recording)), self._T_world_frame.inverse()
        snapshot.goals.append(T_frame_world @ goal)
        snapshot.touches += [T_frame_world @ pose for pose in touched_at]
        draw_snapshot(recording.with_suffix(".png"), snapshot)

    def _driven(
        self,
        before: SE2,
        goal: SE2,
        then: Callable[[], None],
        timeout: float = 60.0,
        timeout_per_metre: float = 15.0,
        rest: float = 0.5,
    ) -> Arrival:
        """Drive to a goal within some time [s]; what it believes is read after a rest [s]."""
        robot, frame = self._robot, self._frame
        drive, start = Drive(robot, then), robot.now
        from_poses = (self._space.shortest(pose, goal) for pose in (drive.truth, before))
        straight = drive.truth.distance(goal)  # where it has been left too near a wall, or no path
        shortest = next(filter(math.isfinite, from_poses), straight)
        given = self._T_world_frame.inverse() @ goal
        limit = timeout + timeout_per_metre * shortest
        end = self._goals.navigate(given, limit, frame=frame)
        length, time = drive.length, robot.now - start
        if not end.succeeded:
            show(f"     {end.reason}")
        robot.run(rest)
        if drive.touched:
            show(f"     touched {', '.join(drive.touched)}")
        model = robot.sim.simulator.robot.model
        believed = robot.process.transforms.try_lookup(frame, model.urdf.root) or SE2(math.inf)
        return Arrival(
            end.succeeded,
            drive.truth.distance(goal),
            abs(wrap(drive.truth.theta - goal.theta)),
            believed.distance(given),
            length,
            shortest,
            time,
            drive.touches,
            drive.hits,
            drive.curvature if model.drive.steering else math.nan,
            tuple(drive.touched_at),
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
    result = {
        "score": float(np.mean([one.score for one in arrivals])),
        "succeeded": len(reached),
        "count": len(arrivals),
        "missed": len(arrivals) - len(reached),
        "touches": sum(one.touches for one in arrivals),
        "met": sum(one.met for one in arrivals),
        "curvature_max": max((one.curvature for one in arrivals), default=math.nan),
        "arrival_p95_m": p95([one.off_m for one in reached]),
        "arrival_p95_rad": p95([one.off_rad for one in reached]),
        "believed_p95_m": p95([one.believed_m for one in reached]),
        "path_ratio": length / shortest if reached else math.nan,
        "speed_ratio": length / max(time, 1e-9) / speed if reached else math.nan,
        "time_per_metre_s": time / shortest if reached else math.nan,
    }
    for name, value in result.items():
        show(f"{name:16}{value:10.4g}")
    return result
