"""The inertial measurement unit: turn rate, specific force and orientation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import wrap
from arjuna_sim.devices.noise import BiasedNoise


@dataclass(frozen=True)
class ImuConfig:
    """Errors of a low-cost MEMS unit."""

    gyro_noise: float = param(
        0.002, "Standard deviation of a turn rate.", unit="rad/s", minimum=0.0
    )
    gyro_bias_walk: float = param(
        1e-5, "Growth of the gyros' bias.", unit="rad/s/sqrt(s)", minimum=0.0
    )
    accel_noise: float = param(
        0.02, "Standard deviation of an acceleration.", unit="m/s^2", minimum=0.0
    )
    accel_bias_walk: float = param(
        1e-4, "Growth of the accelerometers' bias.", unit="m/s^2/sqrt(s)", minimum=0.0
    )
    tilt_noise: float = param(0.002, "Standard deviation of roll and pitch.", unit="rad", minimum=0)


@dataclass(frozen=True)
class ImuReading:
    """What an IMU says, in its own frame.

    Attributes:
        angular_velocity: `(3,) float64` [rad/s].
        linear_acceleration: Specific force (gravity shows upward), `(3,) float64` [m/s^2].
        rpy: Roll and pitch against gravity; yaw is the gyro's sum since the start, and drifts
            [rad].
        angular_variance: Of each turn rate [rad^2/s^2].
        linear_variance: Of each acceleration [m^2/s^4].
        tilt_variance: Of roll and pitch [rad^2].
        stamp: When [s].
    """

    angular_velocity: NDArray[np.float64]
    linear_acceleration: NDArray[np.float64]
    rpy: tuple[float, float, float]
    angular_variance: float
    linear_variance: float
    tilt_variance: float
    stamp: float


class Imu:
    """Reads the motion of one site.

    Acceleration is the mean over the time between readings, as a real unit's filter gives.

    Args:
        model: The compiled `mujoco.MjModel`.
        link: The IMU's link.
        config: Errors.
        rng: Where the noise comes from.
    """

    def __init__(self, model: Any, link: str, config: ImuConfig, rng: np.random.Generator) -> None:
        self._model = model
        self._link = link
        self._site = model.site(link).id
        self._config = config
        self._rng = rng
        self._gyro = BiasedNoise(rng, 3, config.gyro_noise, config.gyro_bias_walk)
        self._accel = BiasedNoise(rng, 3, config.accel_noise, config.accel_bias_walk)
        self._yaw = 0.0
        self._last: NDArray[np.float64] | None = None

    def rebind(self, model: Any) -> None:
        """Go on with another model, in which the robot is the same."""
        self._model = model
        self._site = model.site(self._link).id

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
        rotation = data.site_xmat[self._site].reshape(3, 3)
        velocity, spin = self._motion(data)
        last = velocity if self._last is None else self._last
        self._last = velocity
        force = rotation.T @ ((velocity - last) / dt - self._model.opt.gravity)
        rates = rotation.T @ spin + self._gyro.sample(dt)
        self._yaw = wrap(self._yaw + float(rates[2]) * dt)
        return self._reading(rates, force + self._accel.sample(dt), rotation, now)

    def _motion(self, data: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the site's velocity and turn rate along the world's axes."""
        result = np.zeros(6)
        kind = mujoco.mjtObj.mjOBJ_SITE
        mujoco.mj_objectVelocity(self._model, data, kind, self._site, result, 0)
        return result[3:], result[:3]

    def _reading(
        self,
        rates: NDArray[np.float64],
        force: NDArray[np.float64],
        rotation: NDArray[np.float64],
        now: float,
    ) -> ImuReading:
        config = self._config
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, rotation.reshape(-1))
        w, x, y, z = (float(value) for value in quaternion)
        roll, pitch, _ = Pose3(quaternion=(w, x, y, z)).rpy()
        errors = config.tilt_noise * self._rng.standard_normal(2)
        rpy = (roll + float(errors[0]), pitch + float(errors[1]), self._yaw)
        return ImuReading(
            rates,
            force,
            rpy,
            config.gyro_noise**2,
            config.accel_noise**2,
            config.tilt_noise**2,
            now,
        )
