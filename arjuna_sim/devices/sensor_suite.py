"""A robot's first lidar and IMU, which are read when they are due."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.scan import Scan
from arjuna_core.timing import Periodic
from arjuna_sim.devices.device import Device, Mount, device_of
from arjuna_sim.devices.imu import Imu, ImuReading
from arjuna_sim.devices.lidar import Lidar
from arjuna_sim.devices.sensors.imu import ImuSettings
from arjuna_sim.devices.sensors.lidar import LidarSettings
from arjuna_sim.model.settings import GazeboSettings, SensorSettings


class SensorSuite:
    """Reads a robot's first lidar and IMU, each of which draws its noise from a source of its own.

    Args:
        mount: Returns all that a device needs beside its settings and a source of noise.
        seeds: Of the lidar and of the IMU.
    """

    def __init__(
        self,
        settings: GazeboSettings,
        mount: Callable[[SensorSettings, np.random.Generator], Mount],
        seeds: NDArray[np.uint64],
    ) -> None:

        def made(sensor: SensorSettings | None, seed: int) -> Any:
            rng = np.random.default_rng(seed)
            return None if sensor is None else device_of(sensor, mount(sensor, rng))

        lidar, imu = settings.first(LidarSettings), settings.first(ImuSettings)
        self._lidar: Lidar | None = made(lidar, int(seeds[0]))
        self._imu: Imu | None = made(imu, int(seeds[1]))
        if lidar is not None:
            self._lidar_due = Periodic(1.0 / lidar.rate, phase=1.0 / lidar.rate)
        if imu is not None:
            self._imu_period = 1.0 / imu.rate
            self._imu_due = Periodic(self._imu_period, phase=self._imu_period)
            self._imu_last: float | None = None

    @property
    def devices(self) -> list[Device]:
        """Those that are there."""
        return [device for device in (self._lidar, self._imu) if device is not None]

    def is_imu_faster(self, period: float) -> bool:
        """Return whether the first IMU reads more often than once a period [s]."""
        return self._imu is not None and self._imu_period < period - 1e-9

    def imu(self, data: Any, now: float) -> ImuReading | None:
        """Return the first IMU's reading at a time [s], where one is due."""
        if self._imu is None or not self._imu_due.due(now):
            return None
        last, self._imu_last = self._imu_last, now
        is_next = last is not None and now > last  # else time was set back
        dt = _whole_nanoseconds(now - last) if is_next and last is not None else self._imu_period
        return self._imu.measure(data, now, dt)

    def scan(self, data: Any, now: float) -> Scan | None:
        """Return the first lidar's sweep at a time [s], where one is due; call it each tick."""
        if self._lidar is None:
            return None
        self._lidar.follow(data, now)
        return self._lidar.scan(data, now) if self._lidar_due.due(now) else None


def _whole_nanoseconds(time: float) -> float:
    """Return a time [s] without rounding's rest; `round` to digits takes three times as long."""
    return round(time * 1e9) / 1e9
