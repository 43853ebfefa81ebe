"""Each row: a parameter, a value that is not its default, and what the controller then does."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from arjuna_core.errors import ConfigError
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers import ControlResult, ControlStatus
from arjuna_nav.controllers.display import shown_by, topics_of, want
from arjuna_nav.costmap.footprint import Footprint
from tests.helpers.nav.controllers import PARAMETERS, V_MAX, W_MAX, make
from tests.nav.worlds import block, costmap_of, empty_grid, grid_of, polyline

POSE = SE2(2.0, 3.0)
PATH = polyline([(1.0, 3.0), (5.0, 3.0)], 0.0)
AWAY = polyline([(2.0, 3.0), (0.0, 3.0)], math.pi)
FREE = costmap_of(empty_grid(6.0, 6.0))
LONG = Footprint.polygon(np.array([(0.5, 0.05), (-0.5, 0.05), (-0.5, -0.05), (0.5, -0.05)]))


def walled(x: float, y: float, width: float, height: float, **values: Any) -> Any:
    return costmap_of(grid_of(6.0, 6.0, (x, y, width, height)), **values)


def between() -> Any:
    """Return a costmap that the long outline touches halfway through a turn."""
    grid = empty_grid(6.0, 6.0)
    for y in (2.8, 3.15):
        block(grid, 2.4, y, 0.05, 0.05)
    return costmap_of(grid, inflation_radius=0.6, footprint=str(LONG.points.tolist()))


BEFORE = walled(2.4, 0.0, 0.1, 6.0)  # wherever it drives, it collides
BESIDE = walled(2.6, 2.3, 1.0, 0.4)
AHEAD_ONLY = {"use_rotate_to_heading": False}
FAR = {"other": (254, np.full(256, 9.0), 0.55)}  # costs that show nothing near


def run(
    name: str,
    costmap: Any = FREE,
    path: Any = PATH,
    velocity: Velocity = STILL,
    times: tuple[float, ...] = (0.0,),
    outline: Footprint | None = None,
    **values: Any,
) -> tuple[ControlResult, dict[str, Any]]:
    """Return a controller's last command, and all that it shows of it."""
    controller = make(name, outline, **values)
    controller.set_path(path)
    topics = frozenset(topics_of(PARAMETERS[name]["plugin"], controller._config))  # type: ignore[attr-defined]
    for now in times:
        want(controller, topics)
        result = controller.compute(POSE, velocity, costmap, now)
    return result, shown_by(controller)


def dwb(**values: Any) -> dict[str, Any]:
    return run("dwb", velocity=Velocity(0.2), **values)[1]


def braked(**values: Any) -> float:
    """Return the speed commanded 0.1 s after a path was cancelled."""
    controller: Any = make("pure pursuit", **values)
    controller.set_path(PATH)
    driven = Velocity(V_MAX)
    for _ in range(2):
        if controller.cancel():
            return 0.0
        driven = controller.compute(POSE, driven, FREE, 0.0).velocity
    return float(driven.x)


def lengths(**values: Any) -> set[int]:
    judged = dwb(critics=["Twirling", "GoalDist"], **{"Twirling.scale": 999.0}, **values)[
        "evaluation"
    ].trajectories
    return {len(one.scores) for one in judged if one.total >= 0.0}


def repeated(**values: Any) -> bool:
    poses = dwb(**values)["evaluation"].trajectories[0].poses
    return bool(np.array_equal(poses[-1], poses[-2]))


def rollouts(**values: Any) -> int:
    return len(run("mppi", visualize=True, **values)[1]["trajectories"].shapes[0].points)


def mppi(critic: str, **values: Any) -> Velocity:
    costmap = replace(BESIDE, inflations=FAR)
    critics: dict[str, Any] = {"critics": ["GoalCritic", "PathFollowCritic", critic]}
    settings = {f"{critic}.{name}": value for name, value in values.items()}
    more: dict[str, Any] = {f"{critic}.consider_footprint": True}
    result, _ = run("mppi", costmap, outline=LONG, **critics, **settings, **more)
    return result.velocity


def turn(name: str, costmap: Any = FREE, **values: Any) -> ControlResult:
    return run(name, costmap, AWAY, **values)[0]


ROWS: list[tuple[str, Any, Callable[..., Any], Any]] = [
    ("publish_evaluation", False, lambda **v: "evaluation" in dwb(**v), False),
    ("publish_trajectories", False, lambda **v: "marker" in dwb(**v), False),
    ("publish_local_plan", False, lambda **v: "local_plan" in dwb(**v), False),
    ("publish_transformed_plan", False, lambda **v: "transformed_global_plan" in dwb(**v), False),
    ("publish_cost_grid_pc", True, lambda **v: "cost_cloud" in dwb(**v), True),
    ("marker_lifetime", 2.0, lambda **v: dwb(**v)["marker"].shapes[0].lifetime, 2.0),
    (
        "debug_trajectory_details",
        True,
        lambda **v: run("dwb", BEFORE, **v)[0].message.partition("; ")[2],
        "forbidden 74 % by BaseObstacle, 26 % by GoalDist",
    ),
    (
        "prune_plan",
        False,
        lambda **v: dwb(**v)["transformed_global_plan"].poses[0, 0],
        pytest.approx(1.0),
    ),
    (
        "shorten_transformed_plan",
        False,
        lambda **v: dwb(forward_prune_distance=0.5, **v)["transformed_global_plan"].poses[-1, 0],
        pytest.approx(5.0),
    ),
    ("short_circuit_trajectory_evaluation", False, lengths, {2}),
    ("include_last_point", False, repeated, False),
    (
        "limit_vel_cmd_in_traj",
        True,
        lambda **v: (
            run("dwb", discretize_by_time=True, time_granularity=0.1, **v)[0].velocity.x < 0.11
        ),
        True,
    ),
    (
        "visualize",
        True,
        lambda **v: sorted(run("mppi", **v)[1]),
        sorted(topics_of(PARAMETERS["mppi"]["plugin"], None)),
    ),
    ("TrajectoryVisualizer.trajectory_step", 100, rollouts, 10 * 19),
    ("TrajectoryVisualizer.time_step", 28, rollouts, 200 * 2),
    ("use_cancel_deceleration", True, braked, pytest.approx(V_MAX - 0.1 * 3.2)),
    (
        "cancel_deceleration",
        1.0,
        lambda **v: braked(use_cancel_deceleration=True, **v),
        pytest.approx(V_MAX - 0.1),
    ),
    (
        "rotation_scaling_factor",
        0.1,
        lambda **v: abs(
            turn(
                "graceful", v_angular_min_in_place=0.0, max_angular_accel=99.0, **v
            ).velocity.yaw_rate
        ),
        pytest.approx(0.1 * W_MAX * math.pi),
    ),
    (
        "in_place_collision_resolution",
        3.0,
        lambda **v: turn("graceful", between(), outline=LONG, max_angular_accel=99.0, **v).status,
        ControlStatus.SUCCEEDED,
    ),
    (
        "max_cost_threshold",
        50.0,
        lambda **v: turn("pure pursuit under the shim", BESIDE, **AHEAD_ONLY, **v).velocity.x > 0.0,
        True,  # it does not turn: the primary drives
    ),
]


@pytest.mark.parametrize(
    ("parameter", "value", "measured", "expected"), ROWS, ids=[row[0] for row in ROWS]
)
def test_a_parameter_does_what_it_says(
    parameter: str, value: Any, measured: Callable[..., Any], expected: Any
) -> None:
    assert measured(**{parameter: value}) == expected
    assert measured() != expected, "the default does so too"


@pytest.mark.parametrize("critic", ["CostCritic", "ObstaclesCritic"])
def test_an_inflation_layer_s_name_chooses_how_costs_show_distances(critic: str) -> None:
    unnamed = mppi(critic)
    assert mppi(critic, inflation_layer_name="none such") == unnamed
    assert mppi(critic, inflation_layer_name="other") != unnamed


def test_controls_are_forgotten_after_the_reset_period() -> None:
    fresh, gap = run("mppi")[0], (0.0, 0.05, 0.55)
    assert run("mppi", times=gap, reset_period=0.4)[0] == fresh
    assert run("mppi", times=gap)[0] != fresh


def test_critics_are_not_found_in_other_namespaces() -> None:
    make("dwb", default_critic_namespaces=["mine", "dwb_critics"])
    with pytest.raises(ConfigError, match="no 'RotateToGoal'; valid: none, or 'dwb_critics'"):
        make("dwb", default_critic_namespaces=["mine"])


def test_nothing_is_made_that_nobody_wants() -> None:
    for name in PARAMETERS:
        controller = make(name)
        controller.set_path(PATH)
        assert controller.compute(POSE, STILL, FREE, 0.0).status is ControlStatus.SUCCEEDED
        assert shown_by(controller) == {}


def test_dwb_shows_what_it_scores() -> None:
    """The best has the least sum of raw scores by scales; the cloud's sum is that of its parts."""
    result, shown = run("dwb", BESIDE, velocity=Velocity(0.3), publish_cost_grid_pc=True)
    evaluation, cloud = shown["evaluation"], shown["cost_cloud"]
    legal = [one for one in evaluation.trajectories if one.total >= 0.0]
    for one in legal:
        total = sum(critic.raw_score * critic.scale for critic in one.scores)
        assert one.total == pytest.approx(total)
        assert one.poses[0] == pytest.approx(POSE.array())
    best = evaluation.trajectories[evaluation.best]
    assert best.total == min(one.total for one in legal)
    assert evaluation.trajectories[evaluation.worst].total == max(one.total for one in legal)
    assert best.velocity == (result.velocity.x, result.velocity.y, result.velocity.yaw_rate)
    assert shown["local_plan"].poses == pytest.approx(best.poses)
    forbidden = {one.scores[-1].name for one in evaluation.trajectories if one.total < 0.0}
    assert forbidden == {"BaseObstacle"}
    names = {shape.name: shape for shape in shown["marker"].shapes}
    assert set(names) == {"ValidTrajectories", "InvalidTrajectories"}
    assert len(shown["marker"].shapes) == len(evaluation.trajectories)
    row = int(np.argmin(np.hypot(*(cloud.points - (2.625, 2.525)).T)))
    assert cloud.channels["BaseObstacle"][row] == 254
    at_path = int(np.argmin(np.hypot(*(cloud.points - (3.025, 3.025)).T)))
    assert cloud.channels["PathDist"][at_path] == 0
    parts = 0.02 * cloud.channels["BaseObstacle"] + 0.025 * 32.0 * sum(
        cloud.channels[name] for name in ("PathDist", "GoalDist", "PathAlign", "GoalAlign")
    )
    assert cloud.channels["total_cost"] == pytest.approx(parts, rel=1e-5)


def test_mppi_s_plan_is_driven_by_its_controls() -> None:
    result, shown = run("mppi", velocity=Velocity(0.3), visualize=True)
    poses = shown["optimal_trajectory"].poses
    assert poses.shape == (56, 3)
    assert poses[0, 0] == pytest.approx(POSE.x + 0.3 * 0.05)
    assert np.hypot(*np.diff(poses[:, :2], axis=0).T).max() <= V_MAX * 0.05 + 1e-6
    assert poses[-1, 0] > POSE.x + 0.5
    assert result.velocity.x > 0.2


def test_a_shim_shows_what_its_primary_does_while_that_drives() -> None:
    name = "mppi under the shim"
    assert set(run(name, visualize=True)[1]) == set(run("mppi", visualize=True)[1])
    assert run(name, path=AWAY, visualize=True)[1] == {}
