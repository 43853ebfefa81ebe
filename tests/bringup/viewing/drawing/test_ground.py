"""Claims: a line of sight finds its place on the ground, and a drag its pose."""

from __future__ import annotations

import math

import pytest

from arjuna_core.se2 import SE2
from bringup.viewing.drawing.ground import dragged_pose, heading_to, on_ground


def test_a_line_of_sight_meets_the_ground_beyond_or_before_the_point_it_goes_through() -> None:
    assert on_ground((0.0, 0.0, 4.0), (1.0, 1.0, 2.0)) == pytest.approx((2.0, 2.0))
    assert on_ground((0.0, 0.0, 4.0), (3.0, 0.0, -2.0)) == pytest.approx((2.0, 0.0))


@pytest.mark.parametrize("through", [(1.0, 0.0, 4.0), (1.0, 0.0, 5.0)])
def test_a_look_at_the_sky_meets_no_ground(through: tuple[float, float, float]) -> None:
    assert on_ground((0.0, 0.0, 4.0), through) is None


def test_from_below_the_ground_nothing_is_met() -> None:
    assert on_ground((0.0, 0.0, -1.0), (0.0, 0.0, -2.0)) is None


def test_a_drag_heads_for_where_it_ended() -> None:
    assert dragged_pose((1.0, 1.0), (1.0, 3.0), 0.3) == SE2(1.0, 1.0, math.pi / 2)


def test_a_click_takes_the_given_heading() -> None:
    assert dragged_pose((1.0, 1.0), (1.0, 1.05), 0.3) == SE2(1.0, 1.0, 0.3)


def test_the_heading_of_a_click_leads_away_from_the_robot() -> None:
    assert heading_to(SE2(1.0, 1.0, 2.0), (0.0, 1.0)) == pytest.approx(math.pi)
    assert heading_to(None, (0.0, 1.0)) == 0.0
