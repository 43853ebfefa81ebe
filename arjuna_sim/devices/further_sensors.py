"""The sensors that a robot has beside its first lidar, camera and IMU, each with its own noise."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.scan import Scan
from arjuna_sim.devices.imu import Imu, ImuConfig, ImuReading
from arjuna_sim.devices.lidar import Lidar, LidarConfig
from arjuna_sim.devices.place_sensors import Altimeter, Bumper, Fix, Magnetometer, NavSat
from arjuna_sim.devices.rays.beams import Beams, Cloud
from arjuna_sim.devices.sensors import mounted
from arjuna_sim.model.robot import Robot
from arjuna_sim.model.settings import (
    AltimeterSettings,
    BumperSettings,
    CloudSettings,
    ImuSettings,
    LidarSettings,
    MagnetometerSettings,
    NavSatSettings,
    RangeSettings,
    SensorSettings,
)
from arjuna_sim.model.world import Earth

_GAP = 1.5  # periods after which an IMU has forgotten how fast it was

Reading = Scan | Cloud | ImuReading | Fix | NDArray[np.float64] | float | bool
"""What sensors say: a float is a range or a height, an array a magnetic field, a bool a bump."""


class FurtherSensors:
    """Reads sensors when it is asked to; what nobody asks for costs nothing.

    Args:
        robot: Says which sensors there are.
        earth: Where the world is.
        lidar: The lidars' errors.
        imu: The IMUs' errors, where the file names none.
        seed: Of all noise; each sensor draws from its own.
    """

    def __init__(
        self, robot: Robot, earth: Earth, lidar: LidarConfig, imu: ImuConfig, seed: int
    ) -> None:
        self._robot, self._earth = robot, earth
        self._lidar, self._imu = lidar, imu
        self._seed = seed
        self._devices: dict[str, Any] = {}
        self._last: dict[str, float] = {}
        self._model: Any = None

    def settle(self) -> None:
        """Forget motion, since the robot was lifted to another place."""
        for device in self._devices.values():
            if isinstance(device, Imu | Lidar):
                device.settle()

    def read(self, sensor: SensorSettings, model: Any, data: Any, now: float) -> Reading:
        """Return a reading.

        Args:
            sensor: One of the robot's further sensors, no camera.
            model: The `mujoco.MjModel`.
            data: The `mujoco.MjData`, with positions and velocities up to date.
            now: The time [s].
        """
        device = self._device(sensor, model)
        if isinstance(device, Lidar):
            device.follow(data, now)
            return device.scan(data, now)
        if isinstance(device, Beams):
            return device.nearest(data) if type(sensor) is RangeSettings else device.cloud(data)
        if isinstance(device, Imu):
            return self._inertial(sensor, device, data, now)
        if isinstance(device, Bumper):
            return device.pressed(data)
        reading: Reading = device.read(data)
        return reading

    def _inertial(self, sensor: SensorSettings, imu: Imu, data: Any, now: float) -> ImuReading:
        passed = now - self._last.get(sensor.name, -np.inf)
        self._last[sensor.name] = now
        if not 0.0 < passed < _GAP / sensor.rate:
            imu.settle()
            passed = 1.0 / sensor.rate
        return imu.read(data, now, passed)

    def _device(self, sensor: SensorSettings, model: Any) -> Any:
        if model is not self._model:
            for device in self._devices.values():
                device.rebind(model)
            self._model = model
        if sensor.name not in self._devices:
            self._devices[sensor.name] = self._made(sensor, model)
        return self._devices[sensor.name]

    def _made(self, sensor: SensorSettings, model: Any) -> Any:
        rng = np.random.default_rng([self._seed, zlib.crc32(sensor.name.encode())])
        if isinstance(sensor, CloudSettings):
            return Beams(model, sensor, rng)
        if isinstance(sensor, LidarSettings):
            T_base_sensor = mounted(self._robot, sensor).planar()
            return Lidar(model, sensor, T_base_sensor, self._lidar, rng)
        if isinstance(sensor, ImuSettings):
            return Imu(model, sensor, self._imu, rng)
        if isinstance(sensor, NavSatSettings):
            return NavSat(model, sensor, self._earth, rng)
        if isinstance(sensor, MagnetometerSettings):
            return Magnetometer(model, sensor, self._earth, rng)
        if isinstance(sensor, AltimeterSettings):
            return Altimeter(model, sensor, rng)
        assert isinstance(sensor, BumperSettings)
        return Bumper(model, sensor)
