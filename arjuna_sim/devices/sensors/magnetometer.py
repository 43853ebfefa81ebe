"""Magnetometers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_sim.devices.device import Mount, StaticDevice, simulates
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.model.settings import SensorSettings, reads


@dataclass(frozen=True, kw_only=True)
class MagnetometerSettings(SensorSettings):
    """A compass of three axes: standard deviation of the field [T]."""

    TITLE: ClassVar[str] = "magnetometer"
    noise: float = 0.0


@reads("magnetometer")
def read(tag: SensorTag) -> list[MagnetometerSettings]:
    """Read a magnetometer."""
    noise = tag.deviation("magnetometer/x/noise")
    return [MagnetometerSettings(**tag.mount(20.0, "imu/mag"), noise=noise or 0.0)]


@simulates(MagnetometerSettings)
class Magnetometer(StaticDevice):
    """Measures the Earth's magnetic field."""

    def __init__(self, settings: MagnetometerSettings, mount: Mount) -> None:
        super().__init__(settings, mount)
        self._field = np.array(mount.earth.magnetic_field)

    def read(self, data: Any, now: float) -> Floats:
        """Return the field in the sensor's frame, `(3,) float64` [T]."""
        rotation = data.site_xmat[self._site].reshape(3, 3)
        noise = self._settings.noise * self._rng.standard_normal(3)
        field: Floats = rotation.T @ self._field + noise
        return field
