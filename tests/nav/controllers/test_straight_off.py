"""A robot that touches something drives straight off it before it turns."""

from __future__ import annotations

import math

import pytest

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.straight_off import straight_off
from arjuna_nav.costmap.footprint import Footprint
from tests.helpers.nav.bodies import Body
from tests.nav.worlds import block, costmap_of, empty_grid

TURN = Velocity(0.02, yaw_rate=1.5)
ROUND = Footprint.circle(0.25)
SQUARE = Footprint.polygon(Body.box(0.45, 0.38).corners)


def off(
    pose: SE2,
    command: Velocity = TURN,
    robot: Footprint = ROUND,
    behind: float = 4.0,
    fastest: float = 0.5,
) -> float | None:
    """Return the speed at which a robot drives off a wall at y 1.0 to 1.2, None for as it was."""
    grid = empty_grid(4.0, 4.0)
    block(grid, 0.0, 1.0, 4.0, 0.2)
    block(grid, 0.0, behind, 4.0, 0.2)
    costmap = costmap_of(grid, footprint="[]" if robot.circular else str(robot.points.tolist()))
    driven = straight_off(command, pose, costmap, robot, fastest)
    assert driven is None or driven.yaw_rate == 0.0
    return None if driven is None else driven.x


@pytest.mark.parametrize("command", [TURN, Velocity(yaw_rate=-0.3), Velocity(-0.1, yaw_rate=1.0)])
@pytest.mark.parametrize(("heading", "sign"), [(0.5, 1.0), (1.57, 1.0), (-0.5, -1.0)])
def test_it_drives_off_the_way_it_looks_or_back(
    heading: float, sign: float, command: Velocity
) -> None:
    speed = off(SE2(2.0, 1.4, heading), command)
    assert speed is not None
    assert math.copysign(1.0, speed) == sign


@pytest.mark.parametrize(
    ("pose", "command"),
    [
        (SE2(2.0, 1.6, 0.5), TURN),  # it touches nothing
        (SE2(2.0, 1.4, 0.5), Velocity(0.3, yaw_rate=0.5)),  # it drives more than it turns
        (SE2(2.0, 1.4, 0.5), Velocity()),
        (SE2(2.0, 1.4, 0.0), TURN),  # along the wall it would not get off
    ],
)
def test_else_it_does_as_it_is_told(pose: SE2, command: Velocity) -> None:
    assert off(pose, command) is None


def test_it_does_not_drive_from_one_wall_into_another() -> None:
    assert off(SE2(2.0, 1.4, 1.57), behind=1.8) == pytest.approx(0.15)
    assert off(SE2(2.0, 1.4, 1.57), behind=1.6) is None


@pytest.mark.parametrize(("fastest", "speed"), [(0.5, 0.15), (0.05, 0.05), (0.0, None)])
def test_it_drives_no_faster_than_it_may(fastest: float, speed: float | None) -> None:
    assert off(SE2(2.0, 1.4, 1.57), fastest=fastest) == speed


def test_an_outline_counts_as_it_lies() -> None:
    assert off(SE2(2.0, 1.4, 0.0), robot=SQUARE) is None  # beside the wall, its side along it
    assert off(SE2(2.0, 1.42, 1.0), robot=SQUARE) is not None
