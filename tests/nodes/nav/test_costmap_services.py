"""Services of costmap nodes: what they clear, and the costs they answer with."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from nav2_msgs.srv import (
    ClearCostmapAroundPose,
    ClearCostmapAroundRobot,
    ClearCostmapExceptRegion,
    ClearEntireCostmap,
)

from arjuna_core.ros.convert import pose_stamped
from arjuna_core.se2 import SE2
from tests.helpers.nav.costmaps import (
    BOX,
    FREE,
    GLOBAL,
    LETHAL,
    LOCAL,
    beside_a_box,
    box_cost,
    cost,
)
from tests.helpers.nav.navigation import PlayedRobot

made = beside_a_box


def everything(robot: PlayedRobot, name: str) -> None:
    service = f"/{name}/clear_entirely_{name}"
    robot.bench.call(ClearEntireCostmap, service, ClearEntireCostmap.Request())


def around(service: str, distance: float = 4.0) -> Callable[[PlayedRobot, str], None]:
    def clear(robot: PlayedRobot, name: str) -> None:
        request = ClearCostmapAroundRobot.Request(reset_distance=distance)
        robot.bench.call(ClearCostmapAroundRobot, service.format(name), request)

    return clear


def except_region(service: str, distance: float = 1.0) -> Callable[[PlayedRobot, str], None]:
    def clear(robot: PlayedRobot, name: str) -> None:
        request = ClearCostmapExceptRegion.Request(reset_distance=distance)
        robot.bench.call(ClearCostmapExceptRegion, service.format(name), request)

    return clear


def around_pose(
    service: str, x: float = BOX[0], frame: str = "map", distance: float = 1.0
) -> Callable[[PlayedRobot, str], None]:
    def clear(robot: PlayedRobot, name: str) -> None:
        request = ClearCostmapAroundPose.Request(
            pose=pose_stamped(SE2(x, 0.0), frame, 0.0), reset_distance=distance
        )
        robot.bench.call(ClearCostmapAroundPose, service.format(name), request)

    return clear


@pytest.mark.parametrize("name", [GLOBAL, LOCAL])
@pytest.mark.parametrize(
    "clear",
    [
        everything,
        around("/{0}/clear_around_{0}"),
        around("/{0}/clear_costmap_around_robot"),
        except_region("/{0}/clear_except_{0}"),
        except_region("/{0}/clear_costmap_except_region"),
        around_pose("/{0}/clear_around_pose_{0}"),
        around_pose("/{0}/clear_costmap_around_pose"),
    ],
)
def test_clearing_forgets_what_was_seen_but_not_the_map(
    robot: PlayedRobot, name: str, clear: Callable[[PlayedRobot, str], None]
) -> None:
    assert box_cost(robot, name) == LETHAL
    clear(robot, name)
    assert box_cost(robot, name) == FREE
    assert cost(robot, GLOBAL, 5.05, 3.0) == LETHAL  # a wall of the map
    robot.run(1.2)
    assert box_cost(robot, name) == LETHAL  # seen again


@pytest.mark.parametrize("name", [GLOBAL, LOCAL])
@pytest.mark.parametrize(
    "clear",
    [
        around("/{0}/clear_around_{0}", 1.0),
        around("/{0}/clear_around_{0}", -1.0),
        around("/{0}/clear_around_{0}", math.nan),
        except_region("/{0}/clear_except_{0}", 4.0),
        around_pose("/{0}/clear_around_pose_{0}", -1.0),
        around_pose("/{0}/clear_around_pose_{0}", frame="moon"),
    ],
)
def test_what_lies_elsewhere_is_kept(
    robot: PlayedRobot, name: str, clear: Callable[[PlayedRobot, str], None]
) -> None:
    clear(robot, name)
    assert box_cost(robot, name) == LETHAL


def test_get_cost_answers_for_points_and_for_the_footprint(robot: PlayedRobot) -> None:
    assert cost(robot, GLOBAL, 0.0, -2.0) == FREE
    beside = cost(robot, GLOBAL, BOX[0], 0.45)
    assert FREE < beside < 253.0
    assert cost(robot, GLOBAL, BOX[0], 0.3, use_footprint=True) == LETHAL
    assert beside < cost(robot, GLOBAL, BOX[0], 0.45, use_footprint=True) < LETHAL
    assert cost(robot, GLOBAL, 9.0, 0.0, use_footprint=True) == LETHAL
    assert cost(robot, GLOBAL, 9.0, 0.0) == -1.0
    assert cost(robot, GLOBAL, math.nan, 0.0) == -1.0
    assert cost(robot, LOCAL, 3.0, 0.0) == -1.0
