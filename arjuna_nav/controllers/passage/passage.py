"""Through a place hardly wider than the robot: lined up before it, then along its middle."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.arrival import Arrival, ArrivalConfig
from arjuna_nav.controllers.manoeuvre.manoeuvre import Manoeuvre, ManoeuvreConfig
from arjuna_nav.controllers.passage.strip import follow_line, line_bend, widest_strip
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.turning.passage import first_blocked

_SPANS = (0.3, 0.15)  # of the strip before and behind the narrowest place, the first that does [m]
_BESIDE, _TURNED = 0.25, 0.8  # how far the strip may be off the path [m], [rad]
_SHIFT, _TILT = 0.06, 0.1  # how far it may have moved since the last look [m], [rad]
_NEWEST = 0.3  # weight of the newest look
_SIDES = 0.15  # beside the robot, within which points make a place narrow [m]
_BEFORE = 0.12  # from the nose to the place where it lines up before it [m]
_RUN_UP = 0.25  # more, in which it is steered onto the line without lining up [m]
_AHEAD = 0.15  # of the motion that must be free [m]
_LOOKAHEAD = 0.2  # of the steering [m]
_STEP = 0.02  # between two looks at a motion [m]
_EASY = 0.08  # room on each side from which on a gap is not tight [m]
_ALONG = 0.5  # how far the robot may look off the line to be steered onto it [rad]
_ROOM = 1.0  # of the path, in which the outline fits where the gap is over [m]
_WAITS = 1.0  # for points that come and go [s]
_TRIES = 3  # at one gap, each with a run-up


@dataclass(frozen=True)
class PassageConfig:
    """How a place is driven through that is hardly wider than the robot."""

    enabled: bool = param(True, "Whether the robot lines up for places that its cells close.")
    margin: float = param(
        0.005, "Room on each side of the robot without its padding.", unit="m", minimum=0.0
    )
    max_speed: float = param(
        0.3, "Speed in it; half of that where it is tight.", unit="m/s", minimum=0.02
    )
    max_angular_velocity: float = param(1.0, "Yaw rate in it.", unit="rad/s", minimum=0.05)
    reach: float = param(1.5, "How far ahead on the path it is looked for.", unit="m", minimum=0.1)


class _Stage(enum.Enum):
    AWAY = enum.auto()
    COMING = enum.auto()
    LINING_UP = enum.auto()
    THROUGH = enum.auto()


class Passage:
    """Takes over from any controller before a gap that cells are too coarse for.

    The gap's middle line is the widest strip between the points that scans have hit, so neither
    the cells nor an error of the path on the map count.

    Args:
        config: Parameters.
        manoeuvre: How the robot comes to where it lines up.
        footprint: The robot, with padding.
        body: Without.
    """

    def __init__(
        self,
        config: PassageConfig,
        manoeuvre: ManoeuvreConfig,
        footprint: Footprint,
        body: Footprint,
    ) -> None:
        self._config = config
        self._manoeuvre = Manoeuvre(manoeuvre, footprint)
        self._arrival = Arrival(ArrivalConfig(), body)
        self._footprint = footprint
        self._outline = body.scaled(1.0 + config.margin / body.inscribed_radius).points
        (self._rear, right), (self._front, left) = (
            self._outline.min(axis=0),
            self._outline.max(axis=0),
        )
        self._half, self._middle = 0.5 * (left - right), 0.5 * (left + right)
        self.reset()

    @property
    def active(self) -> bool:
        """Whether there is something left to drive."""
        return self._stage is not _Stage.AWAY

    @property
    def _speed(self) -> float:
        """How fast to drive through [m/s]."""
        room = 0.5 * self._width - self._half
        return float(self._config.max_speed * min(max(room / _EASY, 0.5), 1.0))

    def reset(self) -> None:
        """Let go."""
        self._stage = _Stage.AWAY
        self._line, self._entry, self._width, self._tries = SE2(), SE2(), 0.0, 0
        self._blocked_since = math.inf

    def begin(self, pose: SE2, path: NDArray[np.float64], costmap: Costmap) -> bool:
        """Look for a gap on the path ahead, and tell whether there is one to drive through."""
        self.reset()
        if not self._config.enabled or len(path) < 2:
            return False
        points = costmap.obstacles(pose.x, pose.y, self._config.reach + 0.5)
        place = self._narrowest(path, points)
        strip = None if place is None else self._found(place, points)
        if strip is None:
            return False
        self._line, self._width = strip
        return self._start(pose, points, costmap)

    def compute(
        self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float
    ) -> Velocity | None:
        """Return what to drive, None where it is through or finds no way."""
        if self._stage is _Stage.AWAY:
            return None
        points = costmap.obstacles(pose.x, pose.y, self._config.reach + 0.5)
        self._look_again(pose, points)
        if self._stage is _Stage.COMING:
            command = self._manoeuvre.compute(pose, costmap)
            if command is not None:
                return command
            self._stage = _Stage.LINING_UP
            self._arrival.reset()
            if self._is_open(pose, points):
                self._stage = _Stage.THROUGH
        if self._stage is _Stage.LINING_UP:
            command = self._line_up(pose, velocity, costmap, now)
            if command is not None:
                return command
            self._stage, self._blocked_since = _Stage.THROUGH, math.inf
        return self._drive(pose, points, costmap, now)

    def may_end(self, pose: SE2, path: NDArray[np.float64], costmap: Costmap) -> bool:
        """Tell whether a controller may go on from here, if it can.

        It may where the narrowest place is behind the robot's middle, and the outline fits where
        the path leads: points beside the line need not be those of the gap.
        """
        if self._stage is not _Stage.THROUGH or (self._line.inverse() @ pose).x < 0.0:
            return False
        ahead = paths.ahead(path, pose)
        near = ahead[paths.along(ahead) <= _ROOM]
        return first_blocked(near, costmap, self._footprint) is None

    def _narrowest(self, path: NDArray[np.float64], points: NDArray[np.float64]) -> SE2 | None:
        """Return the path's pose that is nearest to an obstacle, None where there is room."""
        along = paths.along(path)
        near = path[along <= self._config.reach]
        if not len(points):
            return None
        gaps = np.hypot(*(near[:, None, :2] - points[None, :, :]).transpose(2, 0, 1)).min(axis=1)
        k = int(np.argmin(gaps))
        if gaps[k] > self._half + _SIDES:
            return None
        first, last = np.searchsorted(along, [along[k] - 0.2, along[k] + 0.2])
        dx, dy = path[min(int(last), len(path) - 1), :2] - path[int(first), :2]
        return SE2(float(near[k, 0]), float(near[k, 1]), math.atan2(dy, dx))

    def _found(self, place: SE2, points: NDArray[np.float64]) -> tuple[SE2, float] | None:
        """Return the middle line of a gap that is narrow, yet wide enough, and its width [m]."""
        seen = place.inverse().apply(points)
        for span in _SPANS:
            strip = widest_strip(seen, (-span, span), _BESIDE, _TURNED, 0.04)
            if strip is not None and 0.0 <= strip[1] - 2.0 * self._half <= 2.0 * _SIDES:
                return place @ strip[0], strip[1]
        return None

    def _start(self, pose: SE2, points: NDArray[np.float64], costmap: Costmap) -> bool:
        """Drive on where that is free, else come to the place before the gap, if it is ahead."""
        seen, at = self._line.inverse().apply(points), self._line.inverse() @ pose
        first, last = self._extent(seen)
        self._entry = self._line @ SE2(first - self._front - _BEFORE, -self._middle)
        if at.x < last and self._is_open(pose, points):
            self._stage = _Stage.THROUGH
            return True
        self._tries += 1
        before = self._entry @ SE2(-_RUN_UP, 0.0), self._entry
        again = at.x < last and self._tries <= _TRIES
        if again and any(self._manoeuvre.begin_to(pose, one, costmap) for one in before):
            self._stage = _Stage.COMING
            return True
        self.reset()
        return False

    def _is_open(self, pose: SE2, points: NDArray[np.float64]) -> bool:
        """Tell whether the robot comes through from here, steered onto the line on its way."""
        seen, at = self._line.inverse().apply(points), self._line.inverse() @ pose
        way = self._extent(seen)[1] - self._rear - at.x
        return abs(at.theta) < _ALONG and self._free(at, seen, way) >= way

    def _extent(self, seen: NDArray[np.float64]) -> tuple[float, float]:
        """Return from where to where points beside the line make it narrow [m]."""
        beside = np.abs(seen[:, 1]) < self._half + _SIDES
        along = seen[beside & (np.abs(seen[:, 0]) < 2.0 * _SPANS[0]), 0]
        return (float(along.min()), float(along.max())) if len(along) else (0.0, 0.0)

    def _look_again(self, pose: SE2, points: NDArray[np.float64]) -> None:
        """Follow the line as it is seen now: odometry drifts, and places on a map jump."""
        at = self._line.inverse() @ pose
        inside = self._stage is _Stage.THROUGH
        place = self._line @ SE2(at.x, 0.0) if inside else self._line
        window = (self._rear, self._front + _SPANS[0]) if inside else (-_SPANS[0], _SPANS[0])
        strip = widest_strip(place.inverse().apply(points), window, _SHIFT, _TILT)
        if strip is not None and strip[1] < 2.0 * (self._half + _SIDES):
            seen, self._width = strip
            newest = SE2(_NEWEST * seen.x, _NEWEST * seen.y, _NEWEST * seen.theta)
            shift = place @ newest @ place.inverse()
            self._line, self._entry = shift @ self._line, shift @ self._entry

    def _line_up(
        self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float
    ) -> Velocity | None:
        left = pose.distance(self._entry)
        return self._arrival.compute(
            pose,
            self._entry,
            velocity,
            costmap,
            now,
            left=left,
            speed=self._speed,
            within=True,
            heading=True,
        )

    def _drive(
        self, pose: SE2, points: NDArray[np.float64], costmap: Costmap, now: float
    ) -> Velocity | None:
        """Return what drives along the line; None where the robot is through or cannot go on."""
        seen, at = self._line.inverse().apply(points), self._line.inverse() @ pose
        beside = np.abs(seen[:, 1]) < self._half + _SIDES
        along = seen[beside, 0] - at.x
        if not ((along > self._rear) & (along < self._front + 2.0 * _SPANS[0])).any():
            self.reset()
            return None
        if self._free(at, seen, _AHEAD) >= _AHEAD:
            self._blocked_since = math.inf
            return self._steered(at)
        self._blocked_since = min(self._blocked_since, now)
        if now - self._blocked_since < _WAITS:
            return Velocity()
        return Velocity() if self._start(pose, points, costmap) else None

    def _steered(self, at: SE2) -> Velocity:
        w = self._speed * line_bend(at.y + self._middle, at.theta, _LOOKAHEAD)
        limit = self._config.max_angular_velocity
        return Velocity(self._speed, yaw_rate=min(max(w, -limit), limit))

    def _free(self, at: SE2, seen: NDArray[np.float64], distance: float) -> float:
        sharpest = self._config.max_angular_velocity / self._speed
        pose = at.x, at.y + self._middle, at.theta
        shifted = seen + np.array([0.0, self._middle])
        return float(
            follow_line(pose, shifted, self._outline, _LOOKAHEAD, sharpest, distance, _STEP)
        )
