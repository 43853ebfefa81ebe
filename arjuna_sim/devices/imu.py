"""The inertial measurement unit: turn rate, specific force and orientation."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.pose3 import Pose3, quaternion_product
from arjuna_core.se2 import wrap
from arjuna_sim.devices.noise import BiasedNoise
from arjuna_sim.model.settings import ImuSettings


@dataclass(frozen=True)
class ImuConfig:
    """Errors of a low-cost MEMS unit."""

    gyro_noise: float = param(
        0.002, "Standard deviation of a turn rate.", unit="rad/s", minimum=0.0, read_only=True
    )
    gyro_bias_walk: float = param(
        1e-5, "Growth of the gyros' bias.", unit="rad/s/sqrt(s)", minimum=0.0, read_only=True
    )
    accel_noise: float = param(
        0.02, "Standard deviation of an acceleration.", unit="m/s^2", minimum=0.0, read_only=True
    )
    accel_bias_walk: float = param(
        1e-4,
        "Growth of the accelerometers' bias.",
        unit="m/s^2/sqrt(s)",
        minimum=0.0,
        read_only=True,
    )
    tilt_noise: float = param(
        0.002, "Standard deviation of roll and pitch.", unit="rad", minimum=0.0, read_only=True
    )


@dataclass(frozen=True)
class ImuReading:
    """What an IMU says, in its own frame.

    Attributes:
        angular_velocity: `(3,) float64` [rad/s].
        linear_acceleration: Specific force (gravity shows upward), `(3,) float64` [m/s^2].
        orientation: Of the IMU's frame (REP 145), at no place: level against gravity; its heading
            is that of the robot since the start by the gyros' sum, and drifts.
        angular_variance: Of each turn rate [rad^2/s^2].
        linear_variance: Of each acceleration [m^2/s^4].
        tilt_variance: Of roll and pitch [rad^2].
        stamp: When [s].
    """

    angular_velocity: NDArray[np.float64]
    linear_acceleration: NDArray[np.float64]
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

    Acceleration is the mean over the time between readings, as a real unit's filter gives.

    Args:
        model: The compiled `mujoco.MjModel`.
        settings: Where it sits, and the noise that its file names.
        config: Errors, where the file names none.
        rng: Where the noise comes from.
    """

    def __init__(
        self, model: Any, settings: ImuSettings, config: ImuConfig, rng: np.random.Generator
    ) -> None:
        self._name = settings.site
        told = {"gyro_noise": settings.gyro_noise, "accel_noise": settings.accel_noise}
        config = replace(config, **{key: v for key, v in told.items() if v is not None})
        self.rebind(model)
        self._config = config
        self._rng = rng
        self._gyro = BiasedNoise(rng, 3, config.gyro_noise, config.gyro_bias_walk)
        self._accel = BiasedNoise(rng, 3, config.accel_noise, config.accel_bias_walk)
        self._heading = 0.0  # of the robot, as the IMU believes it
        self._true_heading = 0.0  # of the robot when it was read
        self._last: NDArray[np.float64] | None = None

    def rebind(self, model: Any) -> None:
        """Go on with another model, in which the robot is the same."""
        self._model = model
        self._site = model.site(self._name).id
        self._root = int(model.body_rootid[model.site_bodyid[self._site]])

    def settle(self) -> None:
        """Forget the last velocity, since the robot was lifted to another place."""
        self._last = None

    def read(self, data: Any, now: float, dt: float) -> ImuReading:
        """Return a reading.

        Args:
            data: The `mujoco.MjData`, with positions and velocities up to date.
            now: The time [s].
            dt: Time since the last reading [s].
        """
        rotation, motion = data.site_xmat[self._site], self._motion(data)
        heading = _heading(data.xmat[self._root])
        if self._last is None:  # put down here: the gyros have not felt how it came
            self._true_heading = heading
        last = motion if self._last is None else self._last
        self._last = motion
        felt = np.concatenate((self._gyro.sample(dt), self._accel.sample(dt)))
        drift = dt * _feel(rotation, motion, last, dt, self._model.opt.gravity, felt)
        self._heading = wrap(self._heading + wrap(heading - self._true_heading) + drift)
        self._true_heading = heading
        return self._reading(felt, rotation, now)

    def _motion(self, data: Any) -> NDArray[np.float64]:
        """Return the site's turn rate and velocity along the world's axes, `(6,) float64`."""
        result = np.zeros(6)
        kind = mujoco.mjtObj.mjOBJ_SITE
        mujoco.mj_objectVelocity(self._model, data, kind, self._site, result, 0)
        return result

    def _reading(
        self, felt: NDArray[np.float64], rotation: NDArray[np.float64], now: float
    ) -> ImuReading:
        config = self._config
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, rotation)
        w, x, y, z = quaternion.tolist()
        roll, pitch = (config.tilt_noise * self._rng.standard_normal(2)).tolist()
        level = quaternion_product(_about_vertical(-self._true_heading), (w, x, y, z))
        tilt = Pose3.from_rpy((0.0, 0.0, 0.0), (roll, pitch, 0.0)).quaternion
        tilted = quaternion_product(tilt, level)
        return ImuReading(
            felt[:3],
            felt[3:],
            Pose3(quaternion=quaternion_product(_about_vertical(self._heading), tilted)),
            config.gyro_noise**2,
            config.accel_noise**2,
            config.tilt_noise**2,
            now,
        )


def _heading(rotation: NDArray[np.float64]) -> float:
    """Return the heading of a body whose rotation matrix is `(9,) float64` [rad]."""
    return math.atan2(float(rotation[3]), float(rotation[0]))


def _about_vertical(angle: float) -> tuple[float, float, float, float]:
    return math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)


@njit(cache=True)
def _feel(
    rotation: NDArray[np.float64],
    motion: NDArray[np.float64],
    last: NDArray[np.float64],
    dt: float,
    gravity: NDArray[np.float64],
    felt: NDArray[np.float64],
) -> float:
    """Add turn rates and specific force in a frame to errors; return what those turn it.

    Args:
        rotation: Of the frame, row by row, `(9,) float64`.
        motion: Its turn rate and velocity along the world's axes, `(6,) float64`.
        last: The same a time `dt` [s] before.
        dt: [s].
        gravity: `(3,) float64` [m/s^2].
        felt: Errors of each turn rate and acceleration, `(6,) float64`, changed in place.

    Returns:
        The gyros' error about the vertical [rad/s].
    """
    up = 0.0
    for i in range(3):
        up += rotation[6 + i] * felt[i]
        for j in range(3):
            along = (motion[3 + j] - last[3 + j]) / dt - gravity[j]
            felt[i] += rotation[3 * j + i] * motion[j]
            felt[3 + i] += rotation[3 * j + i] * along
    return up
