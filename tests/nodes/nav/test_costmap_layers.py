"""Costmap nodes with sensors and layers as others list them: lidars, a camera, sonars, filters."""

from __future__ import annotations

import array
import math
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Quaternion, TransformStamped, Twist, TwistStamped, Vector3
from map_msgs.msg import OccupancyGridUpdate
from nav2_msgs.msg import Costmap as CostmapMsg
from nav2_msgs.msg import CostmapFilterInfo, SpeedLimit, VoxelGrid
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from sensor_msgs.msg import LaserScan, PointCloud2, PointField, Range
from std_srvs.srv import SetBool
from tf2_msgs.msg import TFMessage

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_msg, header, transform_msg
from arjuna_core.ros.velocity import listeners
from arjuna_core.se2 import SE2
from bringup.stack import LOCAL_COSTMAP
from tests.helpers.nav.costmaps import FREE, LETHAL, LOCAL, cost, costmap_from_msg
from tests.helpers.nav.navigation import PlayedRobot

FRAMES = {"global_frame": "odom", "robot_base_frame": "base_link"}
WINDOW = {"rolling_window": True, "width": 6, "height": 6, "resolution": 0.05}


def costmap(**layers: Any) -> PlayedRobot:
    """Bring up a local costmap that has nothing of the shipped one."""
    values = {**FRAMES, **WINDOW, "update_frequency": 10.0, **layers}
    robot = PlayedRobot({f"{LOCAL}/{LOCAL}": values}, shipped=False)
    robot.sees = False
    robot.bring_up(LOCAL_COSTMAP)
    return robot


def mount(robot: PlayedRobot, name: str, x: float, z: float, pitch: float, yaw: float) -> None:
    sensor = TransformStamped(child_frame_id=name, header=header("base_link", 0.0))
    sensor.transform.translation = Vector3(x=x, y=0.0, z=z)
    (cp, sp), (cy, sy) = ((math.cos(a / 2), math.sin(a / 2)) for a in (pitch, yaw))
    sensor.transform.rotation = Quaternion(x=-sp * sy, y=sp * cy, z=cp * sy, w=cp * cy)
    robot.bench.publish(TFMessage, "/tf_static", TFMessage(transforms=[sensor]), qos.TF_STATIC)


def scan(robot: PlayedRobot, name: str, distance: float) -> None:
    """Send what a lidar sees that looks a little to both sides."""
    message = LaserScan(
        header=header(name, robot.now),
        angle_min=-0.2,
        angle_max=0.2,
        angle_increment=0.004,
        range_min=0.05,
        range_max=10.0,
        ranges=array.array("f", [distance] * 101),
    )
    robot.bench.publish(LaserScan, f"/{name}", message, qos.SENSOR_PUBLISHER)
    robot.run(0.3)


LIDAR = {"clearing": True, "max_obstacle_height": 2.0}


def send(robot: PlayedRobot, topic: str, grid: OccupancyGrid, frame: str) -> None:
    robot.bench.publish(OccupancyGridMsg, topic, grid_msg(grid, frame, robot.now), qos.LATCHED)


def wall(low: float) -> OccupancyGrid:
    """Return a map whose cells are occupied from some x on [m]."""
    frame = GridFrame(0.05, 200, 200, SE2(-5.0, -5.0))
    x = frame.origin.x + 0.05 * (np.arange(200) + 0.5)
    return OccupancyGrid(frame, np.where(x >= low, 100, 0)[None].repeat(200, 0).astype(np.int8))


def test_a_map_lies_in_a_window_that_rolls_in_odom() -> None:
    layer = {"subscribe_to_updates": True, "map_topic": "plan"}
    robot = costmap(plugins=["static_layer"], static_layer=layer)
    node = robot.nodes[f"{LOCAL}/{LOCAL}"]
    robot.run(0.5)
    assert "no map has come on /plan" in node.why_not_current()
    send(robot, "/plan", wall(1.0), "plan_frame")
    robot.run(0.3)
    assert "plan_frame" in node.why_not_current()
    there = TFMessage(transforms=[transform_msg(SE2(0.5, 0.0), "map", "plan_frame", 0.0)])
    robot.bench.publish(TFMessage, "/tf_static", there, qos.TF_STATIC)
    robot.run(0.3)
    assert node.current(0.3) is not None
    assert [cost(robot, LOCAL, x, 0.0) for x in (1.42, 1.58)] == [FREE, LETHAL]
    part = OccupancyGridUpdate(x=100, y=100, width=20, height=2)
    part.data = array.array("b", [100] * 40)
    robot.bench.publish(OccupancyGridUpdate, "/plan_updates", part, qos.DEFAULT)
    part = OccupancyGridUpdate(x=0, y=0, width=9, height=9, data=array.array("b", [100]))
    robot.bench.publish(OccupancyGridUpdate, "/plan_updates", part, qos.DEFAULT)
    robot.run(0.3)
    assert [cost(robot, LOCAL, x, 0.02) for x in (0.48, 0.52, 1.48)] == [FREE, LETHAL, LETHAL]


def test_what_a_single_layer_holds_is_published() -> None:
    layer = {"observation_sources": "front", "front": LIDAR}
    layers = {"plugins": ["static_layer", "obstacle_layer"], "obstacle_layer": layer}
    robot = costmap(**layers)
    mount(robot, "front", 0.0, 0.3, 0.0, 0.0)
    grids = {
        name: robot.bench.collect(CostmapMsg, f"/{LOCAL}/{name}_raw")
        for name in ("static_layer", "obstacle_layer")
    }
    shown = robot.bench.collect(OccupancyGridMsg, f"/{LOCAL}/obstacle_layer")
    send(robot, "/map", wall(2.0), "odom")
    robot.run(0.5)
    scan(robot, "front", 1.02)
    robot.run(1.2)
    mapped, seen = (costmap_from_msg(messages[-1]) for messages in grids.values())
    assert [seen.cost_at(x, 0.02) for x in (1.02, 2.02)] == [LETHAL, FREE]
    assert [mapped.cost_at(x, 0.02) for x in (1.02, 2.02)] == [FREE, LETHAL]
    assert grids["obstacle_layer"][-1].metadata.layer == "obstacle_layer"
    assert np.count_nonzero(shown[-1].data) == (seen.data == LETHAL).sum()


@pytest.mark.parametrize("stamped", [False, True])
def test_what_stops_the_robot_is_marked_by_its_commands(stamped: bool) -> None:
    values = {"enable_stamped_cmd_vel": stamped, "fixed_frame": "odom"}
    robot = costmap(plugins=["contact_layer"], contact_layer=values)
    robot.grips = False
    robot.run(0.3)
    assert len(listeners(robot.bench.node, "/cmd_vel")) == 1, "the bench drives, a costmap looks on"
    ahead = Twist(linear=Vector3(x=0.4))
    for _ in range(20):
        message = TwistStamped(twist=ahead) if stamped else ahead
        robot.bench.publish(type(message), "/cmd_vel", message, qos.DEFAULT)
        robot.run(0.1)
    assert [cost(robot, LOCAL, x, 0.01) for x in (-0.13, 0.0, 0.13)] == [FREE, FREE, LETHAL]


ZONES = {"plugin": "nav2_costmap_2d::KeepoutFilter", "filter_info_topic": "zone_info"}
SPEEDS = {"plugin": "nav2_costmap_2d::SpeedFilter", "filter_info_topic": "speed_info"}


def inform(robot: PlayedRobot, topic: str, kind: int, mask: str, *weights: float) -> None:
    base, multiplier = weights or (0.0, 1.0)
    info = CostmapFilterInfo(type=kind, filter_mask_topic=mask, base=base, multiplier=multiplier)
    robot.bench.publish(CostmapFilterInfo, topic, info, qos.LATCHED)


def test_zones_and_speeds_come_by_masks_whose_topics_infos_name() -> None:
    layers = {"filters": ["zones", "speeds"], "zones": ZONES, "speeds": SPEEDS}
    robot = costmap(plugins=["inflation_layer"], **layers)
    limits = robot.bench.collect(SpeedLimit, "/speed_limit")
    robot.run(0.3)
    inform(robot, "/zone_info", 0, "/zones")
    inform(robot, "/speed_info", 1, "/speeds", 100.0, -1.0)
    robot.run(0.3)
    send(robot, "/zones", wall(1.0), "map")
    slow = OccupancyGrid(wall(0.0).frame, np.full((200, 200), 60, np.int8))
    send(robot, "/speeds", slow, "odom")
    robot.run(0.3)
    assert [cost(robot, LOCAL, x, 0.02) for x in (0.98, 1.02)] == [FREE, LETHAL]
    assert [(limit.percentage, limit.speed_limit) for limit in limits] == [(True, 40.0)]

    parameter = Parameter("inflation_layer.inflation_radius", value=0.3).to_parameter_msg()
    name = f"/{LOCAL}/{LOCAL}/set_parameters"
    robot.bench.call(SetParameters, name, SetParameters.Request(parameters=[parameter]))
    robot.run(0.3)
    assert cost(robot, LOCAL, 1.02, 0.02) == LETHAL, "what was built again keeps its mask"
    for on, expected in ((False, FREE), (True, LETHAL)):
        toggle = f"/{LOCAL}/zones/toggle_filter"
        assert robot.bench.call(SetBool, toggle, SetBool.Request(data=on)).success
        robot.run(0.3)
        assert cost(robot, LOCAL, 1.02, 0.02) == expected


HEIGHT, TABLE = 0.5, 0.7  # of the camera and of a table [m]
FIELDS = [PointField(name=n, offset=4 * k, datatype=7, count=1) for k, n in enumerate("xyz")]


def with_camera(**layer: Any) -> PlayedRobot:
    sources: dict[str, Any] = layer or {
        "voxel_layer.cloud.topic": "/camera/points",
        "voxel_layer.min_obstacle_height": 0.1,
        "voxel_layer.max_obstacle_height": 2.0,
        "voxel_layer.z_resolution": 0.2,
        "voxel_layer.publish_voxel_map": True,
    }
    robot = PlayedRobot({f"{LOCAL}/{LOCAL}": sources})
    optical = TransformStamped(child_frame_id="eye", header=header("base_link", 0.0))
    optical.transform.translation = Vector3(x=0.0, y=0.0, z=HEIGHT)
    optical.transform.rotation = Quaternion(x=-0.5, y=0.5, z=-0.5, w=0.5)  # z looks ahead
    robot.bench.publish(TFMessage, "/tf_static", TFMessage(transforms=[optical]), qos.TF_STATIC)
    robot.bring_up(LOCAL_COSTMAP)
    robot.send_map()
    robot.run(1.0)
    return robot


def see(robot: PlayedRobot, ahead: float, height: float) -> None:
    """Send a cloud of one point so far ahead, so high above the ground [m]."""
    point = np.array([0.0, HEIGHT - height, ahead], np.float32)
    size = {"height": 1, "width": 1, "point_step": 12, "row_step": 12}
    data = array.array("B", point.tobytes())
    stamped = header("eye", robot.now)
    cloud = PointCloud2(header=stamped, fields=FIELDS, data=data, is_dense=True, **size)
    robot.bench.publish(PointCloud2, "/camera/points", cloud, qos.SENSOR_PUBLISHER)
    robot.run(0.6)


def test_a_table_is_marked_until_it_is_seen_to_be_gone() -> None:
    robot = with_camera()
    assert cost(robot, LOCAL, 1.02, 0.02) == FREE
    see(robot, 1.02, TABLE)
    assert cost(robot, LOCAL, 1.02, 0.02) == LETHAL
    see(robot, 1.4, 0.0)  # the floor, seen below the table
    assert cost(robot, LOCAL, 1.02, 0.02) == LETHAL
    see(robot, 1.4, TABLE + 0.05)
    assert cost(robot, LOCAL, 1.02, 0.02) < LETHAL


def test_the_voxels_and_the_ends_of_rays_are_published() -> None:
    robot = with_camera()
    grids = robot.bench.latched(VoxelGrid, f"/{LOCAL}/voxel_grid")
    ends = robot.bench.collect(PointCloud2, f"/{LOCAL}/clearing_endpoints", qos.LATCHED)
    see(robot, 1.02, TABLE)
    cleared = np.frombuffer(ends[-1].data, np.float32)
    assert cleared == pytest.approx((1.02, 0.0, TABLE), abs=1e-3)
    assert ends[-1].header.frame_id == "odom"
    grid = grids[-1]
    assert (grid.size_x, grid.size_y, grid.size_z) == (60, 60, 10)
    columns = np.array(grid.data, np.uint32).reshape(60, 60)
    column, row = (
        int((at - low) / 0.05) for at, low in ((1.02, grid.origin.x), (0.02, grid.origin.y))
    )
    assert columns[row, column] >> 16 == 1 << int(TABLE / 0.2)


def test_voxels_fade_where_the_camera_looks_and_its_source_is_switched() -> None:
    eye = {"topic": "/camera/points", "clearing": True, "decay_acceleration": 5.0}
    layer = {
        "plugin": "spatio_temporal_voxel_layer/SpatioTemporalVoxelLayer",
        "voxel_decay": 15.0,
        "publish_voxel_map": True,
        "observation_sources": "eye",
        **{f"eye.{key}": value for key, value in eye.items()},
    }
    robot = with_camera(
        plugins=["fading"], **{f"fading.{key}": value for key, value in layer.items()}
    )
    voxels = robot.bench.collect(PointCloud2, f"/{LOCAL}/voxel_grid", qos.DEFAULT)
    see(robot, 1.02, TABLE)
    assert cost(robot, LOCAL, 1.02, 0.02) == LETHAL
    middle = np.frombuffer(voxels[-1].data, np.float32)
    assert middle == pytest.approx((1.025, 0.0, TABLE), abs=0.03)
    see(robot, 0.4, 0.0)  # the floor, outside of what the layer takes the camera to see
    robot.run(2.5)
    assert cost(robot, LOCAL, 1.02, 0.02) == FREE
    toggle = f"/{LOCAL}/eye/toggle_enabled"
    assert robot.bench.call(SetBool, toggle, SetBool.Request(data=False)).success
    see(robot, 1.02, TABLE)
    assert cost(robot, LOCAL, 1.02, 0.02) == FREE


def with_sonar() -> PlayedRobot:
    layer = {
        "plugins": ["range_layer", "inflation_layer"],
        "range_layer.topics": ["/sonar"],
        "range_layer.no_readings_timeout": 0.8,
        "inflation_layer.enabled": False,
    }
    robot = PlayedRobot({f"{LOCAL}/{LOCAL}": layer})
    left = TransformStamped(child_frame_id="ear", header=header("base_link", 0.0))
    left.transform.translation = Vector3(x=0.1, y=0.0, z=0.1)
    left.transform.rotation = Quaternion(z=math.sqrt(0.5), w=math.sqrt(0.5))  # it looks to the left
    robot.bench.publish(TFMessage, "/tf_static", TFMessage(transforms=[left]), qos.TF_STATIC)
    robot.bring_up(LOCAL_COSTMAP)
    robot.send_map()
    robot.run(0.6)
    return robot


def hear(robot: PlayedRobot, distance: float) -> None:
    """Send six readings."""
    for _ in range(6):
        reading = Range(
            header=header("ear", robot.now),
            field_of_view=0.3,
            min_range=0.1,
            max_range=3.0,
            range=distance,
        )
        robot.bench.publish(Range, "/sonar", reading, qos.SENSOR_PUBLISHER)
        robot.run(0.1)


def test_a_sonar_marks_what_it_hears_and_its_silence_is_reported() -> None:
    robot = with_sonar()
    hear(robot, 1.01)
    assert cost(robot, LOCAL, 0.12, 1.02) == LETHAL
    assert cost(robot, LOCAL, 0.12, 0.62) == FREE
    node = robot.nodes[f"{LOCAL}/{LOCAL}"]
    assert node.current(0.3) is not None
    robot.run(1.4)
    assert node.current(0.3) is None
    assert "no range on /sonar for" in node.why_not_current()
