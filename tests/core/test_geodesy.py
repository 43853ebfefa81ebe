"""WGS84: known points, distances along meridians and parallels, there and back."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.geodesy import FLATTENING, SEMI_MAJOR, GeoPoint, MapOnEarth, TangentPlane, UtmGrid

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


POINTS = [
    GeoPoint(0.0, 0.0),
    GeoPoint(48.1351, 11.5820, 519.0),
    GeoPoint(-33.8688, 151.2093, -20.0),
    GeoPoint(89.99, -179.9, 3000.0),
    GeoPoint(-90.0, 0.0),
]


def test_the_axes_of_the_ellipsoid() -> None:
    assert GeoPoint(0.0, 0.0).ecef() == pytest.approx([SEMI_MAJOR, 0.0, 0.0])
    assert GeoPoint(0.0, 90.0).ecef() == pytest.approx([0.0, SEMI_MAJOR, 0.0], abs=1e-6)
    polar = 6356752.314245  # [m], as the standard of WGS84 rounds it
    assert GeoPoint(90.0, 0.0).ecef() == pytest.approx([0.0, 0.0, polar], abs=1e-6)


@pytest.mark.parametrize("point", POINTS)
def test_there_and_back(point: GeoPoint) -> None:
    again = GeoPoint.from_ecef(point.ecef())
    assert again.ecef() == pytest.approx(point.ecef(), abs=1e-6)
    assert again.altitude == pytest.approx(point.altitude, abs=1e-6)


@pytest.mark.parametrize("latitude", [0.0, 30.0, 60.0, -75.0])
def test_a_small_step_is_as_long_as_the_radii_of_curvature_say(latitude: float) -> None:
    e2 = FLATTENING * (2.0 - FLATTENING)
    w = math.sqrt(1.0 - e2 * math.sin(math.radians(latitude)) ** 2)
    north = math.radians(1e-4) * SEMI_MAJOR * (1.0 - e2) / w**3
    east = math.radians(1e-4) * SEMI_MAJOR / w * math.cos(math.radians(latitude))
    plane = TangentPlane(GeoPoint(latitude, 20.0))
    assert plane.enu(GeoPoint(latitude + 1e-4, 20.0))[:2] == pytest.approx([0.0, north], abs=1e-4)
    assert plane.enu(GeoPoint(latitude, 20.0 + 1e-4))[:2] == pytest.approx([east, 0.0], abs=1e-4)


@pytest.mark.parametrize("point", POINTS[:4])
def test_the_plane_is_rigid(point: GeoPoint) -> None:
    plane = TangentPlane(point)
    offsets = np.array([[0.0, 0.0, 0.0], [900.0, -400.0, 30.0], [-5.0, 2000.0, -8.0]])
    for offset in offsets:
        assert plane.enu(plane.geodetic(offset)) == pytest.approx(offset, abs=1e-6)


def test_a_map_is_placed_and_turned() -> None:
    here = GeoPoint(48.0, 11.0)
    assert MapOnEarth(here).to_map(here).array() == pytest.approx(np.zeros(3), abs=1e-6)
    field = MapOnEarth(here, 5.0, -2.0, math.pi / 2.0)  # its x axis points north
    assert field.to_map(here).array()[:2] == pytest.approx([5.0, -2.0])
    north = TangentPlane(here).geodetic(np.array([0.0, 10.0, 0.0]))
    pose = field.to_map(north, math.pi / 2.0)
    assert pose.array() == pytest.approx([15.0, -2.0, 0.0], abs=1e-4)
    assert field.to_map(field.to_earth(30.0, 40.0)).array()[:2] == pytest.approx([30.0, 40.0])


@pytest.mark.parametrize(
    ("values", "says"),
    [((91.0, 0.0), "latitude 91"), ((0.0, -181.0), "longitude -181"), ((math.nan, 0.0), "nan")],
)
def test_impossible_coordinates_are_refused(values: tuple[float, float], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        GeoPoint(*values)
