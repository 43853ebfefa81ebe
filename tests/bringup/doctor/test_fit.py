"""The share of a scan's hits on the map's walls: all from the true pose, few from another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from bringup.doctor.fit import scan_facts


def _room() -> OccupancyGrid:
    """Return a room of 4 x 2 m whose lower left corner is the origin."""
    data = np.zeros((40, 80), dtype=np.int8)
    data[[0, -1], :] = data[:, [0, -1]] = 100
    return OccupancyGrid(GridFrame(0.05, 80, 40), data)


def _scan_at(x: float, y: float, heading: float) -> Scan:
    angles = np.linspace(-np.pi, np.pi, 180, endpoint=False)
    c, s = np.cos(angles + heading), np.sin(angles + heading)
    with np.errstate(divide="ignore"):
        along_x = np.where(c > 0.0, (3.975 - x) / c, (0.025 - x) / c)
        along_y = np.where(s > 0.0, (1.975 - y) / s, (0.025 - y) / s)
    ranges = np.minimum(np.abs(along_x), np.abs(along_y))
    return Scan(ranges, -np.pi, 2.0 * np.pi / 180, 0.1, 10.0)


@pytest.mark.parametrize("pose", [SE2(1.0, 0.5, 0.3), SE2(3.0, 1.5, -2.0)])
def test_from_the_true_pose_every_hit_is_on_a_wall(pose: SE2) -> None:
    scan = _scan_at(pose.x, pose.y, pose.theta)
    assert scan_facts(scan, "l", False, _room(), pose).on_walls == 1.0
    away = SE2(pose.x + 0.5, pose.y - 0.2, pose.theta + 0.8)
    fit = scan_facts(scan, "l", False, _room(), away).on_walls
    assert fit is not None
    assert fit < 0.6


def test_a_scan_of_a_sensor_upside_down_is_mirrored() -> None:
    pose = SE2(1.0, 0.5, 0.3)
    scan = _scan_at(pose.x, pose.y, pose.theta)
    turned_scan = replace(scan, ranges=scan.ranges[::-1].copy(), angle_min=np.pi * (2 / 180 - 1))
    assert scan_facts(turned_scan, "l", True, _room(), pose).on_walls == 1.0
    turned = scan_facts(turned_scan, "l", False, _room(), pose).on_walls
    assert turned is not None
    assert turned < 0.6


def test_without_a_map_or_a_pose_nothing_is_said_of_the_fit() -> None:
    scan = _scan_at(1.0, 0.5, 0.3)
    assert scan_facts(scan, "l", False, None, SE2(1.0, 0.5, 0.3)).on_walls is None
    assert scan_facts(scan, "l", False, _room(), None).on_walls is None


def test_a_map_without_walls_says_nothing_of_the_fit() -> None:
    empty = OccupancyGrid(GridFrame(0.05, 80, 40), np.zeros((40, 80), dtype=np.int8))
    scan = _scan_at(1.0, 0.5, 0.3)
    assert scan_facts(scan, "l", False, empty, SE2(1.0, 0.5, 0.3)).on_walls is None


def test_shares_are_of_all_beams() -> None:
    scan = Scan(np.array([0.02, 1.0, np.inf, np.inf]), 0.0, 0.1, 0.01, 5.0)
    facts = scan_facts(scan, "l", False, None, None)
    assert (facts.returns, facts.near) == (0.5, 0.25)
