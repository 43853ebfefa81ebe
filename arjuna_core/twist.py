"""The planar velocity of a robot's base."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import KW_ONLY, dataclass


@dataclass(frozen=True)
class Velocity:
    """A planar twist in the frame of the robot's base.

    Attributes:
        x: Forward speed [m/s].
        y: Speed to the left [m/s].
        yaw_rate: Counter-clockwise [rad/s].
    """

    x: float = 0.0
    _: KW_ONLY
    y: float = 0.0
    yaw_rate: float = 0.0

    @property
    def speed(self) -> float:
        """Speed over ground, whatever the direction [m/s]."""
        return math.hypot(self.x, self.y)

    @property
    def is_finite(self) -> bool:
        """True where all parts are finite."""
        return all(map(math.isfinite, (self.x, self.y, self.yaw_rate)))

    def scaled(self, part: float) -> Velocity:
        """Return a part of it; the course stays."""
        return Velocity(self.x * part, y=self.y * part, yaw_rate=self.yaw_rate * part)


STILL = Velocity()


class RecentVelocities:
    """The velocities that were measured within a duration [s], up to the newest.

    Source: nav2_util, OdomSmoother.
    """

    def __init__(self, duration: float) -> None:
        self._duration = duration
        self._kept: deque[tuple[float, Velocity]] = deque()

    def add(self, velocity: Velocity, stamp: float) -> None:
        """Take the newest, measured at a time [s]; an earlier time is another run of time."""
        if self._kept and stamp < self._kept[-1][0]:
            self._kept.clear()
        self._kept.append((stamp, velocity))
        while stamp - self._kept[0][0] > self._duration:
            self._kept.popleft()

    @property
    def newest(self) -> tuple[float, Velocity]:
        """When the newest was measured [s], and the newest; zero where there is none."""
        return self._kept[-1] if self._kept else (0.0, STILL)

    def mean(self) -> Velocity:
        """Return their mean; zero where there is none."""
        kept = [velocity for _, velocity in self._kept]
        if len(kept) < 2:
            return kept[0] if kept else STILL
        x, y = math.fsum(v.x for v in kept), math.fsum(v.y for v in kept)
        yaw_rate = math.fsum(v.yaw_rate for v in kept)
        return Velocity(x, y=y, yaw_rate=yaw_rate).scaled(1.0 / len(kept))
