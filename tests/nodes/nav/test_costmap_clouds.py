"""Costmap nodes that listen to a depth camera beside the lidar."""

from __future__ import annotations

import array

import numpy as np
import pytest
from geometry_msgs.msg import Quaternion, TransformStamped, Vector3
from nav2_msgs.msg import VoxelGrid
from sensor_msgs.msg import PointCloud2, PointField
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from bringup.stack import LOCAL_COSTMAP
from tests.helpers.nav.costmaps import FREE, LETHAL, LOCAL, cost
from tests.helpers.nav.navigation import PlayedRobot

HEIGHT, TABLE = 0.5, 0.7  # of the camera and of a table [m]
FIELDS = [PointField(name=n, offset=4 * k, datatype=7, count=1) for k, n in enumerate("xyz")]


def made() -> PlayedRobot:
    sources = {
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


def see(robot: PlayedRobot, ahead: float, height: float, **layout: int) -> None:
    """Send a cloud of one point so far ahead, so high above the ground [m]."""
    point = np.array([0.0, HEIGHT - height, ahead], np.float32)
    size = {"height": 1, "width": 1, "point_step": 12, "row_step": 12, **layout}
    data = array.array("B", point.tobytes())
    stamped = header("eye", robot.now)
    cloud = PointCloud2(header=stamped, fields=FIELDS, data=data, is_dense=True, **size)
    robot.bench.publish(PointCloud2, "/camera/points", cloud, qos.SENSOR_PUBLISHER)
    robot.run(0.6)


def test_a_table_is_marked_until_it_is_seen_to_be_gone(robot: PlayedRobot) -> None:
    assert cost(robot, LOCAL, 1.02, 0.02) == FREE
    see(robot, 1.02, TABLE)
    assert cost(robot, LOCAL, 1.02, 0.02) == LETHAL
    see(robot, 1.4, 0.0)  # the floor, seen below the table
    assert cost(robot, LOCAL, 1.02, 0.02) == LETHAL
    see(robot, 1.4, TABLE + 0.05)
    assert cost(robot, LOCAL, 1.02, 0.02) < LETHAL


def test_the_voxels_and_the_ends_of_rays_are_published(robot: PlayedRobot) -> None:
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


def test_a_cloud_whose_layout_cannot_be_is_refused(robot: PlayedRobot) -> None:
    see(robot, 1.02, TABLE, width=2**20)
    assert cost(robot, LOCAL, 1.02, 0.02) == FREE
    see(robot, 1.02, TABLE)
    assert cost(robot, LOCAL, 1.02, 0.02) == LETHAL
