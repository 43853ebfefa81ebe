"""A robot in a scene, in lock-step, that is driven to goals and judged by the truth."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_core.se2 import SE2, wrap
from bringup.parameters.files import Parameters, merged
from bringup.scenarios.drive import Drive, believed_pose, desired_speed, placed, room_for
from bringup.scenarios.people import boxes_in, settle, with_boxes
from bringup.scenarios.scenes import SCENES, Scene
from bringup.scenarios.space import FreeSpace
from bringup.terminal import show


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

    @property
    def clean(self) -> bool:
        """True if the goal was reached without a touch."""
        return self.succeeded and not self.touches

    @property
    def score(self) -> float:
        """The shortest path's length over the time [m/s]; 0 if the goal was not reached cleanly."""
        return self.shortest / self.time if self.clean else 0.0


@dataclass(frozen=True)
class Continuation:
    """State in which a process continues the drives of another one.

    Attributes:
        at: Where the robot believes to be; None at its start.
        parameters: Of its simulator.
        began: The simulated time [s].
        walked: By name, how far somebody is on the route already [s].
        goals: How many there were.
    """

    at: SE2 | None = None
    parameters: Parameters = field(default_factory=dict)
    began: float = 0.0
    walked: Mapping[str, float] = field(default_factory=dict)
    goals: int = 0


@contextmanager
def course(
    arguments: argparse.Namespace,
    rng: np.random.Generator,
    folder: Path,
    after: Continuation | None = None,
) -> Iterator[Course]:
    """Give a robot that stands in its scene, with boxes and people about it.

    Args:
        arguments: The options of `goals`.
        rng: For the scene; the goals are drawn from what is left of it.
        folder: For the scene's files.
        after: What it continues, if anything.

    Raises:
        ArjunaError: A file cannot be used, or the map has no room.
    """
    from rclpy.logging import LoggingSeverity, set_logger_level

    from bringup.lockstep import LockStep
    from bringup.parameters.inputs import gather
    from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SIM_GROUP

    set_logger_level("", LoggingSeverity[arguments.log_level.upper()])
    after = after or Continuation()
    scene = SCENES[arguments.scene](arguments, folder, rng)
    arguments.command = "demo"  # whose nodes and parameters the robot has
    arguments.world, arguments.map = scene.world, scene.map
    parameters = gather(arguments)
    room = arguments.radius, room_for(parameters)
    start = scene.start or FreeSpace(scene.grid, *room).draw(rng)
    boxes = boxes_in(scene.grid, arguments.boxes, start, rng)
    grid = with_boxes(scene.grid, boxes)
    parameters = merged(parameters, placed(after.at or start), after.parameters)
    if scene.map is None:
        parameters = merged(parameters, _in_odom(parameters))
    localization = () if scene.map is None else (LOCALIZATION_GROUP,)
    with closing(LockStep(parameters)) as robot:
        robot.start(SIM_GROUP, *localization, NAVIGATION_GROUP)
        robot.run(after.began + 1.0)  # the clock is at 0 until the first tick
        stage = robot.sim.simulator.stage
        settle(stage, grid, boxes, arguments.people, start, rng, after.walked)
        driver = Course(robot, FreeSpace(grid, *room), scene, arguments.out)
        driver.before, driver.number = after.at or start, after.goals
        driver.speed = desired_speed(parameters)
        yield driver


def _in_odom(parameters: Any, size: int = 30) -> dict[str, Any]:
    """Return the parameters that navigate without a map, in a rolling costmap of a size [m]."""
    name = "global_costmap/global_costmap"
    layers = [one for one in parameters[name].get("plugins", []) if one != "static_layer"]
    rolling = {"global_frame": "odom", "rolling_window": True, "width": size, "height": size}
    return {name: {**rolling, "plugins": layers}, "bt_navigator": {"global_frame": "odom"}}


class Course:
    """Drives a robot to goals, and keeps the recordings of some drives that fail.

    Args:
        out: Where recordings go; None for none.
        kept: How many recordings are kept at most.

    Attributes:
        robot: In lock-step.
        space: Where goals are drawn.
        given: The goals of its scene, if it has any.
        before: The last goal that was drawn, or the start.
        number: How many goals it was driven to.
        speed: The speed that its controller is asked to drive [m/s].
    """

    def __init__(
        self, robot: Any, space: FreeSpace, scene: Scene, out: Path | None, kept: int = 3
    ) -> None:
        from bringup.client.goals import Goals

        self.robot, self.given = robot, scene.goals
        self.before, self.number, self.speed = SE2(), 0, math.nan
        self.space, self._out, self._kept, self._goals = space, out, kept, Goals(robot)
        odom = scene.start if scene.map is None else None
        self._frame, self._T_world_frame = ("map", SE2()) if odom is None else ("odom", odom)

    def draw(self, rng: np.random.Generator, shortest: float = 1.0, tries: int = 1000) -> SE2:
        """Return a goal so far from the one before [m]: a nearer one says nothing of the path.

        Raises:
            ArjunaError: None is found.
        """
        self.space.draw(rng)  # seeds keep the goals that they have always had
        self.before = self.space.draw_beyond(self.before, rng, shortest, tries)
        return self.before

    def drive(self, goal: SE2) -> Arrival:
        """Drive to a goal from where the robot is."""
        from bringup.recording.recorder import demo_recorder

        self.number += 1
        path = None if self._out is None else self._out / f"goal_{self.number}.mcap"
        if path is None or self._kept == 0:
            return self._driven(goal, lambda: None)[0]
        with closing(demo_recorder(self.robot.process, path)) as recorder:
            arrival, drive = self._driven(goal, recorder.poll)
        if arrival.clean:
            path.unlink()
        else:
            self._kept -= 1
            self._draw(path, goal, drive.touched_at)
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
        goal: SE2,
        then: Callable[[], None],
        timeout: float = 60.0,
        timeout_per_metre: float = 15.0,
        rest: float = 0.5,
    ) -> tuple[Arrival, Drive]:
        """Drive to a goal within some time [s]; what it believes is read after a rest [s]."""
        robot = self.robot
        drive, start = Drive(robot, then), robot.now
        shortest = self.space.shortest(drive.truth, goal)
        if math.isnan(shortest):  # there is no path, or none from so near a wall
            shortest = drive.truth.distance(goal)
        given = self._T_world_frame.inverse() @ goal
        limit = timeout + timeout_per_metre * shortest
        end = self._goals.navigate(given, limit, frame=self._frame)
        length, time = drive.length, robot.now - start
        robot.run(rest)
        believed = believed_pose(robot, self._frame) or SE2(math.inf)
        arrival = Arrival(
            end.succeeded,
            drive.truth.distance(goal),
            abs(wrap(drive.truth.theta - goal.theta)),
            believed.distance(given),
            length,
            shortest,
            time,
            drive.touches,
            drive.hits,
            drive.curvature if robot.sim.simulator.robot.model.drive.steering else math.nan,
        )
        for line in (end.reason, f"touched {', '.join(drive.touched)}" * bool(drive.touched)):
            if line:
                show(f"     {line}")
        show(_line(self.number, goal, arrival))
        return arrival, drive


def _line(number: int, goal: SE2, one: Arrival) -> str:
    return (
        f"{number:4} ({goal.x:6.2f}, {goal.y:6.2f}) {'reached' if one.succeeded else 'FAILED '}"
        f"{one.time:7.1f} s  path {one.length:6.2f} of {one.shortest:6.2f} m"
        f"  off {one.off_m:.3f} m {one.off_rad:.3f} rad (believed {one.believed_m:.3f} m)"
        f"  touches {one.touches} met {one.met}"
        + (f" curvature {one.curvature:.3f} 1/m" if math.isfinite(one.curvature) else "")
    )
