"""Parameters whose effect no other test would miss: what they change, by value."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from arjuna_core.scan import RangeReading
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.checkers import PoseProgressChecker, PoseProgressConfig
from arjuna_nav.controllers.dwb.config import DwbConfig, RotateToGoalConfig
from arjuna_nav.controllers.dwb.controller import Dwb
from arjuna_nav.controllers.graceful.controller import Graceful, GracefulConfig
from arjuna_nav.controllers.mppi.config import MppiConfig, PathFollowConfig
from arjuna_nav.controllers.mppi.controller import Mppi
from arjuna_nav.controllers.mppi.optimizer import Optimizer
from arjuna_nav.controllers.pursuit.config import RegulatedPurePursuitConfig
from arjuna_nav.controllers.pursuit.controller import RegulatedPurePursuit
from arjuna_nav.costmap import LETHAL, Costmap, LayeredCostmap, PlacedRange
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.docking import approach
from arjuna_nav.docking.dock_types import DockSenses, DockType, SimpleDockConfig
from arjuna_nav.docking.docking import DockingConfig, DockingState, Undocking
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.filter import ParticleFilter
from arjuna_slam.amcl.recovery import MapMatcher, Recovery
from arjuna_slam.config import SlamConfig
from arjuna_slam.matching.map_field import MapField
from tests.helpers.nav.layers import costmap_config, see
from tests.nav.worlds import costmap_of, empty_grid, grid_of, polyline, room, scan_from

ROBOT, AHEAD = Footprint.circle(0.25), polyline([(0.0, 0.0), (4.0, 0.0)], 0.0)
FREE = costmap_of(empty_grid(12.0, 12.0, SE2(-6.0, -6.0)))


def walled(x: float) -> Costmap:
    return costmap_of(grid_of(12.0, 12.0, (6.0 + x, 5.0, 0.1, 2.0), origin=SE2(-6.0, -6.0)))


def driven(make: Any, config: Any, path: Any = AHEAD, costmap: Costmap = FREE) -> Velocity:
    """Return the first command of a controller that stands at the origin."""
    controller = make(config, ROBOT, 0.25, 0.05)
    controller.set_path(path)
    command: Velocity = controller.compute(SE2(), STILL, costmap, 0.0).velocity
    return command


def rounds_a_corner(config: RegulatedPurePursuitConfig) -> bool:
    """Return whether pure pursuit gets on beside a wall that the arc to its carrot cuts."""
    grid = grid_of(12.0, 12.0, (5.4, 6.3, 1.0, 2.0), origin=SE2(-6.0, -6.0))
    corner = polyline([(0.0, 0.0), (0.8, 0.0), (0.8, 2.0)], 1.57)
    return driven(RegulatedPurePursuit, config, corner, costmap_of(grid)).x > 0.0


def dock_speed(config: approach.ApproachConfig) -> float:
    return approach.steer(config, SE2(5.0)).x


def blocked(config: approach.ApproachConfig) -> bool:
    try:
        approach.towards(config, SE2(), SE2(3.0), False, SE2(3.0), walled(1.0), ROBOT)
    except approach.BlockedError:
        return True
    return False


def undocks(config: DockingConfig) -> bool:
    """Return whether 0.1 rad off the staging pose's heading is good enough."""
    kind = DockType(SimpleDockConfig())
    order, at = Undocking(config, kind, ROBOT, 10.0), SE2(-0.69, 0.0, 0.1)
    order.tick(DockingState(0.0, SE2(), None, DockSenses()))
    return order.tick(DockingState(1.0, at, None, DockSenses())).velocity.yaw_rate == 0.0  # type: ignore[union-attr]


def tries(config: MppiConfig) -> int:
    """Return how often MPPI tries where everything collides."""
    controller, count = Mppi(config, ROBOT, 0.25, 0.05), 0

    class Counting(Optimizer):
        def improve(self, *args: Any) -> bool:
            nonlocal count
            count += 1
            return False

    controller._optimizer = Counting(config)
    controller.set_path(AHEAD)
    controller.compute(SE2(), STILL, FREE, 0.0)
    return count


def part_ahead(config: MppiConfig) -> int:
    """Return how many poses are ahead, 0.3 m before a path of 1 m out and back inverts."""
    controller = Mppi(replace(config, batch_size=5, time_steps=3), ROBOT, 0.25, 0.05)
    out = polyline([(0.0, 0.0), (1.0, 0.0)], 0.0)
    controller.set_path(np.vstack((out, out[-2::-1])))
    controller.compute(SE2(0.7), STILL, FREE, 0.0)
    return round(float(controller.path[0, 0]), 1)  # type: ignore[return-value]


def injects(config: AmclConfig) -> float:
    """Return the share of particles that come from anywhere after scans that fit half as well."""
    recovery = Recovery(config, MapMatcher(config, MapField(room(), 2.0)))
    for likelihood in (2.0, 1.0):
        recovery.averages.add(likelihood)
    return recovery.averages.injection


def field_reach(config: AmclConfig) -> float:
    """Return the distance at which likelihoods stop falling."""
    return ParticleFilter(config, room(), np.random.default_rng(0))._matcher.field.max_distance


def edge(config: SlamConfig) -> float:
    """Return the edge of a map's cells."""
    keyframes = config.keyframes()
    keyframes.add(scan_from(room(), SE2()), SE2())
    grid = keyframes.map()
    assert grid is not None
    return grid.frame.resolution


def sees(layer: dict[str, Any]) -> bool:
    layered = LayeredCostmap(
        costmap_config(plugins=("range_layer",), range_layer={"topics": ["sonar"], **layer})
    )
    reading = RangeReading(1.0, 0.4, 0.1, 2.0, 0.0, SE2(0.5, 0.5))
    see(layered, SE2(), 0.0, [PlacedRange(reading, SE2())] * 6)
    return bool((layered.costmap.data == LETHAL).any())


def fastest(**limits: float) -> float:
    base = {"acc_lim_x": 10.0, "linear_granularity": 0.05, "critics": ("GoalDist",)}
    return driven(Dwb, DwbConfig(**base, **limits)).x  # type: ignore[arg-type]


def turned(scale: float) -> float:
    """Return how DWB turns at its goal, which looks to the left, where turns cost as well."""
    config = DwbConfig(critics=("RotateToGoal", "Twirling"), RotateToGoal=RotateToGoalConfig(scale))
    return driven(Dwb, config, polyline([(-1.0, 0.0), (0.0, 0.0)], 1.5)).yaw_rate


def shown(config: PathFollowConfig) -> float:
    """Return how fast MPPI drives where the only critic is that of the path."""
    return driven(Mppi, MppiConfig(critics=("PathFollowCritic",), PathFollowCritic=config)).x


def turning_counts(config: PoseProgressConfig) -> bool:
    """Return whether a turn by 0.7 rad is progress."""
    checker = PoseProgressChecker(config)
    checker.check(SE2(), 0.0)
    checker.check(SE2(theta=0.7), 9.0)
    return checker.check(SE2(theta=0.7), 11.0)


TURNED = polyline([(-1.0, 0.0), (0.0, 0.0)], 0.06)
ASIDE = np.column_stack((AHEAD[:, :1], 0.55 * AHEAD[:, :1], AHEAD[:, :1] * 0.0 + 0.5))
Pursuit, Docks = RegulatedPurePursuitConfig, approach.ApproachConfig
EFFECTS: dict[str, tuple[Callable[[Any], Any], Any, Any]] = {
    "v_linear_max": (dock_speed, Docks(v_linear_max=0.4), 0.4),
    "use_collision_detection": (blocked, Docks(use_collision_detection=False), False),
    "undock_angular_tolerance": (undocks, DockingConfig(undock_angular_tolerance=0.2), True),
    "retry_attempt_limit": (tries, MppiConfig(batch_size=5, retry_attempt_limit=3), 4),
    "inversion_xy_tolerance": (
        part_ahead, MppiConfig(enforce_path_inversion=True, inversion_xy_tolerance=0.35), 1.0,
    ),
    "enforce_path_inversion": (part_ahead, MppiConfig(inversion_xy_tolerance=0.35), 0.7),
    "laser_likelihood_max_dist": (field_reach, AmclConfig(laser_likelihood_max_dist=0.5), 0.5),
    "resolution": (edge, SlamConfig(resolution=0.1), 0.1),
    "recovery_alpha_fast": (injects, AmclConfig(recovery_alpha_fast=0.5), 0.25),
    "enabled": (sees, {"enabled": False}, False),
    "min_rotate_to_heading_angular_vel": (
        lambda config: driven(RegulatedPurePursuit, config, TURNED).yaw_rate,
        Pursuit(min_rotate_to_heading_angular_vel=0.15), 0.15,
    ),
    "shorter_lookaheads": (
        rounds_a_corner,
        Pursuit(
            shorter_lookaheads=(), lookahead_dist=1.2, rotate_to_heading_min_angle=1.5,
            rotate_instead_min_angle=3.0, max_allowed_time_to_collision_up_to_carrot=5.0,
        ), False,
    ),
    "initial_rotation_tolerance": (
        lambda config: driven(Graceful, config, ASIDE).x > 0.0,
        GracefulConfig(initial_rotation_tolerance=0.3), False,
    ),
    "critic": (lambda config: shown(config) > 0.02, PathFollowConfig(enabled=False), False),
    "required_movement_angle": (
        turning_counts, PoseProgressConfig(required_movement_angle=1.0), False,
    ),
    "max_vel_x": (lambda limit: fastest(max_vel_x=limit, max_speed_xy=1.0), 0.7, 0.7),
    "max_speed_xy": (lambda limit: fastest(max_vel_x=1.0, max_speed_xy=limit), 0.7, 0.7),
    "RotateToGoal.scale": (lambda scale: turned(scale) > 0.0, 0.1, False),
}  # fmt: skip


@pytest.mark.parametrize("name", EFFECTS)
def test_effects(name: str) -> None:
    measure, value, expected = EFFECTS[name]
    assert measure(value) == pytest.approx(expected, abs=0.02)
