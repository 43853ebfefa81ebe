"""Drives played without physics or ROS: noisy scans of walls, poses that err, the real cores."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import load
from arjuna_core.files.shipped import shipped_file
from arjuna_core.files.yaml_file import read_yaml
from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.follower import FollowerConfig, FollowState, PathFollower
from arjuna_nav.costmap import LayeredCostmap, PlacedScan
from arjuna_nav.costmap.moving.tracker import REACH, Moving, Tracker
from arjuna_nav.planners.base import PlanStatus
from arjuna_nav.planners.navfn import NavFn, NavFnConfig
from arjuna_nav.planners.query import plan_through
from arjuna_nav.safety.collision_monitor import CollisionMonitor, MonitorConfig
from arjuna_nav.safety.sight import Sight
from bringup.scenarios.drive import AWAY, PUSHED, Meetings
from tests.helpers.nav.layers import Body, see, whole_map, window
from tests.helpers.nav.people import Pushes
from tests.nav.worlds import Unicycle

_TICK, _SCANS, _MAPS, _PLANS = 0.05, 2, 10, 20  # [s], and ticks from one to the next
_STANDS = 2.0  # after a failure [s]
_SENSING = 1.0  # about itself among people before it sets out: its senses run before any goal [s]
_BEAMS, _RANGE = 360, 12.0
_ACCELERATION, _ANGULAR_ACCELERATION = 2.5, 3.2  # Arjuna's, simulated [m/s^2], [rad/s^2]
_KEPT = 0.98  # of an error from tick to tick


@dataclass(frozen=True)
class Errors:
    """Errors of the robot's senses.

    Attributes:
        scan: Deviation of ranges [m].
        position: Deviation of the pose that it believes in, slowly changing [m].
        heading: The same of its heading [rad].
        drift: Of odometry, a metre driven [m].
    """

    scan: float = 0.01
    position: float = 0.02
    heading: float = 0.01
    drift: float = 0.06


class Play:
    """One drive.

    Args:
        walls: Segments `(N, 4)` x0, y0, x1, y1 of the world [m].
        grid: The map; None for none: it navigates in odom.
        people: Gives the segments of each of those who walk, at a time [s].

    Attributes:
        arrived: Whether the follower says so.
        touched: Whether the robot met a wall by itself.
        time: [s]
        why: What was said last where it stood still.
    """

    def __init__(
        self,
        walls: NDArray[np.float64],
        grid: OccupancyGrid | None,
        start: SE2,
        goal: SE2,
        body: Body,
        rng: np.random.Generator,
        errors: Errors | None = None,
        people: Callable[[float], list[NDArray[np.float64]]] | None = None,
    ) -> None:
        self._walls, self._goal, self._body, self._rng = walls, goal, body, rng
        self._errors, self._people = errors or Errors(), people or (lambda time: [])
        self._monitor, self._tracker = (
            CollisionMonitor(load(MonitorConfig, shipped_zones())),
            Tracker(REACH),
        )
        self._moving = Moving.nothing()
        self._near = LayeredCostmap(window(3, 2.5, body))
        self._far = LayeredCostmap(window(14, 3.0, body) if grid is None else whole_map(body))
        if grid is not None:
            self._far.set_map(grid)
        self._has_map = grid is not None
        self._unmapped: list[PlacedScan] = []
        self._config = load(FollowerConfig, _followed())
        self._follower: PathFollower | None = None
        self._stands = _SENSING if people else -math.inf
        self._T_true_map = self._T_true_odom = SE2()
        self.robot = Unicycle(
            start,
            period=_TICK,
            acceleration=_ACCELERATION,
            angular_acceleration=_ANGULAR_ACCELERATION,
        )
        self.arrived = self.touched = False
        self.meetings, self._pushes = Meetings(body.corners), Pushes(body.corners, walls)
        self._pushed_at, self._pinned = -math.inf, SE2(math.inf, math.inf)
        self.time, self.why = 0.0, ""

    def run(self, timeout: float = 90.0) -> Play:
        """Drive to the end."""
        for k in range(round(timeout / _TICK)):
            self.time = k * _TICK
            self._err()
            people = self._people(self.time)
            self._see(k, people)
            self.robot.drive(self._allowed(self._command(k)))
            self._meet(people)
            if self.arrived or self.touched:
                break
        return self

    def _meet(self, people: list[NDArray[np.float64]]) -> None:
        """Return whether the robot has met a wall by itself; let people push it, but into none."""
        pose = self.robot.pose
        crosses = _crosses(self._walls, pose.apply(self._body.corners))
        rounds = [(edges[:, :2].mean(axis=0), edges[0, :2]) for edges in people]
        discs = np.array([(*middle, np.hypot(*(edge - middle))) for middle, edge in rounds])
        discs = discs.reshape(-1, 3)
        self.meetings.update(pose, self.robot.velocity, discs)
        self._pushed_at = self.time if self.meetings.touching else self._pushed_at
        pushed = self._pushes.yield_to(pose, discs)
        if self.time - self._pushed_at <= PUSHED and self._pushes.pinned:
            self._pinned = pushed
        self.touched = crosses and pushed.distance(self._pinned) > AWAY
        if not self.touched:
            self.robot.pose = pushed

    def _allowed(self, command: Velocity) -> Velocity:
        """Return what the collision monitor lets through."""
        moving, T_base_odom = self._moving, self._in_odom.inverse()
        points, turn = T_base_odom.apply(moving.points), SE2(0.0, 0.0, T_base_odom.theta)
        sight = Sight.of(points, turn.apply(moving.velocities), moving.speeds)
        sight = sight.later(self.time - moving.stamp)
        return self._monitor.judge(command, sight, self._near.body).velocity

    def _err(self) -> None:
        errors, spread = self._errors, math.sqrt(1.0 - _KEPT**2)
        x, y, w = spread * self._rng.normal(0.0, 1.0, 3) * (*[errors.position] * 2, errors.heading)
        at, driven = self._T_true_map, abs(self.robot.velocity.x) * _TICK
        self._T_true_map = SE2(_KEPT * at.x + x, _KEPT * at.y + y, _KEPT * at.theta + w)
        slips = self._rng.normal(0.0, errors.drift * driven, 3).tolist()
        self._T_true_odom = self._T_true_odom @ SE2(*slips)

    @property
    def _in_odom(self) -> SE2:
        return self.robot.pose @ self._T_true_odom

    @property
    def _in_map(self) -> SE2:
        return self.robot.pose @ self._T_true_map if self._has_map else self._in_odom

    def _see(self, tick: int, people: list[NDArray[np.float64]]) -> None:
        if tick % _SCANS:
            return
        edges = np.vstack([self._walls, *people])
        scan = scan_of(edges, self.robot.pose, self._rng, self._errors.scan, self.time)
        self._moving = self._tracker.update(scan, self._in_odom)
        see(self._near, self._in_odom, self.time, [PlacedScan(scan, self._in_odom)])
        self._unmapped.append(PlacedScan(scan, self._in_map))
        if tick % _MAPS == 0:
            see(self._far, self._in_map, self.time, self._unmapped)
            self._unmapped = []

    def _command(self, tick: int) -> Velocity:
        if self.time < self._stands:
            return STILL
        if (self._follower is None or tick % _PLANS == 0) and not self._plan():
            return STILL
        assert self._follower is not None
        T_map_odom = self._in_map @ self._in_odom.inverse()
        costmap = self._near.costmap.seen_from(T_map_odom)
        result = self._follower.tick(self._in_map, self.robot.velocity, costmap, self.time)
        if result.state is FollowState.FAILED:
            self._fail(result.message)
        self.arrived = result.state is FollowState.SUCCEEDED
        return result.velocity

    def _plan(self) -> bool:
        planner, far = NavFn(NavFnConfig()), self._far
        plan = plan_through(planner, far.costmap, self._in_map, [self._goal], far.footprint)
        if plan.status is not PlanStatus.SUCCEEDED:
            self._fail(plan.message)
            return False
        if self._follower is None:
            self._follower = PathFollower(self._config, self._near.footprint, body=self._near.body)
            self._follower.start(plan.path, self.time)
        self._follower.change(plan.path)
        return True

    def _fail(self, why: str) -> None:
        self.why, self._stands, self._follower = why, self.time + _STANDS, None


def shipped_zones() -> dict[str, Any]:
    """Return the zones of Arjuna's collision monitor."""
    values = _shipped("collision_monitor")
    return {name: values[name] for name in ("polygons", *values["polygons"])}


def _followed() -> dict[str, Any]:
    """Return the parameters that Arjuna follows paths with, without those of its node alone."""
    values = _shipped("controller_server")
    return {key: each for key, each in values.items() if not key.endswith("_velocity_threshold")}


def _shipped(node: str) -> dict[str, Any]:
    """Return the parameters that Arjuna's node has."""
    file = read_yaml(shipped_file("params/arjuna_nav.yaml"))
    parameters: dict[str, Any] = file[node]["ros__parameters"]
    return parameters


def scan_of(
    walls: NDArray[np.float64],
    pose: SE2,
    rng: np.random.Generator,
    deviation: float,
    now: float,
) -> Scan:
    """Return a noisy scan of segments."""
    step = 2.0 * math.pi / _BEAMS
    angles = -math.pi + step * np.arange(_BEAMS) + pose.theta
    d = np.column_stack((np.cos(angles), np.sin(angles)))
    a, e = walls[:, :2] - (pose.x, pose.y), walls[:, 2:] - walls[:, :2]
    with np.errstate(divide="ignore", invalid="ignore"):
        cross = d[:, :1] * e[:, 1] - d[:, 1:] * e[:, 0]
        t = (a[:, 0] * e[:, 1] - a[:, 1] * e[:, 0]) / cross
        u = (a[:, 0] * d[:, 1:] - a[:, 1] * d[:, :1]) / cross
    t[~((t > 0.0) & (u >= 0.0) & (u <= 1.0))] = np.inf
    ranges = t.min(axis=1) + rng.normal(0.0, deviation, _BEAMS)
    ranges[ranges >= _RANGE] = np.inf
    return Scan(ranges, -math.pi, step, 0.12, _RANGE, now)


def _crosses(walls: NDArray[np.float64], corners: NDArray[np.float64]) -> bool:
    """Return whether an outline crosses a segment."""
    a, b = corners, np.roll(corners, -1, axis=0)
    p, q = walls[:, None, :2], walls[:, None, 2:]

    def side(o: Any, v: Any, w: Any) -> Any:
        v, w = v - o, w - o
        return v[..., 0] * w[..., 1] - v[..., 1] * w[..., 0]

    across = (side(a, b, p) * side(a, b, q) < 0) & (side(p, q, a) * side(p, q, b) < 0)
    return bool(across.any())
