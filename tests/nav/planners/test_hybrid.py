"""Hybrid A*: its curves are the shortest, its paths can be driven by a robot with a body."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2, wrap
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import PlanResult, PlanStatus, plan_through
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.hybrid import planner
from arjuna_nav.planners.hybrid.curves import along, length_to, shortest
from arjuna_nav.planners.hybrid.moves import arcs
from arjuna_nav.planners.hybrid.search import search
from tests.helpers.nav.planners import make
from tests.nav.worlds import block, costmap_of, empty_grid, room

RADIUS = 0.4
LONG = np.array([[0.45, 0.15], [-0.25, 0.15], [-0.25, -0.15], [0.45, -0.15]])
POSES = np.random.default_rng(5).uniform((-6, -6, -math.pi), (6, 6, math.pi), (300, 3))
KNOWN = [
    ((2.0, 0.0, 0.0), False, 2.0),
    ((0.0, 2.0, math.pi), False, math.pi),
    ((-1.0, 0.0, 0.0), True, 1.0),
    ((0.0, 0.0, math.pi), True, math.pi),  # three cusps round a third of a circle each
    ((1.0, 1.0, math.pi / 2), True, math.pi / 2),
]
WORDS = ((1, 0, 1), (1, 0, -1), (1, -1, 1), (1, -1, 0, 1), (1, -1, 0, -1), (1, -1, 0, 1, -1))


def length(pose: NDArray[np.float64] | tuple[float, ...], reverse: bool) -> float:
    return float(np.abs(shortest(pose[0], pose[1], pose[2], reverse)[1]).sum())


@pytest.mark.parametrize("reverse", [False, True])
def test_a_curve_ends_at_its_pose(reverse: bool) -> None:
    for pose in POSES:
        curve = shortest(pose[0], pose[1], pose[2], reverse)
        end = along(np.zeros(3), curve, 1.0, 0.3)[-1]
        np.testing.assert_allclose(end[:2], pose[:2], atol=1e-6)
        assert abs(wrap(end[2] - pose[2])) < 1e-6
        assert reverse or curve[1].min() >= 0.0


def test_a_curve_is_as_long_backwards_and_shorter_with_reverse() -> None:
    for pose in POSES:
        back = SE2(*pose).inverse().array()
        assert length(back, True) == pytest.approx(length(pose, True), abs=1e-6)
        assert length(pose, True) <= length(pose, False) + 1e-9
        assert length(pose, True) >= math.hypot(pose[0], pose[1]) - 1e-9


def test_no_curve_is_shorter_than_the_shortest() -> None:
    rng, tight = np.random.default_rng(5), 0
    for word in (*WORDS, *(word[::-1] for word in WORDS)):
        for _ in range(150):
            kinds = np.array(word) * rng.choice([-1.0, 1.0])
            lengths = rng.uniform(-1.6, 1.6, len(word)) + (rng.normal(0.0, 4.0) * (kinds == 0.0))
            if len(word) > 3:  # an arc beside a straight that is not the first or last
                lengths[1] = 0.5 * math.pi * rng.choice([-1.0, 1.0])
            x, y, phi = along(np.zeros(3), np.array([kinds, lengths]), 1.0, 0.3)[-1]
            found, driven = length((x, y, phi), True), float(np.abs(lengths).sum())
            assert found <= driven + 1e-6
            tight += found > driven - 1e-6
    assert tight > 100


@pytest.mark.parametrize(("pose", "reverse", "known"), KNOWN)
def test_known_lengths(pose: tuple[float, ...], reverse: bool, known: float) -> None:
    assert length(pose, reverse) == pytest.approx(known)


@pytest.mark.parametrize("reverse", [False, True])
def test_pieces_end_in_another_cell_at_the_heading_that_they_say(reverse: bool) -> None:
    moves = arcs(0.3, 72, 8.0, reverse, (2.0, 1.2, 0.5), False)
    assert moves.angles[0] == 0.3
    for heading in range(72):
        for k in range(moves.first[heading], moves.first[heading + 1]):
            end = moves.poses[moves.begins[k + 1] - 1]
            turned = wrap(moves.angles[heading] + end[2] - moves.angles[moves.ends[k]])
            assert abs(turned) < 1e-9
            assert np.hypot(end[0], end[1]) >= math.sqrt(2.0)
            back = end[0] * math.cos(moves.angles[heading]) + end[1] * math.sin(
                moves.angles[heading]
            )
            assert reverse or back > 0.0
            assert moves.costs[k] == pytest.approx(
                8.0 * 3 * math.tau / 72 * (2.0 if back < 0.0 else 1.0) * (1.2 if end[2] else 1.0)
            )


def test_a_path_through_a_large_map_is_as_good_as_any() -> None:
    costmap = Costmap(GridFrame(0.05, 300, 300), np.zeros((300, 300), np.uint8))
    for row in range(60, 300, 60):
        costmap.data[row : row + 4] = 254
        costmap.data[row : row + 4, (row * 7) % 240 : (row * 7) % 240 + 40] = 0
    start, goal = SE2(1.0, 1.0, -2.0), SE2(14.0, 14.0, 1.0)
    result = make("smac hybrid", motion_model_for_search="DUBIN").plan(costmap, start, goal)
    shortest_path = make("theta*").plan(costmap, start, goal)
    assert result.status is PlanStatus.SUCCEEDED, result.message
    assert paths.length(result.path) <= 1.08 * paths.length(shortest_path.path)
    assert first_collision(costmap, Footprint.circle(0.25), result.path) is None


@pytest.mark.parametrize("bearing", [4.0, 7.5, 11.0, 20.0])
def test_a_path_between_searched_headings_turns_no_more_than_needed(bearing: float) -> None:
    heading = math.radians(bearing)
    goal = SE2(1.0 + 9.0 * math.cos(heading), 1.0 + 9.0 * math.sin(heading), heading)
    planner = make("smac hybrid", motion_model_for_search="DUBIN")
    result = planner.plan(costmap_of(empty_grid(12.0, 6.0)), SE2(1.0, 1.0), goal)
    assert result.status is PlanStatus.SUCCEEDED, result.message
    assert np.abs(wrap(np.diff(result.path[:, 2]))).sum() < 1.5 * heading
    assert paths.length(result.path) < 9.15


def test_the_higher_costs_weigh_the_farther_it_keeps_away() -> None:
    grid = empty_grid(8.0, 6.0)
    block(grid, 3.5, 2.0, 1.0, 1.2)
    costmap = costmap_of(grid, inflation_radius=1.2)
    away = []
    for penalty in (0.0, 2.0, 5.0, 50.0):
        planner = make("smac hybrid", motion_model_for_search="DUBIN", cost_penalty=penalty)
        result = planner.plan(costmap, SE2(1.0, 2.6), SE2(7.0, 2.6))
        assert result.status is PlanStatus.SUCCEEDED, result.message
        cells = [costmap.cost_at(float(x), float(y)) or 0 for x, y in result.path[:, :2]]
        away.append(max(cells))
    assert away == sorted(away, reverse=True)
    assert away[2] < away[0]


def hybrid(
    grid_or_text: str, start: SE2, goal: SE2, model: str = "DUBIN", origin: SE2 | None = None
) -> tuple[PlanResult, int | None]:
    """Return a plan of the long robot in a world, and the first pose of it that collides."""
    footprint = Footprint.polygon(LONG)
    grid = room() if grid_or_text == "room" else empty_grid(5.0, 3.0, origin or SE2())
    if grid_or_text == "pocket":
        block(grid, 2.0, 0.0, 0.1, 1.2)
        block(grid, 2.0, 1.8, 0.1, 1.2)
        block(grid, 2.0, 1.1, 2.5, 0.1)
        block(grid, 2.0, 1.8, 2.5, 0.1)
        block(grid, 4.5, 1.1, 0.1, 0.8)
    costmap = costmap_of(grid, footprint=str(LONG.tolist()))
    planner = make("smac hybrid", footprint, motion_model_for_search=model)
    at = origin or SE2()
    result = planner.plan(costmap, at @ start, at @ goal)
    hit = first_collision(costmap, footprint, result.path) if len(result.path) else None
    return result, hit


@pytest.mark.parametrize("model", ["DUBIN", "REEDS_SHEPP"])
@pytest.mark.parametrize(
    ("start", "goal"),
    [
        (SE2(0.0, 0.0), SE2(4.0, -4.0, 1.5)),
        (SE2(-4.0, -4.0), SE2(4.0, 4.0, 3.1)),
        (SE2(0.0, 0.0, 2.0), SE2(-0.8, 0.4, -1.0)),
    ],
)
def test_a_path_bends_as_the_robot_can_and_is_free(model: str, start: SE2, goal: SE2) -> None:
    result, hit = hybrid("room", start, goal, model)
    assert result.status is PlanStatus.SUCCEEDED, result.message
    assert hit is None
    path = result.path
    np.testing.assert_allclose(path[0], start.array(), atol=1e-9)
    np.testing.assert_allclose(path[-1], goal.array(), atol=1e-9)
    steps = np.hypot(*np.diff(path[:, :2], axis=0).T)
    turns = np.abs(wrap(np.diff(path[:, 2])))
    assert steps.max() < 0.06
    assert (2.0 * RADIUS * np.sin(turns / 2.0) <= steps + 1e-6).all()
    heading = path[:-1, 2] + 0.5 * wrap(np.diff(path[:, 2]))
    along_it = np.cos(heading) * np.diff(path[:, 0]) + np.sin(heading) * np.diff(path[:, 1])
    np.testing.assert_allclose(np.abs(along_it), steps, atol=1e-6)
    assert model == "REEDS_SHEPP" or along_it.min() >= -1e-9


def test_only_who_drives_back_leaves_a_pocket() -> None:
    inside, outside = SE2(3.8, 1.5), SE2(1.0, 1.5, math.pi)
    assert hybrid("pocket", inside, outside, "DUBIN")[0].status is PlanStatus.NO_VALID_PATH
    result, hit = hybrid("pocket", inside, outside, "REEDS_SHEPP")
    assert result.status is PlanStatus.SUCCEEDED, result.message
    assert hit is None


@pytest.mark.parametrize("name", ["smac hybrid", "smac lattice"])
def test_a_goal_among_costs_above_those_of_direct_curves_is_reached(name: str) -> None:
    costmap, goal = costmap_of(empty_grid(8.0, 6.0)), SE2(6.0, 4.7, 0.6)
    costmap.data[:, 100:] = 220
    result = make(name, max_iterations=5000).plan(costmap, SE2(1.0, 1.0), goal)
    assert result.status is PlanStatus.SUCCEEDED, result.message
    np.testing.assert_allclose(result.path[-1], goal.array(), atol=1e-9)


def test_where_the_outline_touches_at_the_goal_the_path_ends_beside_it() -> None:
    block(grid := empty_grid(8.0, 6.0), 0.0, 5.0, 8.0, 0.2)
    costmap, footprint = costmap_of(grid, footprint=str(LONG.tolist())), Footprint.polygon(LONG)
    start, goal = SE2(2.0, 3.0), SE2(6.0, 4.75, 0.5 * math.pi)  # 0.2 m too near, head on

    def planned(**values: Any) -> PlanResult:
        planner = make("smac hybrid", footprint, max_iterations=5000, **values)
        return planner.plan(costmap, start, goal)

    result = planned()
    assert result.status is PlanStatus.SUCCEEDED, result.message
    assert first_collision(costmap, footprint, result.path) is None
    x, y, heading = result.path[-1]
    assert 0.15 < math.hypot(x - goal.x, y - goal.y) <= 0.25
    assert heading == pytest.approx(goal.theta)
    result = planned(tolerance=0.1)
    assert result.status is PlanStatus.GOAL_OCCUPIED
    assert "with its heading the outline touches something" in result.message


@pytest.mark.parametrize("origin", [SE2(), SE2(-3.0, 2.0, 0.8), SE2(1.0, 1.0, -2.5)])
def test_plans_wherever_the_grid_lies(origin: SE2) -> None:
    result, hit = hybrid("free", SE2(1.0, 1.0), SE2(4.0, 2.0, 1.0), origin=origin)
    assert result.status is PlanStatus.SUCCEEDED, result.message
    assert hit is None
    ahead = origin.inverse() @ SE2.from_array(result.path[-1])
    np.testing.assert_allclose(ahead.array(), (4.0, 2.0, 1.0), atol=1e-9)


@pytest.mark.parametrize(
    "values",
    [
        {"minimum_turning_radius": 0.0},
        {"minimum_turning_radius": 1e-4},
        {"non_straight_penalty": 0.0},
        {"reverse_penalty": 0.0, "motion_model_for_search": "REEDS_SHEPP"},
    ],
)
def test_values_that_nav2_takes_give_a_path(values: dict[str, Any]) -> None:
    result = make("smac hybrid", **values).plan(costmap_of(room()), SE2(-4.0, -4.0), SE2(4.0, 4.0))
    assert result.status is PlanStatus.SUCCEEDED, result.message


def test_the_limit_of_poses_is_reported() -> None:
    planner = make("smac hybrid", max_iterations=3)
    result = planner.plan(costmap_of(room()), SE2(-4.0, -4.0), SE2(4.0, 4.0))
    assert result.status is PlanStatus.TIMEOUT
    assert "max_iterations = 3 poses" in result.message


def test_bends_tighter_than_a_cell_are_driven(monkeypatch: pytest.MonkeyPatch) -> None:
    data = np.full((9, 9), 254, np.uint8)
    data[1:8, 4] = 0  # a corridor a cell wide, and the robot faces its wall
    costmap, start, goal = Costmap(GridFrame(1.0, 9, 9), data), SE2(4.5, 3.5), SE2(4.5, 6.5)
    footprint = Footprint.circle(0.1)
    path = make("smac hybrid", footprint).plan(costmap, start, goal).path
    assert len(path)
    assert first_collision(costmap, footprint, path) is None
    steps, turns = np.hypot(*np.diff(path[:, :2], axis=0).T), np.abs(wrap(np.diff(path[:, 2])))
    assert (2.0 * RADIUS * np.sin(turns / 2.0) <= steps + 1e-6).all()
    wide, looked = make("smac hybrid", footprint, minimum_turning_radius=0.6), []

    def counted(*arguments: Any) -> Any:
        looked.append(search(*arguments))
        return looked[-1]

    monkeypatch.setattr(planner, "search", counted)
    result = wide.plan(costmap, start, goal)
    assert result.status is PlanStatus.NO_VALID_PATH
    assert [more for _, _, _, more in looked] == [int(result.message.split()[-3])], "all is known"


@pytest.mark.parametrize(("reverse", "longer"), [(True, math.pi + 1e-6), (False, 8.4)])
def test_a_length_is_the_curves_and_no_longer_than_is_enough(reverse: bool, longer: float) -> None:
    rng = np.random.default_rng(3)
    for x, y, phi in np.column_stack((rng.normal(0.0, 3.0, (300, 2)), rng.uniform(-4, 4, 300))):
        length = float(np.abs(shortest(x, y, phi, reverse)[1]).sum())
        assert length <= math.hypot(x, y) + longer
        assert length_to(x, y, phi, reverse, 0.0) == pytest.approx(length)
        assert length_to(x, y, phi, reverse, 0.9 * length) == pytest.approx(length)
        assert length <= length_to(x, y, phi, reverse, 1.3 * length) + 1e-9 <= 1.3 * length + 1e-6


@pytest.mark.parametrize("axle", [-0.5, -0.2, 0.3])
def test_a_path_of_a_base_off_its_axle_bends_as_the_axle_can(axle: float) -> None:
    outline = Footprint.polygon(LONG + np.array([axle, 0.0])).driven_at(axle)
    costmap = costmap_of(room(), radius=outline.inscribed_radius)
    start, *stops = SE2(1.0, 1.0, 0.3), SE2(3.0, 2.8, -2.0), SE2(1.0, -1.0, 1.0)
    found = plan_through(make("smac hybrid", outline.of_axle), costmap, start, stops, outline)
    assert found.status is PlanStatus.SUCCEEDED
    assert SE2.from_array(found.path[0]).distance(start) < 1e-6
    assert SE2.from_array(found.path[-1]).distance(stops[-1]) < 1e-6
    assert first_collision(costmap, outline, found.path) is None
    path = paths.shifted(found.path, axle)
    steps, turns = np.hypot(*np.diff(path[:, :2], axis=0).T), np.abs(wrap(np.diff(path[:, 2])))
    assert (2.0 * RADIUS * np.sin(turns / 2.0) <= steps + 1e-3).all()
