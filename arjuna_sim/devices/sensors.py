"""The robot's lidar and IMU, each at its own rate and with noise of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.pose3 import Pose3
from arjuna_core.scan import Scan
from arjuna_core.timing import Periodic
from arjuna_sim.devices.imu import Imu, ImuConfig, ImuReading
from arjuna_sim.devices.lidar import Lidar, LidarConfig
from arjuna_sim.model.robot import Robot
from arjuna_sim.model.settings import SensorSettings

_TOLERANCE = 1e-9


def mounted(robot: Robot, sensor: SensorSettings) -> Pose3:
    """Return where a sensor sits in the robot's root, all joints at 0."""
    return robot.urdf.T_root(sensor.link) @ sensor.pose


class Sensors:
    """Reads what is due.

    Args:
        robot: Says which sensors there are.
        model: The compiled `mujoco.MjModel`.
        lidar: The lidar's errors.
        imu: The IMU's errors.
        seeds: Two, for the lidar and the IMU.
    """

    def __init__(
        self,
        robot: Robot,
        model: Any,
        lidar: LidarConfig,
        imu: ImuConfig,
        seeds: NDArray[np.uint64],
    ) -> None:
        lidar_rng, imu_rng = (np.random.default_rng(int(seed)) for seed in seeds)
        self._lidar: Lidar | None = None
        self._imu: Imu | None = None
        settings = robot.settings
        if settings.lidar is not None:
            T_base_sensor = mounted(robot, settings.lidar).planar()
            self._lidar = Lidar(model, settings.lidar, T_base_sensor, lidar, lidar_rng)
            period = 1.0 / settings.lidar.rate
            self._lidar_due = Periodic(period, phase=period)
        if settings.imu is not None:
            self._imu = Imu(model, settings.imu, imu, imu_rng)
            self._imu_period = 1.0 / settings.imu.rate
            self._imu_due = Periodic(self._imu_period, phase=self._imu_period)
            self._imu_last: float | None = None

    def rebind(self, model: Any) -> None:
        """Go on with another model, in which the robot is the same."""
        if self._lidar is not None:
            self._lidar.rebind(model)
        if self._imu is not None:
            self._imu.rebind(model)

    def settle(self) -> None:
        """Forget motion, since the robot was lifted to another place."""
        if self._lidar is not None:
            self._lidar.settle()
        if self._imu is not None:
            self._imu.settle()

    def is_imu_faster(self, period: float) -> bool:
        """Tell whether the IMU reads more often than once a period [s]."""
        return self._imu is not None and self._imu_period < period - _TOLERANCE

    def imu(self, data: Any, now: float) -> ImuReading | None:
        """Return the IMU's reading at a time [s], where one is due."""
        if self._imu is None or not self._imu_due.due(now):
            return None
        last, self._imu_last = self._imu_last, now
        is_next = last is not None and now > last  # else time was set back
        dt = _whole_nanoseconds(now - last) if is_next and last is not None else self._imu_period
        return self._imu.read(data, now, dt)

    def scan(self, data: Any, now: float) -> Scan | None:
        """Return the lidar's sweep at a time [s], where one is due; to be called each tick."""
        if self._lidar is None:
            return None
        self._lidar.follow(data, now)
        return self._lidar.scan(data, now) if self._lidar_due.due(now) else None


def _whole_nanoseconds(time: float) -> float:
    """Return a time [s] without rounding's rest; `round` to digits takes three times as long."""
    return round(time * 1e9) / 1e9
