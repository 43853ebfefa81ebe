"""GPS."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

from arjuna_core.geodesy import GeoPoint
from arjuna_sim.devices.device import Mount, StaticDevice, simulates
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.model.settings import SensorSettings, reads


@dataclass(frozen=True, kw_only=True)
class NavSatSettings(SensorSettings):
    """A GPS.

    Attributes:
        noise: Standard deviation of its level position [m].
        height_noise: Of its height [m].
        reference: Where a ROS 1 plugin has the world's origin, and its x axis from east on [rad];
            None for what the world's own file says.
    """

    TITLE: ClassVar[str] = "GPS"
    noise: float = 0.0
    height_noise: float = 0.0
    reference: tuple[GeoPoint, float] | None = None


@reads("gps", "navsat")
def read(tag: SensorTag) -> list[NavSatSettings]:
    """Read a GPS.

    Raises:
        RobotError: A value is invalid.
    """
    level, upright = (
        tag.deviation(*(f"{kind}/position_sensing/{key}/noise" for kind in ("navsat", "gps")))
        for key in ("horizontal", "vertical")
    )
    mount = tag.mount(5.0, "gps/fix")
    level, upright = level or 0.0, upright or 0.0
    return [NavSatSettings(**mount, noise=level, height_noise=upright, reference=_reference(tag))]


def _reference(tag: SensorTag) -> tuple[GeoPoint, float] | None:
    """Return the reference of hector_gazebo_plugins' GPS, whose heading is from north to east."""
    names = [f"reference{each}" for each in ("latitude", "longitude", "altitude", "heading")]
    if not any(tag.text(name) for name in names):
        return None
    text = " ".join(tag.text(name, default="0") for name in names)
    latitude, longitude, altitude, heading = tag.xml.numbers(text, 4, f"{tag.label} <reference>")
    try:
        return GeoPoint(latitude, longitude, altitude), math.radians(90.0 - heading)
    except ValueError as error:
        raise tag.fail(f"its reference is no point on Earth: {error}") from error


class Fix(NamedTuple):
    """A reading of a GPS.

    Attributes:
        variance: Of the position to the east, to the north and upward [m^2].
    """

    position: GeoPoint
    variance: tuple[float, float, float]


@simulates(NavSatSettings)
class NavSat(StaticDevice):
    """Measures the position on Earth."""

    def __init__(self, settings: NavSatSettings, mount: Mount) -> None:
        super().__init__(settings, mount)
        self._earth = mount.earth
        if settings.reference is not None:
            origin, heading = settings.reference
            self._earth = replace(mount.earth, origin=origin, heading=heading)

    def read(self, data: Any, now: float) -> Fix:
        """Return the position with its noise."""
        level, upright = self._settings.noise, self._settings.height_noise
        errors = self._rng.standard_normal(3) * (level, level, upright)
        position = self._earth.geodetic(data.site_xpos[self._site] + errors)
        return Fix(position, (level**2, level**2, upright**2))
