"""The gaps between a scan's points on one wall are filled, evenly and turning with it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_slam.matching.surface import Surface, extract
from tests.slam.slam_room import box, room, scan_at


def facing(*degrees: float) -> np.ndarray:
    angles = np.radians(degrees)
    return np.column_stack((np.cos(angles), np.sin(angles)))


@pytest.mark.parametrize(
    ("gap", "turn", "linked", "filled"),
    [
        (0.04, 0.0, True, 0),
        (0.06, 0.0, True, 1),
        (0.26, 0.0, True, 5),
        (0.26, 36.0, True, 5),
        (0.26, -36.0, True, 5),
        (0.26, 38.0, True, 0),  # around a corner: not the same wall
        (0.26, 0.0, False, 0),
    ],
)
def test_a_gap_on_a_wall_is_filled_evenly(
    gap: float, turn: float, linked: bool, filled: int
) -> None:
    ends = np.array([[1.0, 2.0], [1.0 + 0.6 * gap, 2.0 - 0.8 * gap], [9.0, 9.0]])
    normals = facing(20.0, 20.0 + turn, 0.0)
    surface = Surface(ends, normals, np.array([linked, False, False]))
    points, turned = surface.dense(0.05)
    assert len(points) == len(turned) == filled + 3
    share = np.linspace(0.0, 1.0, filled + 2)
    np.testing.assert_allclose(points[:-1], ends[0] + share[:, None] * (ends[1] - ends[0]))
    blend = (1.0 - share)[:, None] * normals[0] + share[:, None] * normals[1]
    np.testing.assert_allclose(turned[:-1], blend / np.linalg.norm(blend, axis=1)[:, None])
    np.testing.assert_array_equal(points[-1], ends[2])
    if filled == 5:  # in the middle half of the turn
        middle = math.degrees(math.atan2(turned[3, 1], turned[3, 0]))
        assert middle == pytest.approx(20.0 + 0.5 * turn)


def test_points_without_a_wall_are_left_as_they_are() -> None:
    ends, none = np.array([[1.0, 2.0], [2.0, 2.0]]), np.zeros((2, 2))
    points, normals = Surface(ends, none, np.ones(2, np.bool_)).dense(0.05)
    np.testing.assert_array_equal(points, ends)
    np.testing.assert_array_equal(normals, none)
    nothing = Surface(ends[:0], none[:0], np.zeros(0, np.bool_)).dense(0.05)
    assert [len(part) for part in nothing] == [0, 0]


def test_normals_are_unit_face_the_sensor_and_lie_across_walls() -> None:
    surface = extract(scan_at(box(-2.0, -2.0, 2.0, 2.0), SE2()), 20.0)
    length = np.hypot(*surface.normals.T)
    assert ((np.abs(length - 1.0) < 1e-9) | (length == 0.0)).all()
    assert (length > 0.0).mean() > 0.85
    assert ((surface.normals * surface.points).sum(axis=1) <= 0.0).all()
    right = (surface.points[:, 0] > 1.99) & (np.abs(surface.points[:, 1]) < 1.5)
    assert np.abs(surface.normals[right] - (-1.0, 0.0)).max() < 1e-6


def test_a_wall_continues_where_beams_are_lost() -> None:
    scan = scan_at(room(), SE2(5.0, 5.0, 0.3), sigma=0.01, rng=np.random.default_rng(2))
    lost = np.where(np.random.default_rng(3).random(360) < 0.3, np.inf, scan.ranges)
    surface = extract(dataclasses.replace(scan, ranges=lost), 20.0)
    assert (np.abs(surface.normals).sum(axis=1) > 0.0).mean() > 0.8
    gap = np.where(np.arange(360) % 8 < 4, np.inf, scan.ranges)
    cut = extract(dataclasses.replace(scan, ranges=gap), 20.0)
    assert not cut.linked[3::4].any()
