"""Back onto the path from where a controller finds no way: a searched one, then driven."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.motion import rollout
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import collides, first_collision
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.turning.passage import Terms, find_way, first_blocked

_LOOK = 0.5  # the command's own arc is checked this far ahead, or to its piece's end [s]
_CHORD = 0.3  # over which a path's direction is taken [m]
_TARGETS = 4  # on the path, that ways are looked for to
_STOP = 0.3  # a stop is as dear as a turn by so much [rad]
_DONE, _TURNED = 0.015, 0.05  # what may be left of a piece [m], [rad]
_LOOKAHEAD = 0.2  # on a stretch [m]
_AWAY = 0.3  # driven ahead before a controller goes on: what stopped it is passed [m]
_SLOWEST_TURN = 0.25  # what skidding wheels still do evenly [rad/s]


@dataclass(frozen=True)
class ManoeuvreConfig:
    """How the robot gets back onto its path where the controller finds no way."""

    enabled: bool = param(
        True, "Whether to look for a way by bends, turns and back where the controller has none."
    )
    max_speed: float = param(0.3, "Greatest speed.", unit="m/s", minimum=0.02)
    max_angular_velocity: float = param(1.0, "Greatest yaw rate.", unit="rad/s", minimum=0.1)
    deceleration: float = param(0.5, "Of braking to a stop.", unit="m/s^2", minimum=0.05)
    angular_deceleration: float = param(
        1.5, "Of braking at a turn's end.", unit="rad/s^2", minimum=0.05
    )
    rejoin_distance: float = param(
        0.5, "How far ahead on the path it leads at the least.", unit="m", minimum=0.1
    )
    reach: float = param(2.5, "How far ahead at the most.", unit="m", minimum=0.1)


class _Piece(NamedTuple):
    """A stretch of a way: poses `(N, 3)` driven ahead (1) or back (-1), or a turn (0)."""

    poses: NDArray[np.float64]
    drive: int

    @property
    def start(self) -> SE2:
        return SE2.from_array(self.poses[0])

    @property
    def end(self) -> SE2:
        return SE2.from_array(self.poses[-1])


class Manoeuvre:
    """Takes over from any controller that fails, and brings the robot to the path farther on.

    Its way is made of bends ahead, straights back and turns on the spot, the outline checked.

    Args:
        config: Parameters.
        footprint: The robot.
    """

    def __init__(self, config: ManoeuvreConfig, footprint: Footprint) -> None:
        self._config = config
        self._footprint = footprint
        self._pieces: list[_Piece] = []

    @property
    def active(self) -> bool:
        """Whether there is something left to drive."""
        return bool(self._pieces)

    @property
    def _goes_on(self) -> bool:
        """Whether it ends in driving ahead: the controller takes over without a stop."""
        return len(self._pieces) == 1 and self._pieces[0].drive > 0

    def reset(self) -> None:
        """Let go."""
        self._pieces = []

    def begin(self, pose: SE2, path: NDArray[np.float64], costmap: Costmap) -> bool:
        """Look for a way to the path ahead, and tell whether there is one."""
        self.reset()
        if not self._config.enabled:
            return False
        terms, least = self._terms(), math.inf
        for target, along in self._targets(path, costmap):
            way = find_way(pose, target, costmap, self._footprint, terms)
            if len(way) > 1 and terms.worth(way) - along < least:
                least = terms.worth(way) - along
                self._pieces = list(_pieces(way))
        return self.active

    def begin_to(self, pose: SE2, target: SE2, costmap: Costmap) -> bool:
        """Look for a way to near a pose, and tell whether there is one."""
        way = find_way(pose, target, costmap, self._footprint, self._terms())
        self._pieces = list(_pieces(way)) if len(way) > 1 else []
        return len(way) > 0

    def _terms(self) -> Terms:
        turn = self._config.max_speed / self._config.max_angular_velocity  # by its time
        return Terms(turn, _STOP * turn, back=2.0, distance=0.1, angle=0.26, limit=60000)

    def compute(self, pose: SE2, costmap: Costmap) -> Velocity | None:
        """Return what to drive, None where it has come to its end or something is in the way."""
        while self._pieces and self._is_done(self._pieces[0], pose):
            self._pieces.pop(0)
        if not self._pieces:
            return None
        piece = self._pieces[0]
        command = self._command(piece, pose)
        look = _LOOK if self._goes_on else min(_LOOK, _until(piece, pose, command))
        arc = rollout(pose, command, look, costmap.frame.resolution)
        if first_collision(costmap, self._footprint, arc) is not None:
            self.reset()
            return None
        return command

    def leads_to(self, path: NDArray[np.float64]) -> bool:
        """Tell whether its way ends near a path."""
        gaps = paths.distances(path, self._pieces[-1].end)
        return float(gaps.min()) <= self._config.rejoin_distance

    def may_end(self, pose: SE2, path: NDArray[np.float64], costmap: Costmap) -> bool:
        """Tell whether a controller may go on from here, if it can: farther and faster.

        It may where there is nothing left but to drive ahead, some way of that is done, and the
        outline fits where the path leads now.
        """
        if not self._goes_on or pose.distance(self._pieces[0].start) < _AWAY:
            return False
        ahead = paths.ahead(path, pose)
        near = ahead[paths.along(ahead) <= 2.0 * self._config.rejoin_distance]
        return first_blocked(near, costmap, self._footprint) is None

    def _targets(self, path: NDArray[np.float64], costmap: Costmap) -> Iterator[tuple[SE2, float]]:
        """Give poses of the path where the outline is free, and how far along they are [m]."""
        config = self._config
        along = paths.along(path)
        last = min(config.reach, along[-1])
        for distance in np.linspace(min(config.rejoin_distance, last), last, _TARGETS):
            i = int(np.searchsorted(along, distance - 1e-9))
            before = int(np.searchsorted(along, max(along[i] - _CHORD, 0.0)))
            dx, dy = path[i, :2] - path[before, :2]
            yaw = math.atan2(dy, dx) if i > before else float(path[i, 2])
            target = SE2(float(path[i, 0]), float(path[i, 1]), yaw)
            if not collides(costmap, self._footprint, target):
                yield target, float(along[i])

    def _is_done(self, piece: _Piece, pose: SE2) -> bool:
        if piece.drive == 0:
            return abs(wrap(piece.end.theta - pose.theta)) <= _TURNED
        beyond = piece.drive * (pose.inverse() @ piece.end).x <= _DONE
        return beyond and paths.nearest(piece.poses, pose) == len(piece.poses) - 1

    def _command(self, piece: _Piece, pose: SE2) -> Velocity:
        config, seen = self._config, pose.inverse() @ piece.end
        off = wrap(seen.theta)
        if piece.drive == 0:
            rate = math.sqrt(2.0 * config.angular_deceleration * abs(off))
            rate = max(min(rate, config.max_angular_velocity), _SLOWEST_TURN)
            return Velocity(yaw_rate=math.copysign(rate, off))
        braking = math.sqrt(2.0 * config.deceleration * abs(seen.x)) + 0.03
        v = piece.drive * min(config.max_speed, math.inf if self._goes_on else braking)
        w, limit = v * _curvature(piece, pose), config.max_angular_velocity
        if abs(w) > limit:
            v, w = v * limit / abs(w), math.copysign(limit, w)
        return Velocity(v, yaw_rate=w)


def _curvature(piece: _Piece, pose: SE2) -> float:
    """Return the bend [1/m] of the arc to a point of a stretch a little way on."""
    gaps = np.hypot(piece.poses[:, 0] - pose.x, piece.poses[:, 1] - pose.y)
    here = int(np.argmin(gaps))
    beyond = np.flatnonzero(gaps[here:] >= _LOOKAHEAD)
    if len(beyond):
        point = SE2.from_array(piece.poses[here + int(beyond[0])])
    else:
        point = piece.end @ SE2(_LOOKAHEAD * piece.drive, 0.0)
    seen = pose.inverse() @ point
    return 2.0 * seen.y / max(seen.x**2 + seen.y**2, 1e-6)


def _until(piece: _Piece, pose: SE2, command: Velocity) -> float:
    """Return how long it takes a command to the piece's end [s]."""
    if piece.drive == 0:
        return abs(float(wrap(piece.end.theta - pose.theta))) / abs(command.yaw_rate)
    return (pose.distance(piece.end) + _DONE) / abs(command.x)


def _pieces(way: NDArray[np.float64]) -> Iterator[_Piece]:
    """Give a way's stretches, each as long as it can be."""
    kinds = [_kind(a, b) for a, b in itertools.pairwise(way)]
    first = 0
    for k, kind in enumerate(kinds):
        if k + 1 == len(kinds) or kinds[k + 1] != kind:
            yield _Piece(way[first : k + 2], kind[0])
            first = k + 1


def _kind(a: NDArray[np.float64], b: NDArray[np.float64]) -> tuple[int, int]:
    """Return 1 for ahead, -1 for back, 0 for a turn, and that turn's sign."""
    dx, dy = b[:2] - a[:2]
    ahead = math.cos(a[2]) * dx + math.sin(a[2]) * dy
    if abs(ahead) < 1e-6:
        return 0, int(np.sign(b[2] - a[2]))
    return int(np.sign(ahead)), 0
