"""Altimeters."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import mujoco
import numpy as np

from arjuna_sim.devices.device import StaticDevice, simulates
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.model.settings import SensorSettings, reads


@dataclass(frozen=True, kw_only=True)
class AltimeterSettings(SensorSettings):
    """An altimeter: standard deviations of height above its first reading [m] and speed [m/s]."""

    TITLE: ClassVar[str] = "altimeter"
    noise: float = 0.0
    speed_noise: float = 0.0


@reads("altimeter")
def read(tag: SensorTag) -> list[AltimeterSettings]:
    """Read an altimeter."""
    noise, speed_noise = (
        tag.deviation(f"altimeter/vertical_{of}/noise") or 0.0 for of in ("position", "velocity")
    )
    mount = tag.mount(20.0, "altimeter")
    return [AltimeterSettings(**mount, noise=noise, speed_noise=speed_noise)]


class Climb(NamedTuple):
    """A reading: height above the first one [m], speed upward [m/s], and the first height [m]."""

    height: float
    speed: float
    start: float


@simulates(AltimeterSettings)
class Altimeter(StaticDevice):
    """Measures the height above its first reading, and how it climbs."""

    _start = math.nan

    def read(self, data: Any, now: float) -> Climb:
        """Return height and speed."""
        height, velocity = float(data.site_xpos[self._site][2]), np.zeros(6)
        self._start = height if math.isnan(self._start) else self._start
        site = mujoco.mjtObj.mjOBJ_SITE
        mujoco.mj_objectVelocity(self._model, data, site, self._site, velocity, 0)
        error, speed_error = self._rng.standard_normal(2).tolist()
        return Climb(
            height - self._start + self._settings.noise * error,
            float(velocity[5]) + self._settings.speed_noise * speed_error,
            self._start,
        )
