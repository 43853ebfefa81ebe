"""Sensors of place and field: GPS, magnetometer, altimeter; and bumpers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from arjuna_core.geodesy import GeoPoint
from arjuna_sim.model.settings import (
    AltimeterSettings,
    BumperSettings,
    MagnetometerSettings,
    NavSatSettings,
)
from arjuna_sim.model.world import Earth


@dataclass(frozen=True)
class Fix:
    """What a GPS says.

    Attributes:
        place: Where it is on Earth.
        variance: Of its position to the east, to the north and upward [m^2].
    """

    place: GeoPoint
    variance: tuple[float, float, float]


class NavSat:
    """A GPS.

    Args:
        model: The compiled `mujoco.MjModel`.
        settings: Where it sits, and its noise.
        earth: Where the world is.
        rng: Where the noise comes from.
    """

    def __init__(
        self, model: Any, settings: NavSatSettings, earth: Earth, rng: np.random.Generator
    ) -> None:
        self._settings, self._earth, self._rng = settings, earth, rng
        self.rebind(model)

    def rebind(self, model: Any) -> None:
        """Go on with another model, in which the robot is the same."""
        self._site = model.site(self._settings.site).id

    def read(self, data: Any) -> Fix:
        """Return where it is, with positions of `data` up to date."""
        level, upright = self._settings.noise, self._settings.height_noise
        errors = self._rng.standard_normal(3) * (level, level, upright)
        place = self._earth.geodetic(data.site_xpos[self._site] + errors)
        return Fix(place, (level**2, level**2, upright**2))


class Magnetometer:
    """A compass of three axes.

    Args:
        model: The compiled `mujoco.MjModel`.
        settings: Where it sits, and its noise.
        earth: Which field there is.
        rng: Where the noise comes from.
    """

    def __init__(
        self, model: Any, settings: MagnetometerSettings, earth: Earth, rng: np.random.Generator
    ) -> None:
        self._settings, self._rng = settings, rng
        self._field = np.array(earth.magnetic_field)
        self.rebind(model)

    def rebind(self, model: Any) -> None:
        """Go on with another model, in which the robot is the same."""
        self._site = model.site(self._settings.site).id

    def read(self, data: Any) -> NDArray[np.float64]:
        """Return the field in its own frame, `(3,) float64` [T]."""
        rotation = data.site_xmat[self._site].reshape(3, 3)
        noise = self._settings.noise * self._rng.standard_normal(3)
        field: NDArray[np.float64] = rotation.T @ self._field + noise
        return field


class Altimeter:
    """An altimeter, which tells the height above its first reading.

    Args:
        model: The compiled `mujoco.MjModel`.
        settings: Where it sits, and its noise.
        rng: Where the noise comes from.
    """

    def __init__(self, model: Any, settings: AltimeterSettings, rng: np.random.Generator) -> None:
        self._settings, self._rng = settings, rng
        self._start = math.nan
        self.rebind(model)

    def rebind(self, model: Any) -> None:
        """Go on with another model, in which the robot is the same."""
        self._site = model.site(self._settings.site).id

    def read(self, data: Any) -> float:
        """Return the height above the first reading [m]."""
        height = float(data.site_xpos[self._site][2])
        self._start = height if math.isnan(self._start) else self._start
        return height - self._start + self._settings.noise * float(self._rng.standard_normal())


class Bumper:
    """A bumper: what the shapes of a link touch.

    Args:
        model: The compiled `mujoco.MjModel`.
        settings: Which link.
    """

    def __init__(self, model: Any, settings: BumperSettings) -> None:
        self._link = settings.link
        self.rebind(model)

    def rebind(self, model: Any) -> None:
        """Go on with another model, in which the robot is the same."""
        body = int(model.site_bodyid[model.site(self._link).id])
        first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
        kind, start = mujoco.mjtObj.mjOBJ_GEOM, f"{self._link}//"
        self._own = np.zeros(model.ngeom, np.bool_)
        for geom in range(first, first + count):
            name = mujoco.mj_id2name(model, kind, geom) or ""
            self._own[geom] = name.startswith(start)

    def pressed(self, data: Any) -> bool:
        """Tell whether one of the shapes touches anything."""
        return bool(self._own[data.contact.geom].any()) if data.ncon else False
