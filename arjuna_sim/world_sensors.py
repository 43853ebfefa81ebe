"""The sensors of a world's models, which belong to no robot."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np

from arjuna_core.pose3 import ORIGIN
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.camera import Camera, Shot
from arjuna_sim.devices.device import Device, Mount, device_of
from arjuna_sim.devices.sensors.camera import CameraSettings
from arjuna_sim.model.settings import SensorSettings
from arjuna_sim.physics.stage import Stage


class WorldSensors:
    """Reads the sensors of a stage's world.

    Attributes:
        camera_seed: The seed of all noise.
    """

    def __init__(self, stage: Stage, config: SimulatorConfig, seed: int) -> None:
        self._stage, self._config, self.camera_seed = stage, config, seed
        self._devices: dict[str, Device] = {}
        self._cameras: dict[str, Camera] = {}

    @property
    def settings(self) -> tuple[SensorSettings, ...]:
        """The sensors of the world that is there."""
        return tuple(fixture.settings for fixture in self._stage.world.sensors)

    def begin(self) -> None:
        """Make new devices, their noise rewound."""
        self._devices.clear()
        self.close()

    def rebind(self) -> None:
        """Continue with the stage's new MuJoCo model, perhaps of another world."""
        names = {settings.name for settings in self.settings}
        self._devices = {name: each for name, each in self._devices.items() if name in names}
        for device in self._devices.values():
            device.rebind(self._stage.scene.model)

    def staged(self, sensor: SensorSettings) -> SensorSettings:
        """Return a sensor as the stage knows it: itself."""
        return sensor

    def sense(self, sensor: SensorSettings, now: float) -> Any:
        """Return a reading of a sensor at a time [s]."""
        stage = self._stage
        if sensor.name not in self._devices:
            rng = np.random.default_rng([self.camera_seed, zlib.crc32(sensor.name.encode())])
            mount = Mount(stage.scene.model, ORIGIN, stage.world.earth, self._config, rng)
            self._devices[sensor.name] = device_of(sensor, mount)
        return self._devices[sensor.name].read(stage.data, now)

    def picture(
        self, color: bool = True, depth: bool = False, camera: CameraSettings | None = None
    ) -> Shot:
        """Return what a camera sees now.

        Raises:
            CameraError: This machine cannot draw.
        """
        assert camera is not None
        if camera.name not in self._cameras:
            self._cameras[camera.name] = Camera(camera, self.camera_seed)
        found = self._cameras[camera.name]
        return found.shoot(self._stage.scene.model, self._stage.data, color, depth)

    def close(self) -> None:
        """Free what the cameras hold."""
        while self._cameras:
            self._cameras.popitem()[1].close()
