"""How a played robot gives way to people and walls, as it does in the simulator."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.se2 import IDENTITY, SE2
from tests.helpers.nav.layers import Body
from tests.helpers.nav.people import Pushes

CORNERS = Body.box(0.4, 0.4).corners
NO_WALLS = np.zeros((0, 4))


def walked_over(offset: float, walls: NDArray[np.float64] = NO_WALLS, start: SE2 = IDENTITY) -> SE2:
    """Return where a robot is when somebody has walked by along x."""
    pushes, pose = Pushes(CORNERS, walls), start
    for x in np.arange(-1.0, 1.5, 0.04):
        pose = pushes.yield_to(pose, np.array([(x, offset, 0.25)]))
    return pose


def test_who_meets_nobody_stays() -> None:
    assert walked_over(0.5) is IDENTITY


def test_who_is_met_square_is_carried_along() -> None:
    pose = walked_over(0.0)
    assert (pose.x, pose.y, pose.theta) == pytest.approx((1.48 + 0.25 + 0.2, 0.0, 0.0), abs=2e-3)


@pytest.mark.parametrize("turn", [0.0, 2.2])
def test_who_is_met_beside_its_middle_turns_and_slips_off(turn: float) -> None:
    start = SE2(0.0, 0.0, turn)
    above, below = walked_over(0.15, start=start), walked_over(-0.15, start=SE2(0.0, 0.0, -turn))
    assert 0.05 < above.x < 1.0
    assert above.y < -0.1
    assert 0.2 < abs(above.theta - turn) < math.pi / 2
    mirrored = SE2(below.x, -below.y, -below.theta)
    assert mirrored.array() == pytest.approx(above.array(), abs=1e-6)


@pytest.mark.parametrize("face", [0.2, 0.3])
def test_walls_hold_who_is_pressed_and_people_step_over(face: float) -> None:
    wall = np.array([(face, -2.0, face, 2.0)])
    pose = walked_over(0.0, wall)
    assert face - 0.2 - 0.01 < pose.x <= face - 0.2
    assert pose.theta == pytest.approx(0.0, abs=0.03)


def test_the_end_of_a_wall_turns_who_is_pressed_against_it() -> None:
    wall = np.array([(0.21, 0.1, 2.0, 0.1), (2.0, 0.1, 0.21, 0.1)])
    pushes = Pushes(CORNERS, wall)
    pose = pushes.yield_to(IDENTITY, np.array([(-0.42, 0.0, 0.25)]))
    assert pushes.pinned
    assert pose.theta > 0.01
    assert pose.x < 0.025  # of 0.03
    pushes.yield_to(SE2(-1.0), np.zeros((0, 3)))
    assert not pushes.pinned
