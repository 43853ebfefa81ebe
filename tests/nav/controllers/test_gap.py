"""Gaps hardly wider than the robot, lined up on what the scans have hit and driven through."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from arjuna_nav.controllers.escape import Escape, EscapeConfig
from arjuna_nav.controllers.gap import (
    Gap,
    find_gap,
    first_contact,
    seen_again,
    steered_onto,
    widest_strip,
)
from arjuna_nav.controllers.tracker import TrackerConfig
from arjuna_nav.costmap import Costmap, LayeredCostmap, PlacedScan
from arjuna_nav.costmap.footprint import Footprint
from bringup.scenarios.doors import Door
from tests.helpers.nav.layers import Body, costmap_config, see
from tests.helpers.nav.played import Play
from tests.nav.worlds import block, costmap_of, empty_grid, polyline

ROBOT = Body.box(0.45, 0.38)
START = SE2(1.5, 2.0)
PATH = polyline([(1.5, 2.0), (2.6, 2.0), (2.6, 3.6)], 0.0)


def sides(width: float, length: float = 0.2) -> NDArray[np.float64]:
    """Return the points of two jambs left and right of the x axis."""
    along = np.linspace(-length / 2.0, length / 2.0, 9)
    jamb = np.column_stack((along, np.full(9, width / 2.0)))
    return np.vstack((jamb, jamb * (1.0, -1.0)))


@pytest.mark.parametrize("at", [SE2(), SE2(0.05, 0.1, 0.3), SE2(-0.05, -0.12, -0.5)])
def test_the_widest_strip_lies_in_the_middle_of_a_gap(at: SE2) -> None:
    found = widest_strip(at.inverse().apply(sides(0.45)), (-0.3, 0.3), 0.25, 0.8)
    assert found is not None
    line, width = at @ found[0], found[1]
    assert abs(line.y) < 0.01
    assert abs(line.theta) < 0.02
    assert width == pytest.approx(0.45, abs=0.01)


def test_there_is_no_strip_beside_one_wall() -> None:
    assert widest_strip(sides(0.45)[:9], (-0.3, 0.3), 0.25, 0.8) is None


def test_a_narrow_gap_is_found_on_the_path_and_followed_as_it_is_seen() -> None:
    at = SE2(2.0, 1.0, 0.4)
    points = at.apply(sides(0.45))
    path = polyline([(1.0, 0.6), (3.0, 1.5)], 0.0)
    gap = find_gap(path, points, 0.19, 0.15)
    assert gap is not None
    assert gap.width == pytest.approx(0.45, abs=0.01)
    seen = at.inverse() @ gap.line
    assert (abs(seen.y) < 0.01, abs(seen.theta) < 0.03) == (True, True)
    assert (gap.first + seen.x, gap.last + seen.x) == pytest.approx((-0.1, 0.1), abs=0.02)
    assert find_gap(path, points, 0.23, 0.15) is None, "too narrow"
    assert find_gap(path, points, 0.05, 0.1) is None, "there is room"
    assert find_gap(path, points[:0], 0.19, 0.15) is None
    moved = SE2(0.0, 0.02) @ at
    lines = [gap]
    for _ in range(20):
        lines.append(seen_again(lines[-1], moved.apply(sides(0.45)), (-0.3, 0.3)))
    off = [abs((moved.inverse() @ line.line).y) for line in lines]
    assert off[0] > 0.01
    assert off[1] == pytest.approx(0.7 * off[0], abs=0.005)
    assert off[-1] < 0.005
    assert seen_again(gap, moved.apply(sides(0.45)[:9]), (-0.3, 0.3)) == gap


@pytest.mark.parametrize("aside", [0.2, -0.1])
def test_a_robot_is_steered_onto_the_line_by_pure_pursuit(aside: float) -> None:
    poses = steered_onto(np.array([-1.0, aside, 0.3]), 0.2, 4.0, 0.5, 0.02)
    np.testing.assert_allclose(poses[0], (-1.0, aside, 0.3))
    assert abs(poses[-1, 1]) < 0.005
    assert poses[-1, 0] == pytest.approx(0.5, abs=0.02)
    steps = np.diff(poses, axis=0)
    assert np.hypot(steps[:, 0], steps[:, 1]) == pytest.approx(0.02)
    assert np.abs(steps[:, 2]).max() <= 4.0 * 0.02 + 1e-9
    middle = 0.5 * (poses[1:, 2] + poses[:-1, 2])
    np.testing.assert_allclose(np.arctan2(steps[:, 1], steps[:, 0]), middle, atol=1e-9)


def test_a_motion_ends_where_the_outline_meets_a_point() -> None:
    poses = np.column_stack((np.arange(-0.5, 0.5, 0.01), np.zeros(100), np.zeros(100)))
    assert first_contact(poses, sides(0.45), ROBOT.corners) == 100
    hit = first_contact(poses, sides(0.36), ROBOT.corners)
    assert poses[hit, 0] == pytest.approx(-0.1 - 0.225, abs=0.011)


def test_obstacles_lie_where_scans_hit_and_in_the_middle_of_a_maps_cells() -> None:
    config = costmap_config(
        width=4, height=4, resolution=0.1, plugins=("obstacle_layer", "inflation_layer")
    )
    layered = LayeredCostmap(config)
    for noise in (0.01, -0.01, 0.01, -0.01, 0.01, -0.01):
        scan = Scan(np.array([1.03 + noise]), 0.0, 0.1, 0.1, 10.0)
        see(layered, SE2(1.0, 2.02), 0.0, [PlacedScan(scan, SE2(1.0, 2.02))])
    (point,) = layered.costmap.obstacles(2.0, 2.0, 0.3)
    assert point == pytest.approx((2.03, 2.02), abs=0.005)
    grid = empty_grid(4.0, 4.0, SE2(1.0, 0.0, math.pi / 2.0), 0.1)
    grid.data[20, 10] = 100
    (point,) = costmap_of(grid).obstacles(-1.0, 1.0, 0.3)
    assert point == pytest.approx((1.0 - 2.05, 1.05), abs=1e-9)


@pytest.mark.parametrize(("seed", "has_map"), [(1, True), (2, False)])
def test_passes_a_door_seven_centimetres_wider_than_it(seed: int, has_map: bool) -> None:
    door = Door.draw(0.45, np.random.default_rng(seed))
    rng, grid = np.random.default_rng(seed), door.map() if has_map else None
    drive = Play(door.edges(), grid, door.start, door.goal, ROBOT, rng).run()
    assert not drive.touched
    assert drive.arrived, drive.why
    assert door.is_through(drive.robot.pose)


def test_leaves_a_door_alone_that_is_too_narrow() -> None:
    door = Door.draw(0.36, np.random.default_rng(1))
    rng = np.random.default_rng(1)
    drive = Play(door.edges(), None, door.start, door.goal, ROBOT, rng).run(12.0)
    assert not drive.touched
    assert not drive.arrived


OUTLINE = Footprint.polygon(ROBOT.corners)


def escape_at_gap(
    *beyond: tuple[float, float, float, float],
    start: SE2 = START,
    found: bool = True,
    **values: Any,
) -> tuple[Escape, Costmap]:
    """Return an escape started before a gap, behind which blocks stand, `x, y, width, height`."""
    grid = empty_grid(5.0, 4.0)
    for one in ((2.0, 0.0, 0.2, 1.75), (2.0, 2.25, 0.2, 1.75), *beyond):
        block(grid, *one)
    costmap = costmap_of(grid, footprint=str(ROBOT.corners.tolist()))
    escape = Escape(EscapeConfig(**values), TrackerConfig(), OUTLINE, OUTLINE)
    assert escape.begin(start, PATH, costmap) or not found
    assert escape.in_gap is found
    return escape, costmap


@pytest.mark.parametrize("values", [{"gap_reach": 0.1}, {"gap_margin": 0.3}])
def test_a_gap_is_used_that_is_near_and_leaves_the_margin(values: dict[str, Any]) -> None:
    escape_at_gap(found=False, **values)


def drive(
    escape: Escape, costmap: Costmap, until: Callable[[SE2], bool], start: SE2 = START
) -> SE2:
    """Return where a robot comes that drives exactly what is commanded."""
    pose, now = start, 0.0
    while escape.active and not until(pose) and now < 30.0:
        command, now = escape.compute(pose, STILL, PATH, costmap, now), now + 0.05
        if command is not None:
            pose = pose @ SE2.exp((0.05 * command.x, 0.0, 0.05 * command.yaw_rate))
    return pose


def test_a_controller_takes_over_once_the_gap_is_behind() -> None:
    escape, costmap = escape_at_gap((2.2, 1.65, 1.6, 0.1))  # a wall beside what follows
    end = drive(escape, costmap, lambda pose: escape.can_hand_over(pose, PATH, costmap))
    assert escape.active
    assert 2.0 < end.x < 2.7


def test_does_not_return_to_a_gap_that_it_is_through() -> None:
    escape, costmap = escape_at_gap((2.95, 1.6, 0.2, 0.8))
    end = drive(escape, costmap, lambda pose: pose.x > 2.5 and abs(pose.theta) > 0.5)
    assert not escape.active
    assert end.x > 2.4
    assert abs(end.theta) < 0.5


@pytest.mark.parametrize("start", [SE2(1.5, 1.95, -0.1), SE2(1.55, 2.0, 0.1)])
def test_steers_onto_the_line_instead_of_turning_to_line_up(start: SE2) -> None:
    escape, costmap = escape_at_gap(start=start)
    end = drive(escape, costmap, lambda pose: pose.x > 2.2 or abs(pose.theta) > 0.4, start)
    assert end.x > 2.2


def test_a_gap_is_driven_more_slowly_the_less_room_it_leaves() -> None:
    speeds = []
    for width in (0.41, 0.5, 0.6):
        escape = escape_at_gap()[0]
        escape._gap = Gap(SE2(2.1, 2.0), width, -0.1, 0.1)
        speeds.append(escape._speed)
    assert speeds == sorted(speeds)
    assert (speeds[0], speeds[-1]) == (0.15, 0.3)
