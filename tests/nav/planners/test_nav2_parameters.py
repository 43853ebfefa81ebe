"""Nav2's parameters of planners: each row fails where the parameter has its default."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2, wrap
from arjuna_nav.costmap import Costmap
from arjuna_nav.planners import Planner, PlanResult, PlanStatus, guide, smac_2d, theta_star
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.hybrid import planner as pose_search
from arjuna_nav.planners.hybrid import search
from tests.helpers.nav.planners import make

Check = Callable[[Planner, pytest.MonkeyPatch], None]
FREE = Costmap(GridFrame(0.05, 160, 120), np.zeros((120, 160), np.uint8))
START, GOAL = SE2(1.02, 3.02), SE2(7.02, 3.02)
POSE_PLANNERS = ("smac hybrid", "smac lattice")


def changed(rows: slice, columns: slice, cost: int) -> Costmap:
    """Return the free costmap with one cost in a window."""
    data = FREE.data.copy()
    data[rows, columns] = cost
    return Costmap(FREE.frame, data)


def planned(planner: Planner, costmap: Costmap = FREE, goal: SE2 = GOAL) -> PlanResult:
    result = planner.plan(costmap, START, goal)
    assert result.status is PlanStatus.SUCCEEDED, result.message
    return result


def ends_within_the_tolerance(planner: Planner, _: pytest.MonkeyPatch) -> None:
    end = SE2.from_array(planned(planner).path[-1])
    assert 0.01 < end.distance(GOAL) <= 0.5


def looks_at_the_flag(planner: Planner, patch: pytest.MonkeyPatch) -> None:
    """Check that a search ends early by a flag that only its kernel sees."""
    path = planned(planner).path
    for module in (smac_2d, theta_star, search):
        patch.setattr(module, "stop_flag", lambda: np.ones(1, np.bool_))
    try:
        found = planner.plan(FREE, START, GOAL).path
    except KeyError:  # Theta*'s path leads nowhere then
        return
    assert not np.array_equal(found, path)


def gap_is_closed(planner: Planner, _: pytest.MonkeyPatch) -> None:
    gap = changed(slice(None), slice(80, 82), 254)
    gap.data[62:65] = 0
    assert planner.plan(gap, START, GOAL).status is PlanStatus.NO_VALID_PATH


def bends_less(planner: Planner, _: pytest.MonkeyPatch) -> None:
    """Check a path round a corner against that of the same search, not smoothed."""
    corner = changed(slice(0, 80), slice(70, 90), 254)
    smooth = planned(planner, corner).path
    plain = planned(make("smac hybrid"), corner).path
    assert len(smooth) == len(plain)
    assert bends(smooth) < 0.999 * bends(plain)
    assert np.array_equal(smooth[[0, -1]], plain[[0, -1]])
    steps = np.diff(smooth[:, :2], axis=0)
    off = wrap(np.arctan2(steps[:, 1], steps[:, 0]) - smooth[:-1, 2])
    assert np.minimum(np.abs(off), math.pi - np.abs(off)).max() < 0.2


def is_the_plain_path(planner: Planner, _: pytest.MonkeyPatch) -> None:
    corner = changed(slice(0, 80), slice(70, 90), 254)
    plain = planned(make("smac hybrid"), corner).path
    np.testing.assert_allclose(planned(planner, corner).path[:, :2], plain[:, :2], atol=1e-9)


def bends(path: NDArray[np.float64]) -> float:
    return float((np.diff(path[:, :2], 2, axis=0) ** 2).sum())


def crosses_the_costly_band(planner: Planner, _: pytest.MonkeyPatch) -> None:
    """Check that a straight through half the greatest cost is preferred to a detour of 40 %."""
    band = changed(slice(20, 100), slice(40, 120), 126)
    assert paths.length(planned(planner, band).path) < 6.1


def ends_behind_high_costs(planner: Planner, _: pytest.MonkeyPatch) -> None:
    """Check that costs may be high about a goal that costs little, not only at it."""
    costly, goal = changed(slice(None), slice(100, None), 220), SE2(GOAL.x, GOAL.y, 1.0)
    costly.data[FREE.frame.to_cell(goal.x, goal.y)] = 0
    assert planned(planner, costly, goal).path[-1].tolist() == list(goal.array())


def bends_by_single_headings(planner: Planner, _: pytest.MonkeyPatch) -> None:
    expansions = planned(planner, goal=SE2(3.0, 4.5, 1.5)).expansions
    assert expansions is not None
    steps = np.round(np.rad2deg(expansions[:, 2])) % 15
    assert (steps == 5).any()


def counted(patch: pytest.MonkeyPatch, module: Any, name: str) -> list[tuple[Any, ...]]:
    """Return a list that grows with the arguments of each call of a function."""
    calls: list[tuple[Any, ...]] = []
    real = getattr(module, name)

    def call(*arguments: Any, **named: Any) -> Any:
        calls.append(arguments)
        return real(*arguments, **named)

    patch.setattr(module, name, call)
    return calls


def estimates_once(planner: Planner, patch: pytest.MonkeyPatch) -> None:
    calls = counted(patch, pose_search, "guide")
    first, again = planned(planner), planned(planner)
    assert len(calls) == 1
    assert np.array_equal(first.path, again.path)
    planned(planner, goal=SE2(6.0, 4.0))
    assert len(calls) == 2, "another goal"


def estimates_on_large_cells(planner: Planner, patch: pytest.MonkeyPatch) -> None:
    calls = counted(patch, guide, "wavefront")
    planned(planner)
    assert [call[0].shape for call in calls] == [(60, 80)]


def expands_more(planner: Planner, _: pytest.MonkeyPatch) -> None:
    beside = SE2(3.0, 4.0, math.pi)
    shown = make("smac hybrid", **{**SHORT_CURVES, "lookup_table_size": 1000.0})
    few, many = (planned(one, goal=beside).expansions for one in (shown, planner))
    assert few is not None
    assert many is not None
    assert len(many) > 1.2 * len(few)


def ends_turned_round(planner: Planner, _: pytest.MonkeyPatch) -> None:
    path = planned(planner, goal=SE2(7.02, 3.02, math.pi)).path
    assert abs(wrap(path[-1, 2])) < 1e-6
    assert paths.length(path) == pytest.approx(6.0, abs=0.01)


def ends_with_any_heading(planner: Planner, _: pytest.MonkeyPatch) -> None:
    path = planned(planner, goal=SE2(7.02, 3.02, 1.5)).path
    assert abs(wrap(path[-1, 2] - 1.5)) > 0.5
    assert paths.length(path) < 6.05


def tries_only_the_first_heading(planner: Planner, _: pytest.MonkeyPatch) -> None:
    """Check that a dead end that faces its entrance cannot be entered, as by the default."""
    dead_end = changed(slice(0, 54), slice(100, None), 254)
    dead_end.data[67:, 100:] = 254
    facing_out = SE2(7.02, 3.02, math.pi)
    assert planner.plan(dead_end, START, facing_out).status is not PlanStatus.SUCCEEDED
    many = make("smac hybrid", **{**DEAD_END, "coarse_search_resolution": 1})
    assert many.plan(dead_end, START, facing_out).status is PlanStatus.SUCCEEDED


def keeps_expansions(planner: Planner, _: pytest.MonkeyPatch) -> None:
    expansions = planned(planner).expansions
    assert expansions is not None
    near_start = np.hypot(expansions[:, 0] - START.x, expansions[:, 1] - START.y)
    assert near_start.min() < 1e-6


DEAD_END: dict[str, Any] = {
    "motion_model_for_search": "DUBIN",
    "goal_heading_mode": "ALL_DIRECTION",
    "max_iterations": 4000,
}
SHORT_CURVES: dict[str, Any] = {
    "motion_model_for_search": "DUBIN",
    "debug_visualizations": True,
    "analytic_expansion_max_length": 0.8,
}
ROWS: list[tuple[str, str, dict[str, Any], Check]] = [
    (
        "smac 2d",
        "max_on_approach_iterations",
        {"tolerance": 0.5, "max_on_approach_iterations": 3},
        ends_within_the_tolerance,
    ),
    *(
        (
            name,
            "max_on_approach_iterations",
            {
                "tolerance": 0.5,
                "max_on_approach_iterations": 3,
                "analytic_expansion_max_length": 0.0,
                "max_iterations": 4000,
            },
            ends_within_the_tolerance,
        )
        for name in POSE_PLANNERS
    ),
    *(
        (name, "terminal_checking_interval", {"terminal_checking_interval": 1}, looks_at_the_flag)
        for name in ("theta*", "smac 2d", *POSE_PLANNERS)
    ),
    *(
        (name, key, {"downsample_costmap": True, "downsampling_factor": 4}, gap_is_closed)
        for name in ("smac 2d", "smac hybrid")
        for key in ("downsample_costmap", "downsampling_factor")
    ),
    ("smac hybrid", "smooth_path", {"smooth_path": True}, bends_less),
    (
        "smac hybrid",
        "smoother.w_smooth",
        {"smooth_path": True, "smoother.w_smooth": 0.0},
        is_the_plain_path,
    ),
    (
        "smac hybrid",
        "use_quadratic_cost_penalty",
        {"use_quadratic_cost_penalty": True},
        crosses_the_costly_band,
    ),
    *(
        (
            name,
            "analytic_expansion_max_cost_override",
            {"analytic_expansion_max_cost_override": True, "max_iterations": 60},
            ends_behind_high_costs,
        )
        for name in POSE_PLANNERS
    ),
    (
        "smac hybrid",
        "allow_primitive_interpolation",
        {**SHORT_CURVES, "allow_primitive_interpolation": True},
        bends_by_single_headings,
    ),
    *(
        (name, "cache_obstacle_heuristic", {"cache_obstacle_heuristic": True}, estimates_once)
        for name in POSE_PLANNERS
    ),
    (
        "smac hybrid",
        "downsample_obstacle_heuristic",
        {"downsample_obstacle_heuristic": True},
        estimates_on_large_cells,
    ),
    ("smac hybrid", "lookup_table_size", {**SHORT_CURVES, "lookup_table_size": 0.0}, expands_more),
    (
        "smac hybrid",
        "goal_heading_mode",
        {"goal_heading_mode": "BIDIRECTIONAL", "motion_model_for_search": "DUBIN"},
        ends_turned_round,
    ),
    (
        "smac hybrid",
        "goal_heading_mode",
        {"goal_heading_mode": "ALL_DIRECTION"},
        ends_with_any_heading,
    ),
    (
        "smac hybrid",
        "coarse_search_resolution",
        {**DEAD_END, "coarse_search_resolution": 72},
        tries_only_the_first_heading,
    ),
    *(
        (name, "debug_visualizations", {"debug_visualizations": True}, keeps_expansions)
        for name in POSE_PLANNERS
    ),
]
"""Planner, parameter, the values that it is made with, and what these do."""


@pytest.mark.parametrize(
    ("name", "parameter", "values", "check"), ROWS, ids=[f"{row[0]}-{row[1]}" for row in ROWS]
)
def test_a_parameter_has_its_effect(
    name: str,
    parameter: str,
    values: dict[str, Any],
    check: Check,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    check(make(name, **values), monkeypatch)
    monkeypatch.undo()
    forced = {key: value for key, value in values.items() if key != parameter}
    with pytest.raises(AssertionError):
        check(make(name, **forced), monkeypatch)
