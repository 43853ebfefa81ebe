"""The drives of a batch's robots: limits, ramps and wheel speeds, and motion by the encoders."""

from __future__ import annotations

import numpy as np

from arjuna_core.arrays import Bools, Floats
from arjuna_core.twist import Velocity
from arjuna_sim.devices.drive import Base
from arjuna_sim.devices.driving.controller import CommandError, Limits


class BatchDrive:
    """`Drive`, `WheelSpeeds` and `Odometry` of many robots of one kind.

    A command holds for its tick: there is one each tick.

    Args:
        base: One whose wheels' speeds are linear in its velocity.
        limits: Of commands; jerk is not limited.
        most: The greatest speed of each wheel's joint, infinity for none, `(W,)` [rad/s].
        tick: [s].
        tick_angle: Of the encoders [rad].
    """

    def __init__(
        self, base: Base, limits: Limits, most: Floats, tick: float, tick_angle: float, count: int
    ) -> None:
        self._base, self._most, self._tick, self._tick_angle = base, most, tick, tick_angle
        forward, turn = limits.forward.value, limits.turn.value
        self._low = np.array([-limits.reverse.value, -forward, -turn])
        self._high = np.array([forward, forward, turn])
        ramps = limits.linear, limits.linear, limits.angular
        self._step = tick * np.array([[-ramp.down, ramp.up] for ramp in ramps]).T
        units = [Velocity(1.0), Velocity(y=1.0), Velocity(yaw_rate=1.0)]
        self._turning = np.array([base.speeds(base.reachable(unit)) for unit in units])
        encoders = len(base.encoders(np.zeros(len(most))))
        moved = [base.motion(turn, np.zeros(0)) for turn in np.eye(encoders)]
        self._moving = np.array(moved)
        self._current = np.zeros((count, 3))
        self._counted = np.zeros((count, encoders))

    def restart(self, which: Bools) -> None:
        """Let some stand still, with their wheels at angle 0."""
        self._current[which] = 0.0
        self._counted[which] = 0.0

    def speeds(self, commands: Floats) -> Floats:
        """Return the wheels' rates for commands `(N, 3)` [m/s, m/s, rad/s], `(N, W)` [rad/s].

        Raises:
            CommandError: One is not finite.
        """
        if not np.isfinite(commands).all():
            wrong = np.flatnonzero(~np.isfinite(commands).all(axis=1)).tolist()
            raise CommandError(f"commands of robots {wrong} must be finite")
        wanted = np.clip(commands, self._low, self._high)
        self._current += np.clip(wanted - self._current, *self._step)
        speeds: Floats = self._current @ self._turning
        over = (np.abs(speeds) / self._most).max(axis=1)
        return np.asarray(speeds / np.maximum(over, 1.0)[:, None])

    def velocities(self, angles: Floats) -> Floats:
        """Return velocities `(N, 3)` [m/s, m/s, rad/s] by joint angles `(N, W)` at a tick's end."""
        counted = np.rint(self._base.encoders(angles) / self._tick_angle)
        turns = (counted - self._counted) * self._tick_angle
        self._counted = counted
        velocities: Floats = turns @ self._moving / self._tick
        return velocities
