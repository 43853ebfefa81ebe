"""Sensors of a stage that are read when asked for."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.camera import Camera, Shot
from arjuna_sim.devices.device import Device, Mount, device_of
from arjuna_sim.devices.sensors.camera import CameraSettings
from arjuna_sim.model.settings import S, SensorSettings
from arjuna_sim.physics.stage import Stage


class StagedSensors:
    """Reads the sensors of a world's models; each draws its noise from a source of its own.

    Attributes:
        seed: Of all noise.
    """

    def __init__(self, stage: Stage, config: SimulatorConfig, seed: int) -> None:
        self._stage, self._config, self.seed = stage, config, seed
        self._devices: dict[str, Device] = {}
        self._cameras: dict[str, Camera] = {}

    @property
    def settings(self) -> tuple[SensorSettings, ...]:
        """The sensors, as the stage knows them."""
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

    def staged(self, sensor: S) -> S:
        """Return a sensor as the stage knows it."""
        return sensor

    def _mounted(self, sensor: SensorSettings) -> Pose3:
        """Return the pose of a sensor of the stage in its robot's root."""
        return ORIGIN

    def _mount(self, sensor: SensorSettings, rng: np.random.Generator) -> Mount:
        model, earth = self._stage.scene.model, self._stage.world.earth
        return Mount(model, self._mounted(sensor), earth, self._config, rng)

    def device(self, sensor: SensorSettings) -> Any:
        """Return what simulates a sensor, made where it was not asked for yet."""
        sensor = self.staged(sensor)
        if sensor.name not in self._devices:
            rng = np.random.default_rng([self.seed, zlib.crc32(sensor.name.encode())])
            self._devices[sensor.name] = device_of(sensor, self._mount(sensor, rng))
        return self._devices[sensor.name]

    def sense(self, sensor: SensorSettings, now: float) -> Any:
        """Return a reading of a sensor at a time [s]; one that nobody asks for costs nothing."""
        return self.device(sensor).read(self._stage.data, now)

    def picture(self, camera: CameraSettings, color: bool = True, depth: bool = False) -> Shot:
        """Return what a camera sees now: colours, distances or both.

        Raises:
            CameraError: This machine cannot draw.
        """
        if camera.name not in self._cameras:
            self._cameras[camera.name] = Camera(self.staged(camera), self.seed)
        stage, found = self._stage, self._cameras[camera.name]
        return found.shoot(stage.scene.model, stage.data, color, depth)

    def close(self) -> None:
        """Free what the cameras hold."""
        while self._cameras:
            self._cameras.popitem()[1].close()
