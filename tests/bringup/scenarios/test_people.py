"""People's paths: round what stands there, and else as asked."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.errors import ArjunaError
from arjuna_core.se2 import SE2
from arjuna_sim.model.world import PERSON
from bringup.scenarios.people import route_past


def box(x: float, y: float, length: float, width: float, yaw: float = 0.0) -> NDArray[np.float64]:
    half = np.array([length, width]) / 2.0
    return SE2(x, y, yaw).apply(np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half)


def gap(route: list[tuple[float, float]], corners: NDArray[np.float64]) -> float:
    """Return how near a path comes to a rectangle [m]."""
    points = np.vstack([np.linspace(a, b, 200) for a, b in itertools.pairwise(route)])
    side = corners[1] - corners[0]
    x, y = corners.mean(axis=0).tolist()
    middle = SE2(x, y, math.atan2(side[1], side[0]))
    half = np.linalg.norm([side, corners[2] - corners[1]], axis=1) / 2.0
    outside = np.maximum(np.abs(middle.inverse().apply(points)) - half, 0.0)
    return float(np.hypot(*outside.T).min())


@pytest.mark.parametrize("yaw", [0.0, 0.5, -2.0])
def test_a_person_goes_round_boxes_and_arrives_where_asked(yaw: float) -> None:
    corners = box(2.5, 0.1, 0.5, 1.5, yaw)
    route = route_past([(1.0, 0.0), (4.0, 0.0), (1.0, 0.0)], [corners])
    assert (1.0, 0.0) == route[0] == route[-1]
    assert (4.0, 0.0) in route
    assert gap(route, corners) > PERSON[0] - 0.01


def test_a_free_path_is_walked_as_it_is_and_a_point_in_a_box_moves_beside_it() -> None:
    asked = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.5)]
    assert route_past(asked, []) == asked
    assert route_past(asked, [box(1.0, 3.0, 0.5, 0.5)]) == asked
    corners = box(2.0, 1.5, 0.6, 0.6)
    route = route_past(asked, [corners])
    assert math.dist(route[-1], asked[-1]) < 0.7
    assert gap(route, corners) > PERSON[0] - 0.01


def test_a_path_through_a_gap_too_narrow_is_refused() -> None:
    walls = [box(0.0, -5.0, 0.2, 9.6), box(0.0, 5.0, 0.2, 9.6)]  # 0.4 m between them
    with pytest.raises(ArjunaError, match="no path from -1,0 to 1,0 is wide enough for a person"):
        route_past([(-1.0, 0.0), (1.0, 0.0)], walls)
