"""A person's commands, slower the nearer a collision, and none that has ceased."""

from __future__ import annotations

import pytest

from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.behaviors.base import BehaviorConfig, BehaviorStatus
from arjuna_nav.behaviors.motions import AssistedTeleop
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from tests.nav.worlds import block, costmap_of, empty_grid

CONFIG = BehaviorConfig(projection_time=1.0, simulation_time_step=0.1)
AHEAD, CIRCLE = Velocity(0.5), Footprint.circle(0.25)


def teleop(allowance: float = 0.0) -> AssistedTeleop:
    return AssistedTeleop(CONFIG, CIRCLE, allowance)


def wall(x: float) -> Costmap:
    """Return the costmap of a hall with a wall at x."""
    grid = empty_grid(6.0, 4.0)
    block(grid, x, 0.0, 0.1, 4.0)
    return costmap_of(grid)


@pytest.mark.parametrize("velocity", [AHEAD, Velocity(-0.5), Velocity(0.2, yaw_rate=-0.6)])
def test_where_all_is_free_it_drives_as_commanded(velocity: Velocity) -> None:
    behavior = teleop()
    behavior.take(velocity, 0.0)
    result = behavior.tick(SE2(2.0, 2.0), wall(5.0), 0.5)
    assert (result.status, result.velocity) == (BehaviorStatus.RUNNING, velocity)


@pytest.mark.parametrize(("gap", "part"), [(0.45, 0.9), (0.3, 0.6), (0.15, 0.3), (0.02, 0.0)])
def test_the_nearer_a_wall_the_slower_up_to_where_it_stands(gap: float, part: float) -> None:
    behavior = teleop()
    behavior.take(Velocity(0.5, yaw_rate=0.2), 0.0)
    result = behavior.tick(SE2(4.0 - 0.25 - gap, 2.0), wall(4.0), 0.0)
    assert result.velocity.x == pytest.approx(0.5 * part, abs=0.075)
    assert result.velocity.yaw_rate == pytest.approx(0.4 * result.velocity.x)


def test_a_command_that_ceased_holds_no_longer_than_the_time_looked_ahead() -> None:
    behavior, free = teleop(), wall(5.0)
    assert behavior.tick(SE2(2.0, 2.0), free, 0.0).velocity == STILL
    behavior.take(AHEAD, 1.0)
    assert behavior.tick(SE2(2.0, 2.0), free, 1.9).velocity == AHEAD
    assert behavior.tick(SE2(2.0, 2.0), free, 2.1).velocity == STILL


def test_it_ends_when_somebody_is_done_or_its_time_is_over() -> None:
    behavior, free = teleop(), wall(5.0)
    assert behavior.tick(SE2(2.0, 2.0), free, 0.0).status is BehaviorStatus.RUNNING
    behavior.finish()
    assert behavior.tick(SE2(2.0, 2.0), free, 0.1).status is BehaviorStatus.SUCCEEDED
    late = teleop(2.0)
    late.tick(SE2(2.0, 2.0), free, 5.0)
    assert late.tick(SE2(2.0, 2.0), free, 6.9).status is BehaviorStatus.RUNNING
    assert late.tick(SE2(2.0, 2.0), free, 7.1).status is not BehaviorStatus.RUNNING
