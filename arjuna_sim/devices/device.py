"""Devices: what simulates a sensor, made by the settings of its kind."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import SensorSettings, sensor_kinds
from arjuna_sim.model.world import Earth


class Mount(NamedTuple):
    """All that a device may need beside its settings.

    Attributes:
        T_base_sensor: The sensor's pose in the robot's root, all joints at 0.
        earth: Position of the world on Earth, and its magnetic field.
        config: The `SimulatorConfig`, with the parameters of kinds that have some.
        rng: Source of the noise.
    """

    model: Any
    T_base_sensor: Pose3
    earth: Earth
    config: Any
    rng: np.random.Generator


class Device(Protocol):
    """Simulates one sensor."""

    def rebind(self, model: Any) -> None:
        """Continue with another model, in which the robot is the same."""

    def read(self, data: Any, now: float) -> Any:
        """Return a reading of a `mujoco.MjData` at a time [s], its positions up to date."""

    def settle(self) -> None:
        """Forget motion, since the robot was lifted to another pose."""


D = TypeVar("D", bound=Callable[[Any, Mount], Device])
_devices: dict[type[SensorSettings], Callable[[Any, Mount], Device]] = {}


def simulates(kind: type[SensorSettings]) -> Callable[[D], D]:
    """Register what makes the device of a kind of settings."""

    def registered(make: D) -> D:
        _devices[kind] = make
        return make

    return registered


def device_of(settings: SensorSettings, mount: Mount) -> Device:
    """Make the device of a sensor."""
    sensor_kinds()  # imports the kinds
    return _devices[type(settings)](settings, mount)


class StaticDevice:
    """A device that remembers no motion and sits at the site of its settings."""

    def __init__(self, settings: Any, mount: Mount) -> None:
        self._settings, self._rng = settings, mount.rng
        self.rebind(mount.model)

    def rebind(self, model: Any) -> None:
        """Continue with another model, in which the robot is the same."""
        self._model, self._site = model, int(model.site(self._settings.site).id)

    def settle(self) -> None:
        """Do nothing: no motion is remembered."""


def mounted(robot: RobotModel, sensor: SensorSettings) -> Pose3:
    """Return a sensor's pose in the robot's root, all joints at 0."""
    return robot.urdf.T_root(sensor.link) @ sensor.pose
