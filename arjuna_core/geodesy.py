"""Points on the earth: WGS84, the local tangent plane, UTM, and where a map lies on it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2

GRAVITY = 9.81
"""As in Gazebo; standard gravity is 9.80665 (ISO 80000-3) [m/s^2]."""
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

    def ecef(self) -> Floats:
        """Return earth-centred, earth-fixed coordinates `(3,) float64` [m]."""
        lat, lon = math.radians(self.latitude_deg), math.radians(self.longitude_deg)
        normal = SEMI_MAJOR / math.sqrt(1.0 - _ECCENTRICITY_2 * math.sin(lat) ** 2)
        ring = (normal + self.altitude) * math.cos(lat)
        z = (normal * (1.0 - _ECCENTRICITY_2) + self.altitude) * math.sin(lat)
        return np.array([ring * math.cos(lon), ring * math.sin(lon), z])

    @staticmethod
    def from_ecef(ecef: Floats) -> GeoPoint:
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

    def enu(self, point: GeoPoint) -> Floats:
        """Return a point as east, north and up `(3,) float64` of the origin [m]."""
        result: Floats = self._rotation @ (point.ecef() - self._origin)
        return result

    def geodetic(self, enu: Floats) -> GeoPoint:
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


_N = FLATTENING / (2.0 - FLATTENING)
_E = math.sqrt(FLATTENING * (2.0 - FLATTENING))
_FORWARD = (
    _N / 2 - 2 * _N**2 / 3 + 5 * _N**3 / 16 + 41 * _N**4 / 180,
    13 * _N**2 / 48 - 3 * _N**3 / 5 + 557 * _N**4 / 1440,
    61 * _N**3 / 240 - 103 * _N**4 / 140,
    49561 * _N**4 / 161280,
)
_BACK = (
    _N / 2 - 2 * _N**2 / 3 + 37 * _N**3 / 96 - _N**4 / 360,
    _N**2 / 48 + _N**3 / 15 - 437 * _N**4 / 1440,
    17 * _N**3 / 480 - 37 * _N**4 / 840,
    4397 * _N**4 / 161280,
)
# Scale on the central meridian times the radius of a meridian as long as a circle's [m].
_RADIUS = 0.9996 * SEMI_MAJOR / (1.0 + _N) * (1.0 + _N**2 / 4 + _N**4 / 64)
_EAST, _SOUTH = 500_000.0, 10_000_000.0  # false easting, and northing of the equator in the south


class UtmGrid:
    """A zone of UTM: easting, northing and altitude, within 1e-6 m of the projection.

    Source: L. Krueger's series to the fourth order, in C. Karney, Transverse Mercator with an
    accuracy of a few nanometers, Journal of Geodesy 85 (2011), equations 7 to 36; J. Snyder, Map
    Projections, USGS 1395 (1987), for the zones, those of Norway and Svalbard included.

    Args:
        point: A point in the zone, and in its hemisphere.

    Attributes:
        zone: 1 to 60.
    """

    def __init__(self, point: GeoPoint) -> None:
        latitude, longitude = point.latitude_deg, point.longitude_deg
        self.zone = int((longitude + 180.0) // 6.0) % 60 + 1
        if 56.0 <= latitude < 64.0 and 3.0 <= longitude < 12.0:
            self.zone = 32
        if latitude >= 72.0 and 0.0 <= longitude < 42.0:
            edges = (9.0, 21.0, 33.0)
            self.zone = 31 + 2 * sum(longitude >= edge for edge in edges)
        self._middle = math.radians(6.0 * self.zone - 183.0)
        self._north = _SOUTH if latitude < 0.0 else 0.0

    def enu(self, point: GeoPoint) -> Floats:
        """Return easting, northing and altitude `(3,) float64` [m]."""
        north, east = self._sphere(point)
        z = complex(north, east)
        z += sum(a * np.sin(2 * j * z) for j, a in enumerate(_FORWARD, 1))
        return np.array(
            [_EAST + _RADIUS * z.imag, self._north + _RADIUS * z.real, point.altitude], np.float64
        )

    def geodetic(self, enu: Floats) -> GeoPoint:
        """Return the point of an easting, a northing and an altitude `(3,)` [m]."""
        east, north, altitude = (float(value) for value in enu)
        z = complex((north - self._north) / _RADIUS, (east - _EAST) / _RADIUS)
        z -= sum(b * np.sin(2 * j * z) for j, b in enumerate(_BACK, 1))
        across = math.sinh(z.imag)
        conformal = math.sin(z.real) / math.hypot(across, math.cos(z.real))
        slope = conformal / (1.0 - _E**2)
        for _ in range(5):  # Newton; each iteration doubles the digits
            found = _conformal(slope)
            step = (1.0 + (1.0 - _E**2) * slope**2) / ((1.0 - _E**2) * math.hypot(1.0, slope))
            slope += (conformal - found) / math.hypot(1.0, found) * step
        longitude = math.degrees(self._middle + math.atan2(across, math.cos(z.real)))
        return GeoPoint(math.degrees(math.atan(slope)), math.remainder(longitude, 360.0), altitude)

    def convergence(self, point: GeoPoint) -> float:
        """Return the heading in the grid of what heads for true east, counter-clockwise [rad]."""
        north, east = self._sphere(point)
        z = complex(north, east)
        turned = 1.0 + sum(2 * j * a * np.cos(2 * j * z) for j, a in enumerate(_FORWARD, 1))
        # On the sphere tan of the convergence is tanh(east) tan(north).
        sphere = math.atan2(math.sinh(east) * math.sin(north), math.cosh(east) * math.cos(north))
        return sphere - float(np.angle(turned))

    def _sphere(self, point: GeoPoint) -> tuple[float, float]:
        """Return northing and easting of the conformal sphere's own projection [rad]."""
        slope = _conformal(math.tan(math.radians(point.latitude_deg)))
        turn = math.radians(point.longitude_deg) - self._middle
        east = math.asinh(math.sin(turn) / math.hypot(slope, math.cos(turn)))
        return math.atan2(slope, math.cos(turn)), east


def _conformal(slope: float) -> float:
    """Return the tangent of the conformal latitude, of that of a latitude."""
    sigma = math.sinh(_E * math.atanh(_E * slope / math.hypot(1.0, slope)))
    return slope * math.hypot(1.0, sigma) - sigma * math.hypot(1.0, slope)
