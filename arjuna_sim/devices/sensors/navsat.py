"""GPS."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from arjuna_core.geodesy import GeoPoint
from arjuna_sim.devices.device import Mount, StaticDevice, simulates
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.model.settings import SensorSettings, reads


@dataclass(frozen=True, kw_only=True)
class NavSatSettings(SensorSettings):
    """A GPS: standard deviations of its position, level and upright [m]."""

    TITLE: ClassVar[str] = "GPS"
    noise: float = 0.0
    height_noise: float = 0.0


@reads("gps", "navsat")
def read(tag: SensorTag) -> list[NavSatSettings]:
    """Read a GPS."""
    level, upright = (
        tag.deviation(*(f"{kind}/position_sensing/{key}/noise" for kind in ("navsat", "gps")))
        for key in ("horizontal", "vertical")
    )
    mount = tag.mount(5.0, "gps/fix")
    return [NavSatSettings(**mount, noise=level or 0.0, height_noise=upright or 0.0)]


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

    def read(self, data: Any, now: float) -> Fix:
        """Return the position with its noise."""
        level, upright = self._settings.noise, self._settings.height_noise
        errors = self._rng.standard_normal(3) * (level, level, upright)
        position = self._earth.geodetic(data.site_xpos[self._site] + errors)
        return Fix(position, (level**2, level**2, upright**2))
