"""UTM: published coordinates, the meridian's length, angles, there and back."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.geodesy import FLATTENING, SEMI_MAJOR, GeoPoint, TangentPlane
from arjuna_core.utm import UtmGrid

CN_TOWER = GeoPoint(43 + 38 / 60 + 33.24 / 3600, -(79 + 23 / 60 + 13.7 / 3600))


@pytest.mark.parametrize(
    ("point", "zone", "east", "north", "within"),
    [
        (GeoPoint(33.3, 44.4), 38, 444140.54, 3684706.36, 0.006),  # GeographicLib's manual
        (CN_TOWER, 17, 630084.0, 4833438.0, 1.0),  # Wikipedia's page of UTM
        (GeoPoint(0.0, 3.0), 31, 500000.0, 0.0, 1e-6),
        (GeoPoint(-33.3, 44.4), 38, 444140.54, 1e7 - 3684706.36, 0.006),
    ],
)
def test_published_coordinates(
    point: GeoPoint, zone: int, east: float, north: float, within: float
) -> None:
    grid = UtmGrid(point)
    assert grid.zone == zone
    assert grid.enu(point) == pytest.approx((east, north, 0.0), abs=within)


@pytest.mark.parametrize(
    ("latitude", "longitude", "zone"),
    [(10, -180, 1), (10, 179.9, 60), (10, 180, 1), (60, 4, 32), (65, 4, 31), (75, 8, 31),
     (75, 9, 33), (75, 21, 35), (75, 33, 37), (75, 42, 38)],
)  # fmt: skip
def test_zones(latitude: float, longitude: float, zone: int) -> None:
    assert UtmGrid(GeoPoint(latitude, longitude)).zone == zone


def test_the_central_meridian_is_as_long_as_its_arc() -> None:
    latitudes = np.radians(np.linspace(0.0, 60.0, 200_001))
    e2 = FLATTENING * (2.0 - FLATTENING)
    radius = SEMI_MAJOR * (1.0 - e2) / (1.0 - e2 * np.sin(latitudes) ** 2) ** 1.5
    arc = float(np.trapezoid(radius, latitudes))
    point = GeoPoint(60.0, 15.0)
    assert UtmGrid(point).enu(point)[1] == pytest.approx(0.9996 * arc, abs=1e-4)


@pytest.mark.parametrize("latitude", [-79.0, -33.0, 0.5, 48.0, 70.0])
@pytest.mark.parametrize("off", [-3.0, 0.7, 2.9])
def test_there_and_back_and_the_heading_of_the_grid(latitude: float, off: float) -> None:
    point = GeoPoint(latitude, 9.0 + off, 120.0)
    grid = UtmGrid(GeoPoint(latitude, 9.0))
    again = grid.geodetic(grid.enu(point))
    assert (again.latitude_deg, again.longitude_deg, again.altitude) == pytest.approx(
        (latitude, 9.0 + off, 120.0), abs=1e-11
    )
    east = TangentPlane(point).geodetic(np.array([1.0, 0.0, 0.0]))
    dx, dy, _ = grid.enu(east) - grid.enu(point)
    assert math.atan2(dy, dx) == pytest.approx(grid.convergence(point), abs=1e-6)
    assert math.hypot(dx, dy) == pytest.approx(1.0, abs=1.1e-3)
