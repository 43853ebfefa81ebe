"""The drives of a batch's robots: limits, ramps and wheel speeds, and motion by the encoders."""

from __future__ import annotations

import numpy as np
import warp as wp
from numpy.typing import NDArray

from arjuna_core.twist import Velocity
from arjuna_sim.devices.drive import Base
from arjuna_sim.devices.driving.controller import CommandError, Limits
from arjuna_sim.physics.scene import GRAZED, LEVEL, SUNK

wp.config.log_level = wp.LOG_WARNING  # else a line for each of a hundred kernels


@wp.kernel(enable_backward=False)
def aim_beams(
    site: int,
    beams: wp.array[wp.vec3],
    positions: wp.array2d[wp.vec3],
    rotations: wp.array2d[wp.mat33],
    starts: wp.array2d[wp.vec3],
    directions: wp.array2d[wp.vec3],
) -> None:
    """Put each robot's beams where its lidar is."""
    robot, beam = wp.tid()
    starts[robot, beam] = positions[robot, site]
    directions[robot, beam] = rotations[robot, site] @ beams[beam]


@wp.kernel(enable_backward=False)
def measure(
    distances: wp.array2d[float],
    seeds: wp.array[int],
    scan: int,
    noise: float,
    dropout: float,
    nearest: float,
    furthest: float,
    ranges: wp.array2d[float],
) -> None:
    """Turn distances, below 0 for none, into ranges by REP 117, with noise and dropouts.

    The noise of a beam depends on its robot's seed and on the number of the scan alone.
    """
    robot, beam = wp.tid()
    state = wp.rand_init(seeds[robot], scan * distances.shape[1] + beam)
    distance = distances[robot, beam]
    if distance < 0.0:
        distance = wp.inf
    distance += noise * wp.randn(state)
    if distance < nearest:
        distance = -wp.inf
    elif distance > furthest:
        distance = wp.inf
    if wp.randf(state) < dropout:
        distance = wp.inf
    ranges[robot, beam] = distance


@wp.kernel(enable_backward=False)
def find_touched(
    count: wp.array[int],
    pairs: wp.array[wp.vec2i],
    robots: wp.array[int],
    frames: wp.array[wp.mat33],
    distances: wp.array[float],
    is_solid: wp.array[int],
    is_obstacle: wp.array[int],
    touched: wp.array[int],
) -> None:
    """Mark the robots that touch what they do not stand on, as `scene.touched` names it."""
    k = wp.tid()
    if k >= count[0]:
        return
    a, b = pairs[k][0], pairs[k][1]
    meets = is_solid[a] * is_obstacle[b] + is_solid[b] * is_obstacle[a]
    distance = distances[k]
    stands = wp.abs(frames[k][0, 2]) > wp.static(LEVEL) and distance > -wp.static(SUNK)
    if meets > 0 and not stands and distance <= -wp.static(GRAZED):
        touched[robots[k]] = 1


Floats = NDArray[np.float64]


class BatchDrive:
    """`Drive`, `WheelSpeeds` and `Odometry` of many robots of one kind.

    A command holds for its tick: there is one each tick.

    Args:
        base: One whose wheels' speeds are linear in its velocity.
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
        linear, angular = limits.linear_acceleration, limits.angular_acceleration
        self._step = tick * np.array([linear, linear, angular])
        units = [Velocity(1.0), Velocity(y=1.0), Velocity(yaw_rate=1.0)]
        self._turning = np.array([base.speeds(base.reachable(unit)) for unit in units])
        encoders = len(base.encoders(np.zeros(len(most))))
        moved = [base.motion(turn, np.zeros(0)) for turn in np.eye(encoders)]
        self._moving = np.array(moved)
        self._current = np.zeros((count, 3))
        self._counted = np.zeros((count, encoders))

    def restart(self, which: NDArray[np.bool_]) -> None:
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
        self._current += np.clip(wanted - self._current, -self._step, self._step)
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
