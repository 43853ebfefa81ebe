"""Altimeters."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from arjuna_sim.devices.device import StaticDevice, simulates
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.model.settings import SensorSettings, reads


@dataclass(frozen=True, kw_only=True)
class AltimeterSettings(SensorSettings):
    """An altimeter: standard deviation of the height above its first reading [m]."""

    TITLE: ClassVar[str] = "altimeter"
    noise: float = 0.0


@reads("altimeter")
def read(tag: SensorTag) -> list[AltimeterSettings]:
    """Read an altimeter."""
    noise = tag.deviation("altimeter/vertical_position/noise")
    return [AltimeterSettings(**tag.mount(20.0, "altimeter"), noise=noise or 0.0)]


@simulates(AltimeterSettings)
class Altimeter(StaticDevice):
    """Measures the height above its first reading."""

    _start = math.nan

    def read(self, data: Any, now: float) -> float:
        """Return the height above the first reading [m]."""
        height = float(data.site_xpos[self._site][2])
        self._start = height if math.isnan(self._start) else self._start
        error = float(self._settings.noise * self._rng.standard_normal())
        return height - self._start + error
