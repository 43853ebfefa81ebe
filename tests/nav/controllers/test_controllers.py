"""The contract of every controller, on a simulated robot with delay and acceleration."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import STILL
from arjuna_nav.controllers import Controller, ControlStatus, PathError
from arjuna_nav.costmap.footprint import Footprint
from tests.helpers.nav.controllers import (
    OWN,
    PARAMETERS,
    V_MAX,
    W_MAX,
    XY_TOLERANCE,
    YAW_TOLERANCE,
    make,
)
from tests.nav.worlds import Unicycle, costmap_of, empty_grid, follow, grid_of, polyline

PATHS = {
    "corner": ([(1.0, 1.0), (3.0, 1.0), (3.0, 4.0)], math.pi / 2, 0.35),
    "s-curve": ([(1.0, 2.0), (2.0, 3.0), (3.0, 2.0), (4.0, 3.0), (5.0, 3.0)], 0.0, 0.5),
    "behind": ([(4.0, 3.0), (1.0, 3.0)], math.pi, 0.30),
    "turn at the goal": ([(1.0, 3.0), (4.0, 3.0)], math.pi, 0.10),
}
ORIGIN = SE2(-2.0, 1.5, 0.7)
"""Of the grid on which the paths lie."""


@pytest.fixture(params=PARAMETERS)
def name(request: pytest.FixtureRequest) -> str:
    chosen: str = request.param
    return chosen


@pytest.fixture
def controller(name: str) -> Controller:
    return make(name)


def off_the_path(robot: Unicycle, path: NDArray[np.float64]) -> float:
    trace = np.array([[pose.x, pose.y] for pose in robot.trace])
    gaps = np.hypot(*(trace[:, None] - path[None, :, :2]).transpose(2, 0, 1))
    return float(gaps.min(axis=1).max())


FOLLOWED = [
    *((name, shape) for name in OWN for shape in PATHS if (name, shape) != ("dwb", "behind")),
    *((name, shape) for name in PARAMETERS.keys() - OWN for shape in ("behind", "s-curve")),
]
"""DWB's scores do not lead it round: that is what the shim is for."""


@pytest.mark.parametrize(("name", "shape"), sorted(FOLLOWED))
def test_follows_to_the_goal_and_stays(controller: Controller, shape: str) -> None:
    corners, final_yaw, allowed = PATHS[shape]
    costmap = costmap_of(empty_grid(6.0, 6.0, ORIGIN))
    path = np.array(
        [(ORIGIN @ SE2.from_array(row)).array() for row in polyline(corners, final_yaw)]
    )
    robot = Unicycle(ORIGIN @ SE2(*corners[0]))
    controller.set_path(path)
    results = follow(controller, robot, costmap, 460)
    goal = SE2.from_array(path[-1])
    assert all(result.status is ControlStatus.SUCCEEDED for result in results)
    assert max(abs(result.velocity.x) for result in results) <= V_MAX + 1e-6
    assert max(abs(result.velocity.yaw_rate) for result in results) <= W_MAX + 1e-6
    assert off_the_path(robot, path) < allowed
    assert robot.pose.distance(goal) < XY_TOLERANCE
    assert abs(wrap(robot.pose.theta - goal.theta)) < YAW_TOLERANCE
    rest = [abs(wrap(pose.theta - robot.pose.theta)) for pose in robot.trace[-20:]]
    assert max(rest) < 0.02, "it does not come to rest"


def test_pushed_away_from_the_goal_it_drives_back(controller: Controller) -> None:
    costmap, robot = costmap_of(empty_grid(6.0, 6.0)), Unicycle(SE2(3.0, 3.0))
    goal = SE2(4.0, 3.0)
    controller.set_path(polyline([(3.0, 3.0), (4.0, 3.0)], 0.0))
    follow(controller, robot, costmap, 120)
    assert robot.pose.distance(goal) < XY_TOLERANCE
    robot.pose, robot.velocity = SE2(2.5, 2.8), STILL
    controller.set_path(polyline([(2.5, 2.8), (4.0, 3.0)], 0.0))  # as a navigator plans again
    follow(controller, robot, costmap, 200)
    assert robot.pose.distance(goal) < XY_TOLERANCE


@pytest.mark.parametrize("footprint", ["circle", "polygon"])
def test_never_drives_into_an_obstacle(name: str, footprint: str) -> None:
    grid = grid_of(6.0, 6.0, (3.0, 0.0, 0.2, 6.0))
    corners = np.array([[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]])
    outline = Footprint.polygon(corners) if footprint == "polygon" else Footprint.circle(0.25)
    text = str(corners.tolist()) if footprint == "polygon" else "[]"
    costmap, robot = costmap_of(grid, footprint=text), Unicycle(SE2(1.0, 3.0, 0.0))
    controller = make(name, outline)
    controller.set_path(polyline([(1.0, 3.0), (5.0, 3.0)], 0.0))
    results = follow(controller, robot, costmap, 200)
    reach = max(float(outline.at(pose)[:, 0].max()) for pose in robot.trace)
    assert reach < 3.0
    stands = all(abs(result.velocity.x) < 0.05 for result in results[-20:])
    assert stands, "it does not come to rest before it"
    failed = [result for result in results if result.status is not ControlStatus.SUCCEEDED]
    assert all("collision ahead" in result.message for result in failed)


def test_beyond_the_costmaps_grid_says_where_it_lies_and_the_remedy(controller: Controller) -> None:
    costmap, robot = costmap_of(empty_grid(6.0, 6.0)), Unicycle(SE2(8.0, 3.0, 0.0))
    controller.set_path(polyline([(8.0, 3.0), (10.0, 3.0)], 0.0))
    result = follow(controller, robot, costmap, 1)[0]
    assert result.status is ControlStatus.NO_VALID_CONTROL
    assert "outside the costmap's grid, which spans x 0.00 to 6.00 m, y 0.00" in result.message
    assert "'rolling_window: true'" in result.message


def test_a_speed_limit_holds_at_once(controller: Controller) -> None:
    costmap, robot = costmap_of(empty_grid(6.0, 6.0)), Unicycle(SE2(1.0, 3.0, 0.0))
    controller.set_path(polyline([(1.0, 3.0), (5.0, 3.0)], 0.0))
    follow(controller, robot, costmap, 40)
    assert robot.velocity.x > 0.8 * V_MAX
    assert controller.desired_speed == pytest.approx(V_MAX)
    controller.speed_limit = 0.2
    results = follow(controller, robot, costmap, 20)
    assert max(result.velocity.x for result in results) <= 0.2 + 1e-6
    controller.speed_limit = math.inf
    follow(controller, robot, costmap, 20)
    assert robot.velocity.x > 0.3


def test_a_speed_limit_holds_in_reverse_too() -> None:
    controller = make("mppi", vx_min=-0.4, critics=["GoalCritic"])
    costmap, robot = costmap_of(empty_grid(6.0, 6.0)), Unicycle(SE2(3.0, 3.0, 0.0))
    controller.set_path(polyline([(3.0, 3.0), (2.0, 3.0)], 0.0))
    slowest = []
    for limit in (math.inf, 0.15):
        controller.speed_limit = limit
        slowest.append(min(each.velocity.x for each in follow(controller, robot, costmap, 20)[8:]))
    assert slowest[0] < -0.25
    assert -0.15 - 1e-6 <= slowest[1] < -0.1


def test_is_the_same_each_time(name: str) -> None:
    costmap, traces = costmap_of(grid_of(6.0, 6.0, (2.4, 2.0, 0.3, 0.7))), []
    for _ in range(2):
        controller, robot = make(name), Unicycle(SE2(1.0, 3.0, 0.0))
        controller.set_path(polyline([(1.0, 3.0), (4.0, 3.0)], 0.0))
        follow(controller, robot, costmap, 40)
        traces.append([tuple(pose.array()) for pose in robot.trace])
    assert traces[0] == traces[1]


def test_a_new_path_to_the_same_goal_is_continued_on(controller: Controller) -> None:
    costmap, robot = costmap_of(empty_grid(6.0, 6.0)), Unicycle(SE2(1.0, 3.0, 0.0))
    for k in range(6):
        pose = robot.pose
        controller.set_path(polyline([(pose.x, pose.y), (4.0, 3.0)], 0.0))
        results = follow(controller, robot, costmap, 20)
        assert all(result.status is ControlStatus.SUCCEEDED for result in results)
        assert k == 0 or min(result.velocity.x for result in results) > 0.2, "it hesitates"
        assert controller.path[0, 0] == pytest.approx(robot.pose.x, abs=0.06), "what is left"


def test_says_that_no_path_was_set(controller: Controller) -> None:
    costmap = costmap_of(empty_grid(2.0, 2.0))
    result = controller.compute(SE2(1.0, 1.0), STILL, costmap, 0.0)
    assert result.status is ControlStatus.INVALID_PATH
    with pytest.raises(PathError, match=r"must be \(N, 3\) with N > 0"):
        controller.set_path(np.empty((0, 3)))


@pytest.mark.parametrize("reach", [True, False])
def test_a_fast_mppi_looks_as_far_along_the_path_as_it_can_drive(reach: bool) -> None:
    costmap, robot = costmap_of(empty_grid(12.0, 4.0)), Unicycle(SE2(0.8, 2.0, 0.0))
    controller = make("mppi", vx_max=2.0, vx_std=0.4, reach_counts=reach)
    controller.set_path(polyline([(0.8, 2.0), (11.0, 2.0)], 0.0))
    follow(controller, robot, costmap, 60)
    assert (robot.velocity.x > 1.2) == reach
