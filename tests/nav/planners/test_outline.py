"""Paths of the outline: found where a circle's path cannot be followed, free all along, or none."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import collides, first_collision
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import PlanResult, PlanStatus, plan_through
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.escape import lead_out
from arjuna_nav.planners.outline import (
    Drive,
    find_path,
    first_blocked,
    path_cost,
    plan_for_outline,
    relaxed_inscribed,
)
from tests.helpers.nav.planners import make
from tests.nav.worlds import block, costmap_of, empty_grid, grid_of, polyline

CORNERS = np.array([[0.3, 0.15], [-0.3, 0.15], [-0.3, -0.15], [0.3, -0.15]])
LONG = Footprint.polygon(CORNERS)
DRIVE = Drive(turn=0.3, reversal=0.1, back=2.0, limit=60000)
ORIGINS = [SE2(), SE2(-4.0, 7.0, 0.6)]


def costs(grid: OccupancyGrid) -> Costmap:
    return costmap_of(grid, footprint=str(CORNERS.tolist()))


def corridor(origin: SE2, width: float = 0.45) -> OccupancyGrid:
    """Return a corridor along x, closed at its far end, in a grid at an origin."""
    grid = empty_grid(4.0, 3.0, origin)
    block(grid, 1.0, 0.0, 3.0, 1.5 - width / 2.0)
    block(grid, 1.0, 1.5 + width / 2.0, 3.0, 1.5 - width / 2.0)
    block(grid, 3.5, 0.0, 0.5, 3.0)
    return grid


def is_driven_straight(path: NDArray[np.float64]) -> bool:
    """Return whether each pose lies where the one before can drive: nowhere it slides sideways."""
    steps, middle = np.diff(path[:, :2], axis=0), 0.5 * (path[1:, 2] + path[:-1, 2])
    across = steps[:, 1] * np.cos(middle) - steps[:, 0] * np.sin(middle)
    return bool(np.abs(across).max() < 0.01)


@pytest.mark.parametrize("origin", ORIGINS)
def test_a_dead_end_too_narrow_to_turn_in_is_left_backwards(origin: SE2) -> None:
    costmap = costs(corridor(origin))
    start, end = origin @ SE2(3.0, 1.5, 0.0), origin @ SE2(0.5, 2.2, math.pi / 2.0)
    path = find_path(start, end, costmap, LONG, DRIVE)
    assert first_collision(costmap, LONG, path) is None
    assert is_driven_straight(path)
    np.testing.assert_allclose(path[0], start.array(), atol=1e-9)
    assert SE2.from_array(path[-1]).distance(end) < 1e-6
    inside = (origin.inverse().apply(path[:, :2])[:, 0] > 1.5).nonzero()[0]
    assert abs(path[inside, 2] - start.theta).max() < 0.2, "it turned in the corridor"


@pytest.mark.parametrize("back", [0.08, 0.12, 0.4])
def test_a_short_stretch_is_driven_back_rather_than_by_two_half_turns(back: float) -> None:
    costmap = costs(empty_grid(4.0, 3.0))
    path = find_path(SE2(2.0, 1.5, 0.3), SE2(2.0, 1.5, 0.3) @ SE2(-back), costmap, LONG, DRIVE)
    assert np.abs(path[:, 2] - 0.3).max() < 1e-6
    assert path_cost(path, DRIVE) == pytest.approx(2.0 * back, abs=0.01)


def test_there_is_no_path_through_what_is_too_narrow() -> None:
    costmap = costs(corridor(SE2(), width=0.2))
    path = find_path(SE2(0.5, 1.5, 0.0), SE2(3.0, 1.5, 0.0), costmap, LONG, DRIVE)
    assert path.shape == (0, 3)
    for start, end in ((SE2(0.5, 1.5), SE2(9.0, 1.5)), (SE2(9.0, 1.5), SE2(0.5, 1.5))):
        assert find_path(start, end, costmap, LONG, DRIVE).shape == (0, 3)


def test_what_collides_already_is_left_away_from_the_obstacle() -> None:
    costmap, start = costs(grid_of(4.0, 3.0, (2.25, 1.0, 0.3, 1.0))), SE2(2.0, 1.5, 0.0)
    assert first_collision(costmap, LONG, start.array()[None, :]) == 0
    path = find_path(start, SE2(1.0, 1.5, math.pi), costmap, LONG, DRIVE)
    assert len(path) > 1
    assert first_collision(costmap, LONG, path) is None


@pytest.mark.parametrize("radius", [0.4, 0.9])
def test_a_steered_drive_never_turns_on_the_spot(radius: float) -> None:
    costmap, steered = costs(corridor(SE2())), DRIVE._replace(radius=radius, direct=3.0)
    path = find_path(SE2(3.0, 1.5), SE2(0.5, 2.2, math.pi / 2.0), costmap, LONG, steered)
    assert first_collision(costmap, LONG, path) is None
    steps = np.hypot(*np.diff(path[:, :2], axis=0).T)
    assert steps.min() > 0.0
    turns = np.abs((np.diff(path[:, 2]) + math.pi) % (2.0 * math.pi) - math.pi)
    assert (turns <= 1.02 * steps / radius + 1e-6).all()
    assert is_driven_straight(path)


@pytest.mark.parametrize(("radius", "leaves"), [(0.0, False), (0.4, True)])
def test_a_steered_drive_leaves_what_it_touches_in_a_bend_too(radius: float, leaves: bool) -> None:
    grid = grid_of(4.0, 3.0, (0.0, 1.65, 4.0, 0.1), (2.35, 1.0, 0.1, 0.7), (1.55, 1.3, 0.1, 0.4))
    pose = SE2(2.0, 1.5, 0.05)
    poses = lead_out(pose, costs(grid), LONG, radius)
    assert (len(poses) > 1) is leaves
    assert collides(costs(grid), LONG, pose)
    assert collides(costs(grid), LONG, SE2.from_array(poses[-1])) is not leaves


class Reverser:
    """A planner whose path is driven back, its outline known to be free."""

    checks_outline = True

    def plan(self, costmap: Costmap, start: SE2, goal: SE2) -> PlanResult:
        path = polyline([(start.x, start.y), (goal.x, goal.y)], 0.0)
        path[:, 2] = start.theta
        return PlanResult(PlanStatus.SUCCEEDED, path)


def test_a_planner_that_checks_the_outline_is_not_corrected() -> None:
    # Turned round, as though it drove ahead, the outline would touch the wall.
    front = Footprint.polygon(np.array([[0.5, 0.1], [-0.1, 0.1], [-0.1, -0.1], [0.5, -0.1]]))
    grid = grid_of(4.0, 3.0, (0.5, 0.0, 0.1, 3.0))
    costmap = costmap_of(grid, footprint=str(front.points.tolist()))
    start, goal = SE2(2.0, 1.5), SE2(0.75, 1.5)
    plan = plan_for_outline(Reverser(), costmap, start, goal, front)
    assert (plan.path[:, 2] == 0.0).all()


def test_a_path_of_a_long_outline_is_searched_quickly() -> None:
    """Once it has left its start, its distance from obstacles is not searched."""
    tail = np.array([[0.5, 0.2], [-15.0, 0.2], [-15.0, -0.2], [0.5, -0.2]])
    grid = empty_grid(30.0, 30.0)
    for k in range(0, 30, 2):
        block(grid, float(k), float(k), 0.1, 0.1)
    costmap, outline = costmap_of(grid, footprint=str(tail.tolist())), Footprint.polygon(tail)
    find_path(SE2(1.0, 5.0, 0.0), SE2(2.0, 5.0, 0.0), costmap, LONG, DRIVE)  # compiles
    started = time.process_time()
    find_path(SE2(1.0, 1.0, 0.0), SE2(2.0, 1.5, 0.0), costmap, outline, DRIVE)
    assert time.process_time() - started < 10.0


def staircase() -> OccupancyGrid:
    """Return a wall with two gaps: before the near one stands a second wall, so that only a circle
    gets through; the far one is wide."""
    return grid_of(6.0, 10.0, (2.5, 0.0, 0.2, 2.3), (2.5, 2.7, 0.2, 6.3), (3.1, 1.6, 0.2, 1.8))


def test_a_circles_path_is_replaced_by_one_of_the_outline() -> None:
    costmap, start, goal = costs(staircase()), SE2(1.0, 2.5), SE2(5.0, 2.5)
    planner = make("navfn", LONG)
    circle = plan_through(planner, costmap, start, [goal])
    outline = plan_through(planner, costmap, start, [goal], LONG)
    assert outline.status is PlanStatus.SUCCEEDED
    assert first_collision(costmap, LONG, circle.path) is not None
    assert first_collision(costmap, LONG, outline.path) is None
    assert paths.length(outline.path) > paths.length(circle.path) + 0.5
    np.testing.assert_allclose(outline.path[-1], goal.array(), atol=1e-9)
    own = plan_through(planner, costmap, start, [goal], LONG, fits=False)
    np.testing.assert_array_equal(own.path, circle.path)


@pytest.mark.parametrize("width", [0.5, 0.32])
def test_the_planners_own_path_is_kept_where_it_will_do_or_nothing_else_does(width: float) -> None:
    costmap, planner = costs(corridor(SE2(), width)), make("navfn", LONG)
    start, goal = SE2(0.5, 2.0), SE2(3.0, 1.5)
    own, kept = (plan_through(planner, costmap, start, [goal], f) for f in (None, LONG))
    if width == 0.5:
        np.testing.assert_array_equal(kept.path, own.path)
    assert kept.status is own.status


THROUGH = polyline([(0.5, 1.5), (3.0, 1.5)], 0.0)
NONE = PlanResult.failed(PlanStatus.NO_VALID_PATH, "no path")
FOUND = PlanResult(PlanStatus.SUCCEEDED, THROUGH)


class Planned:
    """A planner that answers what the test says, and keeps the costs that it was asked with."""

    def __init__(self, *answers: PlanResult) -> None:
        self.answers = list(answers)
        self.costs: list[NDArray[np.uint8]] = []

    def plan(self, costmap: Costmap, start: SE2, goal: SE2) -> PlanResult:
        self.costs.append(costmap.data.copy())
        return self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]


def plan_by(planner: Planned, costmap: Costmap, footprint: Footprint = LONG) -> PlanResult:
    return plan_for_outline(planner, costmap, SE2(0.5, 1.5), SE2(3.0, 1.5), footprint)


def test_where_the_outline_has_no_path_its_position_is_closed_and_another_asked_for() -> None:
    costmap, planner = costs(corridor(SE2(), width=0.2)), Planned(FOUND)
    before = costmap.data.copy()
    assert plan_by(planner, costmap) is FOUND, "nothing else does"
    np.testing.assert_array_equal(costmap.data, before, "the planner's own costs are")
    assert len(planner.costs) == 1 + 6
    blocked = first_blocked(THROUGH, costmap, LONG)
    assert blocked is not None
    row, column = costmap.frame.to_cell(float(blocked[0]), float(blocked[1]))
    rows, columns = np.ogrid[: costmap.data.shape[0], : costmap.data.shape[1]]
    disc = (rows - row) ** 2 + (columns - column) ** 2 <= 9  # 3 cells
    closed = np.where(disc & (before < 253), 253, before)
    for later in planner.costs[1:]:
        np.testing.assert_array_equal(later, closed)


def test_another_path_that_the_outline_can_follow_is_taken() -> None:
    costmap = costs(corridor(SE2(), width=0.2))
    beside = PlanResult(PlanStatus.SUCCEEDED, polyline([(0.4, 0.5), (0.4, 2.5)], 1.5))
    planner = Planned(FOUND, FOUND, beside)
    assert plan_by(planner, costmap) is beside
    assert len(planner.costs) == 3
    planner = Planned(FOUND, NONE)
    assert plan_by(planner, costmap) is FOUND
    assert len(planner.costs) == 2


@pytest.mark.parametrize(("answers", "asked"), [((NONE, FOUND), 2), ((NONE, NONE, FOUND), 3)])
def test_gaps_closed_by_cells_are_opened(answers: tuple[PlanResult, ...], asked: int) -> None:
    costmap, planner = costs(corridor(SE2(), width=0.3)), Planned(*answers)
    assert plan_by(planner, costmap) is FOUND
    radius = 0.15 / 0.05
    expected = [
        costmap.data,
        relaxed_inscribed(costmap.data, radius - 0.5),
        relaxed_inscribed(costmap.data, radius - 1.1),
    ]
    assert len(planner.costs) == asked
    for given, own in zip(planner.costs, expected, strict=False):
        np.testing.assert_array_equal(given, own)
    assert plan_by(Planned(NONE), costmap) is NONE


def test_relaxed_costs_are_the_highest_beyond_the_radius_of_what_is_lethal() -> None:
    data = np.full((9, 9), 253, np.uint8)
    data[4, 4], data[0, 0], data[8, 8] = 254, 17, 255
    rows, columns = np.ogrid[:9, :9]
    for radius in (1.0, 2.0, 2.3, 3.2):
        near = np.hypot(rows - 4, columns - 4) <= radius
        expected = np.where(near | (data != 253), data, 252)
        np.testing.assert_array_equal(relaxed_inscribed(data, radius), expected)


def test_a_circle_and_what_fails_otherwise_keep_the_planners_own() -> None:
    costmap = costs(corridor(SE2(), width=0.2))
    failed = PlanResult.failed(PlanStatus.TIMEOUT, "too long")
    for answer, footprint in ((FOUND, Footprint.circle(0.15)), (failed, LONG)):
        planner = Planned(answer)
        assert plan_by(planner, costmap, footprint) is answer
        assert len(planner.costs) == 1
