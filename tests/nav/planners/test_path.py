"""Questions about a path: how long it is, where the robot is on it, whether it comes back."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_nav.planners import path as paths
from tests.nav.worlds import polyline

CORNER = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 4.0, 1.57], [3.0, 4.5, 1.57]])
LOOP = np.array(
    [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.1, 0.0]]
)


def test_a_path_is_as_long_as_its_steps_together() -> None:
    assert paths.length(CORNER) == pytest.approx(7.5)
    assert paths.along(CORNER) == pytest.approx([0.0, 3.0, 7.0, 7.5])
    assert paths.length(CORNER[:1]) == 0.0
    assert paths.along(CORNER[:1]) == pytest.approx([0.0])


def test_the_robot_is_at_the_nearest_pose_of_the_part_it_looks_at() -> None:
    beside = SE2(0.3, 0.2)
    assert paths.distances(LOOP, SE2(2.0, 1.0)) == pytest.approx(
        [5**0.5, 1.0, 1.0, 5**0.5, 4.81**0.5]
    )
    assert paths.nearest(LOOP, SE2(0.0, 0.1)) == 4
    assert paths.nearest(LOOP, beside) == 4
    assert paths.nearest(LOOP, beside, within=4.0) == 0
    assert paths.nearest(LOOP, beside, first=1, within=4.0) in (1, 3)
    assert paths.nearest(LOOP, SE2(0.0, 2.1), first=1) == 3


def test_what_is_left_of_a_path_begins_where_the_robot_is() -> None:
    assert paths.remaining(CORNER, SE2(2.9, 0.3)) == pytest.approx(4.5)
    np.testing.assert_array_equal(paths.ahead(CORNER, SE2(2.9, 0.3)), CORNER[1:])


@pytest.mark.parametrize(
    ("path", "pose", "ends"),
    [
        (CORNER, SE2(0.0, 0.0), False),  # 7.5 m for 5.4
        (CORNER[1:], SE2(3.0, 0.0), True),
        (LOOP, SE2(0.0, 0.0), False),
        (LOOP[3:], SE2(0.0, 2.0), True),
        (np.array([[4.0, 6.0, 0.0], [0.0, 3.0, 0.0]]), SE2(4.0, 6.0), True),
        (np.array([[0.0, 0.0, 0.0], [0.0, 2.45, 0.0], [0.0, 2.0, 0.0]]), SE2(), True),  # 0.9 more
        (np.array([[0.0, 0.0, 0.0], [0.0, 2.55, 0.0], [0.0, 2.0, 0.0]]), SE2(), False),  # 1.1
    ],
)
def test_a_path_leads_to_its_end_where_it_is_not_a_metre_longer_than_straight(
    path: np.ndarray, pose: SE2, ends: bool
) -> None:
    assert paths.ends_here(path, pose) is ends


def test_two_paths_are_as_far_apart_as_the_worst_of_them() -> None:
    straight = np.column_stack((np.linspace(0.0, 4.0, 41), np.zeros((41, 2))))
    bulged = straight + [0.0, 1.0, 0.0] * np.exp(-((straight[:, :1] - 2.0) ** 2) * 8.0)
    assert paths.deviation(straight, straight) == 0.0
    assert paths.deviation(bulged, straight) == pytest.approx(1.0, abs=0.02)
    assert paths.deviation(straight, bulged) < 0.7  # beside the bulge there is a way


def test_a_path_is_driven_ahead_and_back_by_its_headings() -> None:
    ahead = polyline([(0.0, 0.0), (1.0, 0.0)], 0.0)
    back = polyline([(1.0, 0.0), (0.5, 0.0)], 0.0)
    back[:, 2] = 0.0
    turned = ahead + np.array([0.0, 0.0, math.pi])
    assert paths.directions(ahead) == [1]
    assert paths.directions(turned) == [-1]
    assert paths.directions(np.vstack((ahead, back[1:]))) == [1, -1]
    assert paths.directions(np.vstack((ahead, turned[::-1]))) == [1], "it turns on the spot"
    assert paths.directions(ahead[:1]) == []
