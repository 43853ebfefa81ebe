"""The inertial measurement unit: turn rate, specific force and orientation."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numba import njit

from arjuna_core.arrays import Floats
from arjuna_core.pose3 import Pose3, quaternion_product
from arjuna_core.se2 import wrap
from arjuna_sim.devices.device import Mount, simulates
from arjuna_sim.devices.sensors.imu import ImuConfig, ImuSettings

_SITE = mujoco.mjtObj.mjOBJ_SITE
_wrap = njit(cache=True)(wrap)
_product = njit(cache=True)(quaternion_product)


class ImuReading(NamedTuple):
    """A reading of an IMU, in its own frame.

    Attributes:
        angular_velocity: `(3,) float64` [rad/s].
        linear_acceleration: Specific force (gravity shows upward), `(3,) float64` [m/s^2].
        orientation: Of the IMU's frame (REP 145), level against gravity; its heading
            is that of the robot since the start by the gyros' sum, and drifts.
        angular_variance: Of each turn rate [rad^2/s^2].
        linear_variance: Of each acceleration [m^2/s^4].
        tilt_variance: Of roll and pitch [rad^2].
        stamp: When [s].
    """

    angular_velocity: Floats
    linear_acceleration: Floats
    orientation: Pose3
    angular_variance: float
    linear_variance: float
    tilt_variance: float
    stamp: float

    @property
    def rpy(self) -> tuple[float, float, float]:
        """The orientation as fixed-axis roll, pitch and yaw [rad]."""
        return self.orientation.rpy()


class Imu:
    """Reads the motion of one site.

    Acceleration is the mean over the time between readings, as a real unit's filter gives. Each
    turn rate and acceleration errs by white noise on a bias that walks, or, as in gz-sensors, is a
    Gauss-Markov process.
    """

    def __init__(
        self,
        model: Any,
        settings: ImuSettings,
        config: ImuConfig,
        rng: np.random.Generator,
        tick: float = 0.0,
    ) -> None:
        """`tick` is the least time between two calls of `read` [s]."""
        self._name, self._last_read = settings.site, -np.inf
        self._period = max(1.0 / settings.rate, tick)
        own = {"gyro_noise": settings.gyro_noise, "accel_noise": settings.accel_noise}
        config = replace(config, **{key: v for key, v in own.items() if v is not None})
        self.rebind(model)
        biases = [_biases(rng, *bias) for bias in (settings.gyro_bias, settings.accel_bias)]
        self._draws = _endless(rng)
        sigmas = config.gyro_noise, config.accel_noise
        gyro, accel = settings.gyro_drift, settings.accel_drift
        walks = (
            config.gyro_bias_walk if gyro is None else gyro[0],
            config.accel_bias_walk if accel is None else accel[0],
        )
        rates = tuple(0.0 if drift is None else 1.0 / drift[1] for drift in (gyro, accel))
        self._errors = np.repeat([(0.0, 0.0), walks, sigmas, rates], 3, axis=1)
        self._errors[0] = np.concatenate(biases)
        self._tilt_noise = config.tilt_noise
        self._variances = sigmas[0] ** 2, sigmas[1] ** 2, config.tilt_noise**2
        self._headings = np.zeros(2)
        self._motions = np.empty(6), np.empty(6)  # now, and when it was read last
        self._knows_last, self._level = False, np.empty(4)

    def rebind(self, model: Any) -> None:
        """Continue with another model, in which the robot is the same."""
        self._model = model
        self._site = model.site(self._name).id
        self._root = int(model.body_rootid[model.site_bodyid[self._site]])
        self._gravity = model.opt.gravity.copy()

    def settle(self) -> None:
        """Forget the last velocity, since the robot was lifted to another pose."""
        self._knows_last = False

    def read(self, data: Any, now: float) -> ImuReading:
        """Return a reading at a time [s], of a unit that is read from time to time."""
        passed, period = now - self._last_read, self._period
        self._last_read = now
        # After a gap of 1.5 periods the last velocity is too old to be differentiated.
        if not 0.0 < passed < 1.5 * period:
            self.settle()
            passed = period
        return self.measure(data, now, passed)

    def measure(self, data: Any, now: float, dt: float) -> ImuReading:
        """Return a reading of a `mujoco.MjData` with positions and velocities up to date."""
        rotation, facing = data.site_xmat[self._site], data.xmat[self._root]
        motion, last = self._motions
        mujoco.mj_objectVelocity(self._model, data, _SITE, self._site, motion, 0)
        if not self._knows_last:  # put down here: the gyros have not felt how it came
            self._headings[1] = math.atan2(float(facing[3]), float(facing[0]))
            last[:], self._knows_last = motion, True
        level, felt = self._level, np.empty(6)
        mujoco.mju_mat2Quat(level, rotation)
        turned = _read(
            rotation, level, facing, motion, last, dt, self._gravity,
            next(self._draws), self._errors, self._tilt_noise, self._headings, felt,
        )  # fmt: skip
        self._motions = last, motion
        return ImuReading(felt[:3], felt[3:], Pose3(quaternion=turned), *self._variances, now)


@simulates(ImuSettings)
def _imu(settings: ImuSettings, mount: Mount) -> Imu:
    return Imu(mount.model, settings, mount.config.imu, mount.rng, mount.config.tick)


def _biases(rng: np.random.Generator, mean: float, spread: float) -> Floats:
    """Return the biases of three axes at the start, each of either sign, as Gazebo draws them."""
    if not mean and not spread:
        return np.zeros(3)
    return np.asarray(rng.normal(mean, spread, 3) * rng.choice((-1.0, 1.0), 3), np.float64)


def _endless(rng: np.random.Generator) -> Iterator[Floats]:
    """Yield a reading's standard normal draws, `(14,) float64`, one reading after the other."""
    while True:
        # 14: biases and white noise of six channels, and roll and pitch; 50 readings in one call.
        yield from rng.standard_normal((50, 14))


@njit(cache=True)
def _orientation(
    rotation: Floats,
    facing: Floats,
    headings: Floats,
    drift: float,
    tilt_noise: float,
    draws: Floats,
) -> tuple[float, float, float, float]:
    """Return the quaternion that an IMU believes it has.

    Args:
        rotation: Its true quaternion, `(4,) float64`.
        facing: Rotation of the robot, row by row, `(9,) float64`.
        headings: Of the robot, as the IMU believes it and in truth, both when it was read last,
            `(2,) float64` [rad], changed in place.
        drift: Of the gyros since [rad].
        tilt_noise: Of roll and pitch [rad].
        draws: Standard normal, the last two for roll and pitch.
    """
    heading = math.atan2(facing[3], facing[0])
    headings[0] = _wrap(headings[0] + _wrap(heading - headings[1]) + drift)
    headings[1] = heading
    roll, pitch = tilt_noise * draws[-2] / 2, tilt_noise * draws[-1] / 2
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    back = math.cos(-heading / 2), 0.0, 0.0, math.sin(-heading / 2)
    level = _product(back, (rotation[0], rotation[1], rotation[2], rotation[3]))
    tilted = _product((cr * cp, sr * cp, cr * sp, -sr * sp), level)
    return _product((math.cos(headings[0] / 2), 0.0, 0.0, math.sin(headings[0] / 2)), tilted)


@njit(cache=True)
def _read(
    rotation: Floats,
    level: Floats,
    facing: Floats,
    motion: Floats,
    last: Floats,
    dt: float,
    gravity: Floats,
    draws: Floats,
    errors: Floats,
    tilt_noise: float,
    headings: Floats,
    felt: Floats,
) -> tuple[float, float, float, float]:
    """Fill in turn rates and specific force in a frame; return its quaternion, as `_orientation`.

    `bench sim`: 15 us a reading in NumPy, 4 us so.

    Args:
        rotation: Of the frame, row by row, `(9,) float64`.
        motion: Its turn rate and velocity along the world's axes, `(6,) float64`.
        last: The same a time `dt` [s] before.
        gravity: `(3,) float64` [m/s^2].
        draws: Standard normal: for the gyros' biases, the gyros, the other biases and the rest.
        errors: Biases, how they grow per root second, white noise and the part of them that is
            forgotten per second, `(4, 6) float64`; the biases are changed in place.
        felt: What each turn rate and acceleration is read as, `(6,) float64`.
    """
    up, root = 0.0, math.sqrt(dt)
    for i in range(6):
        first = 3 * (i // 3) + i
        errors[0, i] *= max(0.0, 1.0 - dt * errors[3, i])
        errors[0, i] += errors[1, i] * root * draws[first]
        felt[i] = errors[0, i] + errors[2, i] * draws[first + 3]
    for i in range(3):
        up += rotation[6 + i] * felt[i]
        for j in range(3):
            along = (motion[3 + j] - last[3 + j]) / dt - gravity[j]
            felt[i] += rotation[3 * j + i] * motion[j]
            felt[3 + i] += rotation[3 * j + i] * along
    return _orientation(level, facing, headings, dt * up, tilt_noise, draws)
