"""A robot's sensors: its first lidar and IMU read when due, the others when asked."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.scan import Scan
from arjuna_core.timing import Periodic
from arjuna_sim.devices.device import Device, Mount, device_of, mounted
from arjuna_sim.devices.imu import Imu, ImuReading
from arjuna_sim.devices.lidar import Lidar
from arjuna_sim.devices.sensors.imu import ImuSettings
from arjuna_sim.devices.sensors.lidar import LidarSettings
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import SensorSettings
from arjuna_sim.model.world import Earth


class SensorSuite:
    """Reads the sensors of a robot; each draws its noise from a source of its own.

    Args:
        seeds: Of the first lidar, of the first IMU, and of all others.
    """

    def __init__(
        self,
        robot: RobotModel,
        model: Any,
        earth: Earth,
        config: Any,
        seeds: NDArray[np.uint64],
    ) -> None:
        self._robot, self._model, self._earth, self._config = robot, model, earth, config
        lidar_seed, imu_seed, self._seed = (int(seed) for seed in seeds)
        self._lidar: Lidar | None = None
        self._imu: Imu | None = None
        lidar, imu = robot.settings.first(LidarSettings), robot.settings.first(ImuSettings)
        if lidar is not None:
            device: Any = device_of(lidar, self._mount(lidar, np.random.default_rng(lidar_seed)))
            self._lidar, period = device, 1.0 / lidar.rate
            self._lidar_due = Periodic(period, phase=period)
        if imu is not None:
            device = device_of(imu, self._mount(imu, np.random.default_rng(imu_seed)))
            self._imu, self._imu_period = device, 1.0 / imu.rate
            self._imu_due = Periodic(self._imu_period, phase=self._imu_period)
            self._imu_last: float | None = None
        self._further: dict[str, Device] = {}

    def _mount(self, sensor: SensorSettings, rng: np.random.Generator) -> Mount:
        T_base_sensor = mounted(self._robot, sensor)
        return Mount(self._model, T_base_sensor, self._earth, self._config, rng)

    def _devices(self) -> list[Device]:
        first: list[Device | None] = [self._lidar, self._imu]
        return [device for device in (*first, *self._further.values()) if device is not None]

    def rebind(self, model: Any) -> None:
        """Continue with another model, in which the robot is the same."""
        self._model = model
        for device in self._devices():
            device.rebind(model)

    def settle(self) -> None:
        """Forget motion, since the robot was lifted to another pose."""
        for device in self._devices():
            device.settle()

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

    def read(self, sensor: SensorSettings, data: Any, now: float) -> Any:
        """Return a reading of a further sensor; one that nobody asks for costs nothing."""
        return self.device(sensor).read(data, now)

    def device(self, sensor: SensorSettings) -> Device:
        """Return a further sensor's device, made where it was not asked for yet."""
        if sensor.name not in self._further:
            rng = np.random.default_rng([self._seed, zlib.crc32(sensor.name.encode())])
            self._further[sensor.name] = device_of(sensor, self._mount(sensor, rng))
        return self._further[sensor.name]


def _whole_nanoseconds(time: float) -> float:
    """Return a time [s] without rounding's rest; `round` to digits takes three times as long."""
    return round(time * 1e9) / 1e9
