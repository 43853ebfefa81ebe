"""Points on the earth: WGS84 coordinates, the local tangent plane, and where a map lies on it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2

SEMI_MAJOR = 6378137.0
FLATTENING = 1.0 / 298.257223563
_ECCENTRICITY_2 = FLATTENING * (2.0 - FLATTENING)


@dataclass(frozen=True)
class GeoPoint:
    """A point on the earth, in WGS84.

    Attributes:
        latitude_deg: North of the equator [degree].
        longitude_deg: East of Greenwich [degree].
        altitude: Above the ellipsoid [m].

    Raises:
        ValueError: A coordinate is not finite or out of range.
    """

    latitude_deg: float
    longitude_deg: float
    altitude: float = 0.0

    def __post_init__(self) -> None:
        for name, value, limit in (
            ("latitude", self.latitude_deg, 90.0),
            ("longitude", self.longitude_deg, 180.0),
            ("altitude", self.altitude, math.inf),
        ):
            if not math.isfinite(value) or abs(value) > limit:
                raise ValueError(f"{name} {value:g} is no place on the earth")

    def ecef(self) -> NDArray[np.float64]:
        """Return earth-centred, earth-fixed coordinates `(3,) float64` [m]."""
        lat, lon = math.radians(self.latitude_deg), math.radians(self.longitude_deg)
        normal = SEMI_MAJOR / math.sqrt(1.0 - _ECCENTRICITY_2 * math.sin(lat) ** 2)
        ring = (normal + self.altitude) * math.cos(lat)
        z = (normal * (1.0 - _ECCENTRICITY_2) + self.altitude) * math.sin(lat)
        return np.array([ring * math.cos(lon), ring * math.sin(lon), z])

    @staticmethod
    def from_ecef(ecef: NDArray[np.float64]) -> GeoPoint:
        """Return the point of earth-centred coordinates `(3,)` [m], not near the earth's centre.

        Source: Hofmann-Wellenhof et al., GNSS, 2008, section 8.2.1: a fixed point in the latitude.
        """
        x, y, z = (float(value) for value in ecef)
        ring = math.hypot(x, y)
        lat = math.atan2(z, ring * (1.0 - _ECCENTRICITY_2))
        # Each iteration makes the error of a latitude some 150 times smaller.
        for _ in range(6):
            sine = math.sin(lat)
            normal = SEMI_MAJOR / math.sqrt(1.0 - _ECCENTRICITY_2 * sine * sine)
            lat = math.atan2(z + _ECCENTRICITY_2 * normal * sine, ring)
        sine, cosine = math.sin(lat), math.cos(lat)
        normal = SEMI_MAJOR / math.sqrt(1.0 - _ECCENTRICITY_2 * sine * sine)
        altitude = ring * cosine + z * sine - SEMI_MAJOR**2 / normal
        return GeoPoint(math.degrees(lat), math.degrees(math.atan2(y, x)), altitude)


class TangentPlane:
    """East, north, up at an origin, which GPS coordinates follow within some kilometres of it."""

    def __init__(self, origin: GeoPoint) -> None:
        lat, lon = math.radians(origin.latitude_deg), math.radians(origin.longitude_deg)
        (sin_a, cos_a), (sin_o, cos_o) = (
            (math.sin(lat), math.cos(lat)),
            (math.sin(lon), math.cos(lon)),
        )
        self._origin = origin.ecef()
        self._rotation = np.array(
            [
                [-sin_o, cos_o, 0.0],
                [-sin_a * cos_o, -sin_a * sin_o, cos_a],
                [cos_a * cos_o, cos_a * sin_o, sin_a],
            ]
        )

    def enu(self, point: GeoPoint) -> NDArray[np.float64]:
        """Return a point as east, north and up `(3,) float64` of the origin [m]."""
        result: NDArray[np.float64] = self._rotation @ (point.ecef() - self._origin)
        return result

    def geodetic(self, enu: NDArray[np.float64]) -> GeoPoint:
        """Return the point that lies east, north and up `(3,)` of the origin [m]."""
        return GeoPoint.from_ecef(self._origin + self._rotation.T @ enu)


class MapOnEarth:
    """A map with a known position and direction on the earth.

    Args:
        reference: A point whose position in the map is known.
        x: Its position in the map [m].
        y: Its position in the map [m].
        heading: Direction of the map's x axis, counter-clockwise from east [rad].
    """

    def __init__(
        self, reference: GeoPoint, x: float = 0.0, y: float = 0.0, heading: float = 0.0
    ) -> None:
        self._plane = TangentPlane(reference)
        self._T_map_enu = SE2(x, y, -heading)

    def to_map(self, point: GeoPoint, yaw: float = 0.0) -> SE2:
        """Return the pose in the map of a point and a direction, counter-clockwise from east."""
        east, north, _ = self._plane.enu(point)
        return self._T_map_enu @ SE2(float(east), float(north), yaw)

    def to_earth(self, x: float, y: float, up: float = 0.0) -> GeoPoint:
        """Return a point of the map on the earth, `up` above the reference's plane [m]."""
        local = self._T_map_enu.inverse() @ SE2(x, y)
        return self._plane.geodetic(np.array([local.x, local.y, up]))
