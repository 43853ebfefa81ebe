"""Costmap nodes: what clients see of them, what they clear, when they are current."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Point32, Polygon, PolygonStamped
from map_msgs.msg import OccupancyGridUpdate
from nav2_msgs.msg import Costmap as CostmapMsg
from nav2_msgs.msg import CostmapUpdate
from nav2_msgs.srv import (
    ClearCostmapAroundPose,
    ClearCostmapAroundRobot,
    ClearCostmapExceptRegion,
    ClearEntireCostmap,
    GetCostmap,
)
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_from_msg, pose_stamped, seconds
from arjuna_core.se2 import SE2
from bringup.stack import GLOBAL_COSTMAP, LOCAL_COSTMAP
from tests.helpers.nav.costmaps import (
    BOX,
    FREE,
    GLOBAL,
    LETHAL,
    LOCAL,
    UNKNOWN,
    beside_a_box,
    box_cost,
    cost,
    costmap_from_msg,
)
from tests.helpers.nav.navigation import PlayedRobot
from tests.nav.worlds import empty_grid

made = beside_a_box


def test_what_is_seen_is_marked_and_what_goes_is_cleared(robot: PlayedRobot) -> None:
    assert [box_cost(robot, name) for name in (GLOBAL, LOCAL)] == [LETHAL, LETHAL]
    row, column = robot.world.frame.to_cell(*BOX)
    robot.world.data[row - 2 : row + 3, column - 3 : column + 3] = 0
    robot.run(1.2)
    assert [box_cost(robot, name) for name in (GLOBAL, LOCAL)] == [FREE, FREE]


def test_get_costmap_is_what_is_published(robot: PlayedRobot) -> None:
    for name, frame in ((GLOBAL, "map"), (LOCAL, "odom")):
        raw = robot.bench.latched(CostmapMsg, f"/{name}/costmap_raw")
        grids = robot.bench.latched(OccupancyGridMsg, f"/{name}/costmap")
        robot.run(1.0)
        response = robot.bench.call(GetCostmap, f"/{name}/get_costmap", GetCostmap.Request())
        asked, published = costmap_from_msg(response.map), costmap_from_msg(raw[-1])
        assert asked.frame == published.frame
        assert np.array_equal(asked.data, published.data)
        shown = grid_from_msg(grids[-1])
        assert shown.frame == published.frame
        assert np.array_equal(shown.data == 100, published.data == 254)
        assert np.array_equal(shown.data == -1, published.data == 255)
        assert response.map.header.frame_id == frame
        assert seconds(response.map.metadata.update_time) > 0.9


def test_a_late_joiner_gets_the_costmap_though_time_stands_still(robot: PlayedRobot) -> None:
    kinds = {"costmap": OccupancyGridMsg, "costmap_raw": CostmapMsg}
    for name, (topic, kind) in itertools.product((GLOBAL, LOCAL), kinds.items()):
        messages = robot.bench.latched(kind, f"/{name}/{topic}")
        assert len(messages) == 1
        (info,) = robot.bench.node.get_publishers_info_by_topic(f"/{name}/{topic}")
        assert info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        assert info.qos_profile.reliability == ReliabilityPolicy.RELIABLE


def test_a_costmap_that_is_not_updated_is_not_published_as_new(robot: PlayedRobot) -> None:
    grids = robot.bench.latched(OccupancyGridMsg, f"/{LOCAL}/costmap")
    robot.localized = False
    robot.run(1.0)  # until the last transform is too old
    grids.clear()
    robot.run(1.0)
    assert not grids


def test_the_footprint_is_published_where_the_robot_is(robot: PlayedRobot) -> None:
    """And the local costmap lies about it."""
    topics = [f"/{name}/published_footprint" for name in (GLOBAL, LOCAL)]
    footprints = [robot.bench.collect(PolygonStamped, topic) for topic in topics]
    robot.pose = SE2(1.0, -1.0, 0.5)
    robot.run(1.2)
    for messages in footprints:
        corners = [(point.x, point.y) for point in messages[-1].polygon.points]
        assert np.mean(corners, axis=0) == pytest.approx((1.0, -1.0), abs=0.01)
    response = robot.bench.call(GetCostmap, f"/{LOCAL}/get_costmap", GetCostmap.Request())
    frame = costmap_from_msg(response.map).frame
    assert (frame.width, frame.height) == (60, 60)
    assert (frame.origin.x, frame.origin.y) == pytest.approx((-0.5, -2.5), abs=0.051)


def test_a_footprint_can_be_given_while_running(robot: PlayedRobot) -> None:
    def footprint(*points: tuple[float, float]) -> None:
        message = Polygon(points=[Point32(x=x, y=y) for x, y in points])
        robot.bench.publish(Polygon, f"/{GLOBAL}/footprint", message)

    assert cost(robot, GLOBAL, BOX[0], 0.5, use_footprint=True) < LETHAL
    footprint((0.6, 0.6), (-0.6, 0.6), (-0.6, -0.6), (0.6, -0.6))
    assert cost(robot, GLOBAL, BOX[0], 0.5, use_footprint=True) == LETHAL
    footprint((0.6, 0.6), (-0.6, 0.6))  # no area: ignored
    footprint((math.nan, 0.6), (-0.6, 0.6), (-0.6, -0.6))
    assert cost(robot, GLOBAL, BOX[0], 0.5, use_footprint=True) == LETHAL


def test_parameters_change_the_layers_and_keep_the_map(robot: PlayedRobot) -> None:
    assert FREE < cost(robot, GLOBAL, 4.65, 3.0) < LETHAL
    parameter = Parameter("inflation_layer.inflation_radius", value=0.3).to_parameter_msg()
    response = robot.bench.call(
        SetParameters,
        f"/{GLOBAL}/{GLOBAL}/set_parameters",
        SetParameters.Request(parameters=[parameter]),
    )
    assert response.results[0].successful, response.results[0].reason
    assert cost(robot, GLOBAL, 4.65, 3.0) == FREE
    assert cost(robot, GLOBAL, 5.05, 3.0) == LETHAL


def test_a_broken_map_changes_nothing(robot: PlayedRobot) -> None:
    message = OccupancyGridMsg(data=[0, 0, 0])
    message.info.resolution, message.info.width, message.info.height = 0.05, 2, 2
    robot.bench.publish(OccupancyGridMsg, "/map", message, qos.LATCHED)
    assert cost(robot, GLOBAL, 5.05, 3.0) == LETHAL


def test_unknown_space_of_the_map_stays_unknown(robot: PlayedRobot) -> None:
    grid = empty_grid(11.0, 11.0, SE2(-5.5, -5.5))
    grid.data[:, :60] = -1
    robot.sees = False
    robot.send_map(grid)
    assert cost(robot, GLOBAL, -4.5, 3.0) == UNKNOWN


def test_current_needs_activity_a_map_and_a_pose(robot: PlayedRobot) -> None:
    node = robot.nodes[f"{GLOBAL}/{GLOBAL}"]
    assert node.current(0.6) is node.layered.costmap
    robot.localized = False
    robot.run(2.0)
    assert node.current(0.6) is None
    assert "over the tolerance of 0.3 s" in node.why_not_current()
    robot.localized = True
    robot.run(0.6)
    assert node.current(0.6) is not None
    robot.transition(f"{GLOBAL}/{GLOBAL}", "deactivate")
    assert node.current(0.6) is None
    assert "not active" in node.why_not_current()


def test_time_set_back_forgets_what_was_seen(robot: PlayedRobot) -> None:
    assert box_cost(robot, GLOBAL) == LETHAL
    robot.bench.set_back()
    assert box_cost(robot, GLOBAL) == FREE
    robot.run(1.2)
    assert box_cost(robot, GLOBAL) == LETHAL


def test_a_scanner_that_falls_silent_makes_the_costmap_outdated() -> None:
    silence = {"obstacle_layer.scan.expected_update_rate": 0.5}
    robot = PlayedRobot({f"{LOCAL}/{LOCAL}": silence})
    robot.bring_up(LOCAL_COSTMAP)
    robot.run(1.0)
    node = robot.nodes[f"{LOCAL}/{LOCAL}"]
    assert node.current(0.3) is not None
    robot.sees = False
    robot.run(0.4)
    assert node.current(0.3) is not None
    robot.run(0.6)
    assert node.current(0.3) is None
    assert "no scan on /scan for" in node.why_not_current()
    robot.sees = True
    robot.run(0.3)
    assert node.current(0.3) is not None


def test_a_costmap_slower_than_its_reader_asks_is_current_until_it_is_overdue() -> None:
    robot = PlayedRobot({f"{GLOBAL}/{GLOBAL}": {"update_frequency": 0.4}})
    robot.bring_up(GLOBAL_COSTMAP)
    robot.send_map(robot.world)
    robot.run(4.0)
    node = robot.nodes[f"{GLOBAL}/{GLOBAL}"]
    for _ in range(6):
        assert node.current(1.0) is not None, node.why_not_current()
        robot.run(0.5)
    robot.localized = False
    robot.run(4.0)
    assert node.current(1.0) is None


@pytest.mark.parametrize(("topic", "count"), [("front/scan", 1), ("scan", 0)])
def test_a_costmap_that_gets_no_scan_says_so_once_and_where_scans_are(
    topic: str, count: int, capfd: pytest.CaptureFixture[str]
) -> None:
    robot = PlayedRobot({f"{LOCAL}/{LOCAL}": {"obstacle_layer.scan.topic": topic}})
    robot.bring_up(LOCAL_COSTMAP)
    robot.run(10.0)
    lines = [line for line in capfd.readouterr().err.splitlines() if "no scan comes on" in line]
    assert len(lines) == count
    advice = "nobody publishes it; scans are on /scan: set obstacle_layer.scan.topic"
    assert all(f"no scan comes on '/front/scan': {advice}" in line for line in lines)


def updates(robot: PlayedRobot, name: str) -> tuple[list[Any], list[Any]]:
    """Return lists that grow with the parts of a costmap that are published."""
    return (
        robot.bench.latched(OccupancyGridUpdate, f"/{name}/costmap_updates"),
        robot.bench.latched(CostmapUpdate, f"/{name}/costmap_raw_updates"),
    )


def test_what_changes_is_published_by_itself(robot: PlayedRobot) -> None:
    node = robot.nodes[f"{GLOBAL}/{GLOBAL}"]
    robot.run(1.2)
    grids, raws = updates(robot, GLOBAL)
    grids.clear()
    raws.clear()
    kept = node.layered.costmap.data.copy()
    robot.world.data[:] = 0  # the box and the walls have gone
    robot.run(2.2)
    assert grids
    for raw in raws:
        window = slice(raw.y, raw.y + raw.size_y), slice(raw.x, raw.x + raw.size_x)
        kept[window] = np.array(raw.data, dtype=np.uint8).reshape(raw.size_y, raw.size_x)
    np.testing.assert_array_equal(kept, node.layered.costmap.data)
    assert (grids[-1].x, grids[-1].y) == (raws[-1].x, raws[-1].y)
    assert len(grids[-1].data) == grids[-1].width * grids[-1].height
    assert max(raw.size_x * raw.size_y for raw in raws) < kept.size


def test_the_whole_is_published_for_whoever_is_new_where_that_is_asked_for() -> None:
    robot = PlayedRobot({f"{GLOBAL}/{GLOBAL}": {"always_send_full_costmap": False}})
    robot.bring_up(GLOBAL_COSTMAP)
    robot.send_map(robot.world)
    robot.run(3.2)
    grids = robot.bench.latched(OccupancyGridMsg, f"/{GLOBAL}/costmap")
    robot.run(5.0)
    stamps = [seconds(grid.header.stamp) for grid in grids]
    assert 1 <= len(stamps) <= 2, "the latched one, and one of now"
    assert stamps[-1] > 3.0
    robot.send_map(empty_grid(14.0, 13.0, SE2(-7.0, -6.0)))
    robot.run(1.2)
    assert grids[-1].info.width == 280


@pytest.mark.parametrize(("timeout", "active"), [(0.0, True), (3.0, True), (1.0, False)])
def test_a_costmap_waits_for_the_first_pose_for_its_time_only(timeout: float, active: bool) -> None:
    robot = PlayedRobot({LOCAL_COSTMAP.name: {"initial_transform_timeout": timeout}})
    robot.localized = False
    robot.run(0.2)
    robot.bring_up(LOCAL_COSTMAP)
    robot.run(2.0)
    assert (robot.nodes[LOCAL_COSTMAP.name].state_label == "active") is active
    robot.localized = True
    robot.run(1.0)
    robot.localized = False  # once it was known it may be missed for long
    robot.run(4.0)
    assert (robot.nodes[LOCAL_COSTMAP.name].state_label == "active") is active


def everything(robot: PlayedRobot, name: str) -> None:
    service = f"/{name}/clear_entirely_{name}"
    robot.bench.call(ClearEntireCostmap, service, ClearEntireCostmap.Request())


def clearing(kind: Any, service: str, **fields: Any) -> Callable[[PlayedRobot, str], None]:
    def clear(robot: PlayedRobot, name: str) -> None:
        robot.bench.call(kind, service.format(name), kind.Request(**fields))

    return clear


def around(service: str, distance: float = 4.0) -> Callable[[PlayedRobot, str], None]:
    return clearing(ClearCostmapAroundRobot, service, reset_distance=distance)


def except_region(service: str, distance: float = 1.0) -> Callable[[PlayedRobot, str], None]:
    return clearing(ClearCostmapExceptRegion, service, reset_distance=distance)


def around_pose(
    service: str, x: float = BOX[0], frame: str = "map"
) -> Callable[[PlayedRobot, str], None]:
    pose = pose_stamped(SE2(x), frame, 0.0)
    return clearing(ClearCostmapAroundPose, service, pose=pose, reset_distance=1.0)


@pytest.mark.parametrize("name", [GLOBAL, LOCAL])
def test_clearing_forgets_what_was_seen_but_not_the_map(robot: PlayedRobot, name: str) -> None:
    for clear in (
        everything,
        around("/{0}/clear_around_{0}"),
        around("/{0}/clear_costmap_around_robot"),
        except_region("/{0}/clear_except_{0}"),
        except_region("/{0}/clear_costmap_except_region"),
        around_pose("/{0}/clear_around_pose_{0}"),
        around_pose("/{0}/clear_costmap_around_pose"),
    ):
        assert box_cost(robot, name) == LETHAL
        clear(robot, name)
        assert box_cost(robot, name) == FREE
        assert cost(robot, GLOBAL, 5.05, 3.0) == LETHAL  # a wall of the map
        robot.run(1.2)  # seen again


@pytest.mark.parametrize("name", [GLOBAL, LOCAL])
def test_what_lies_elsewhere_is_kept(robot: PlayedRobot, name: str) -> None:
    for clear in (
        around("/{0}/clear_around_{0}", 1.0),
        around("/{0}/clear_around_{0}", -1.0),
        around("/{0}/clear_around_{0}", math.nan),
        except_region("/{0}/clear_except_{0}", 4.0),
        around_pose("/{0}/clear_around_pose_{0}", x=-1.0),
        around_pose("/{0}/clear_around_pose_{0}", frame="moon"),
    ):
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
