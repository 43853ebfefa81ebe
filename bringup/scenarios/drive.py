"""Drives of a whole robot in lock-step, judged by the simulator's truth."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import load
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.costmap.footprint import Footprint
from arjuna_sim.model.robot import footprint
from arjuna_sim.model.world import PERSON
from bringup.parameters.files import Parameters, for_node
from bringup.stack import LOCAL_COSTMAP

if TYPE_CHECKING:
    from bringup.lockstep import LockStep

PUSHED = 0.5
"""After somebody has touched the robot, what it touches is their doing [s]."""
AWAY = 0.15
"""Until it is so far from where it was pushed against something, it rubs along it [m]."""


class Meetings:
    """Counts touches of a robot and people, who stop for nobody.

    A touch is the robot's own doing if, when it begins or while it lasts, the robot's side towards
    the person moves towards it: a robot that is at rest, or moves away, has been walked into,
    and one that was pushed may spring back.

    Args:
        corners: The robot's outline about its base `(N, 2)` [m].

    Attributes:
        hits: How many touches there have been.
        bumped: How many of them were the robot's own doing.
    """

    def __init__(self, corners: NDArray[np.float64]) -> None:
        self._outline = Footprint.polygon(corners)
        self._gaps = 0.005, 0.03  # between the two when a touch begins, and when it is over [m]
        self._touching: dict[int, bool] = {}
        self.hits = self.bumped = 0

    @property
    def touching(self) -> bool:
        """True while anybody touches the robot."""
        return bool(self._touching)

    def update(self, pose: SE2, velocity: Velocity, people: NDArray[np.float64]) -> None:
        """Count who touches the robot now.

        Args:
            pose: The robot's.
            velocity: The robot's.
            people: Their middles and radii `(N, 3)` [m].
        """
        reach = self._outline.circumscribed_radius + self._gaps[0]
        near = [math.hypot(x - pose.x, y - pose.y) <= reach + radius for x, y, radius in people]
        if not (self._touching or any(near)):
            return
        seen = pose.inverse().apply(people[:, :2])
        gaps, away = self._outline.gaps(seen)
        sides = seen - gaps[:, None] * away
        for k, gap in enumerate((gaps - people[:, 2]).tolist()):
            before = self._touching.get(k)
            if gap > self._gaps[before is not None]:
                self._touching.pop(k, None)
                continue
            x, y = sides[k]
            speed = float(away[k] @ (velocity.x - velocity.yaw_rate * y, velocity.yaw_rate * x))
            # A slower side has been walked into; who was pushed may come back so slowly [m/s].
            drives = speed > (0.02 if before is None else 0.1)
            self.hits += before is None
            self.bumped += drives and not before
            self._touching[k] = drives or bool(before)


class OwnMotion:
    """The wheels' motion that commands cause; a push turns them as well.

    The wheels move no faster than they were commanded to, but for what they brake.
    """

    def __init__(self) -> None:
        self._at = -math.inf
        self._most = [(0.0, 0.0), (0.0, 0.0)]  # back and ahead, to the right and to the left

    def update(self, now: float, command: Velocity, wheels: Velocity) -> Velocity:
        """Return how the robot moves itself at a time [s], by its command and its wheels."""
        since, self._at = now - self._at, now
        stands = command.x == command.yaw_rate == 0.0
        if stands and max(abs(wheels.x), abs(wheels.yaw_rate)) <= 0.02:  # they have come to rest
            since = math.inf
        asked, moves = (command.x, command.yaw_rate), (wheels.x, wheels.yaw_rate)
        less = 2.0 * since, 8.0 * since  # wheels brake so at least [m/s^2, rad/s^2]
        self._most = [
            (min(one, 0.0, low + step), max(one, 0.0, high - step))
            for one, (low, high), step in zip(asked, self._most, less, strict=True)
        ]
        x, turn = (
            min(max(value, low), high) for value, (low, high) in zip(moves, self._most, strict=True)
        )
        return Velocity(x, yaw_rate=turn)


class Drive:
    """A robot's drive from now on: its length and its contacts.

    Args:
        robot: In lock-step, its simulator running; `on_tick` is taken.
        then: Called after each tick.

    Attributes:
        length: The distance driven so far [m].
        touched: Names of what was touched, in order, people among them.
        touched_at: Where the robot was then.
        curvature: Greatest of the wheels' odometry and of what was commanded [1/m].
    """

    def __init__(self, robot: LockStep, then: Callable[[], None] = lambda: None) -> None:
        self._robot, self._then = robot, then
        self.length, self._contacts, self._pushed = 0.0, 0, 0
        self._pushed_at, self._own = -math.inf, OwnMotion()
        self.touched: list[str] = []
        self.touched_at: list[SE2] = []
        self.curvature, self._stretch, self._at = 0.0, (0.0, 0.0), robot.now
        self._pinned: dict[str, SE2] = {}
        self._before, self._last = frozenset(robot.sim.last.contacts), robot.sim.last
        simulator = robot.sim.simulator
        self._stage = simulator.stage
        self._walkers = [e.name for e in self._stage.entities if e.trajectory is not None]
        self._meetings = Meetings(footprint(simulator.robot.model, simulator.robot.model.urdf.root))
        robot.on_tick = self._watch

    @property
    def truth(self) -> SE2:
        """The robot's pose in the world."""
        pose: SE2 = self._robot.sim.last.truth.pose
        return pose

    @property
    def touches(self) -> int:
        """Contacts with what stands, and with people by the robot's own doing."""
        return self._contacts + self._meetings.bumped

    @property
    def hits(self) -> int:
        """Contacts with people, whoever walked, and with what they push the robot against."""
        return self._meetings.hits + self._pushed

    def _watch(self) -> None:
        last, before = self._robot.sim.last, self._last
        contacts = frozenset(last.contacts)
        self.length += last.truth.pose.distance(before.truth.pose)
        started = sorted(contacts - self._before)
        self.touched += started
        self.touched_at += [last.truth.pose] * len(started)
        positions = [self._stage.motion(name).pose.position[:2] for name in self._walkers]
        people = np.array([(*position, PERSON[0]) for position in positions]).reshape(-1, 3)
        now, setpoint = self._robot.now, self._robot.sim.simulator.robot.setpoint
        tick = now - self._at
        self._bend(setpoint, last.odometry.v * tick, last.odometry.w * tick)
        self._at = now
        wheels = Velocity(before.odometry.v, yaw_rate=before.odometry.w)
        moves = self._own.update(now, setpoint, wheels)
        self._meetings.update(last.truth.pose, moves, people)
        self._pushed_at = now if self._meetings.touching else self._pushed_at
        if now - self._pushed_at <= PUSHED:
            self._pinned.update(dict.fromkeys(contacts, last.truth.pose))
        for name in started:
            if name not in self._walkers:
                self._count(name)
        self._last, self._before = last, contacts
        self._then()

    def _bend(self, setpoint: Velocity, path: float, turn: float) -> None:
        """Measure the curvature commanded, and driven over each stretch in one direction."""
        if setpoint.x != 0.0:
            self.curvature = max(self.curvature, abs(setpoint.yaw_rate / setpoint.x))
        length, angle = self._stretch if path * self._stretch[0] > 0.0 else (0.0, 0.0)
        self._stretch = length + path, angle + turn
        if abs(self._stretch[0]) >= 0.1:  # on less [m], encoders' ticks say little of a bend
            self.curvature = max(self.curvature, abs(self._stretch[1] / self._stretch[0]))
            self._stretch = 0.0, 0.0

    def _count(self, name: str) -> None:
        """Count a contact with what stands: its own, or what somebody pushed it into."""
        where = self._pinned.get(name)
        if where is not None and where.distance(self.truth) <= AWAY:
            self._pushed += 1
        else:
            self._contacts += 1


def placed(pose: SE2) -> Parameters:
    """Return the parameters that put the robot at a pose of the world, and AMCL there as well."""
    start = {"initial_pose.x": pose.x, "initial_pose.y": pose.y, "initial_pose.yaw": pose.theta}
    return {"sim": dict(start), "amcl": {**start, "set_initial_pose": True}}


def believed_pose(robot: LockStep, frame: str = "map") -> SE2 | None:
    """Return the pose of the base in a frame that a robot in lock-step believes in."""
    base = robot.sim.simulator.robot.model.urdf.root
    return robot.process.transforms.try_lookup(frame, base)


def room_for(parameters: Parameters, least: float = 0.5) -> float:
    """Return how far from walls a robot may turn anyhow, as at a goal; some room at least [m]."""
    config: Any = load(LOCAL_COSTMAP.config, for_node(parameters, LOCAL_COSTMAP.name))
    outline = Footprint.parse(config.footprint, config.robot_radius, 0.0, config.axle)
    return max(least, outline.circumscribed_radius)


def desired_speed(parameters: Parameters) -> float:
    """Return the speed that the controller is asked to drive [m/s]."""
    values: dict[str, Any] = parameters.get("controller_server", {})
    return float(values.get("FollowPath.desired_linear_vel", 0.5))
