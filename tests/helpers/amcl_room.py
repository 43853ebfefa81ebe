"""The rest of the robot around the amcl node under test: a map, transforms and scans."""

from __future__ import annotations

from typing import Any

import numpy as np
from arjuna_interfaces.msg import LocalizationQuality
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import (
    grid_msg,
    header,
    pose_msg,
    scan_msg,
    transform_msg,
)
from arjuna_core.se2 import SE2
from arjuna_slam.nodes.amcl import AmclNode
from tests.helpers.ros import RosBench
from tests.slam.amcl.room import DT, Robot, error, room_map

ROOM = room_map()


class Room:
    """The rest of the robot: a map, transforms and scans for the node under test."""

    def __init__(self, bench: RosBench) -> None:
        self.bench = bench
        self.robot = Robot(np.random.default_rng(3))
        self.poses = bench.collect(PoseWithCovarianceStamped, "amcl_pose", qos.LATCHED)
        self.qualities = bench.collect(LocalizationQuality, "amcl/localization_quality")
        self.transforms: list[Any] = []
        bench.node.create_subscription(TFMessage, "/tf", self._on_tf, qos.TF)
        mount = transform_msg(SE2(), "base_footprint", "lidar_link", 0.0)
        bench.publish(TFMessage, "/tf_static", TFMessage(transforms=[mount]), qos.TF_STATIC)

    def _on_tf(self, message: Any) -> None:
        self.transforms += [t for t in message.transforms if t.header.frame_id == "map"]

    def publish_map(self, grid: OccupancyGrid = ROOM) -> None:
        message = grid_msg(grid, "map", 0.0)
        self.bench.publish(OccupancyGridMsg, "map", message, qos.LATCHED)

    def publish_odometry(self) -> None:
        odometry = transform_msg(self.robot.odometry, "odom", "base_footprint", self.robot.now)
        self.bench.publish(TFMessage, "/tf", TFMessage(transforms=[odometry]), qos.TF)

    def publish_scan(self, scan: Any) -> None:
        message = scan_msg(scan, "lidar_link", DT)
        self.bench.publish(LaserScan, "scan", message, qos.SENSOR_PUBLISHER)

    def drive(self, steps: int) -> None:
        for _ in range(steps):
            self.bench.advance(DT)
            scan = self.robot.step()
            self.publish_odometry()
            self.publish_scan(scan)

    def put_robot(self, pose: SE2, frame: str = "map") -> None:
        message = PoseWithCovarianceStamped(header=header(frame, self.robot.now))
        message.pose.pose = pose_msg(pose)
        message.pose.covariance[0] = message.pose.covariance[7] = 0.25
        message.pose.covariance[35] = 0.0685
        self.bench.publish(PoseWithCovarianceStamped, "initialpose", message, qos.DEFAULT)

    @property
    def error(self) -> tuple[float, float]:
        pose = self.bench.process.transforms.lookup("map", "base_footprint")
        return error(pose, self.robot.pose)


def started(room: Room, with_map: bool = True, **values: Any) -> AmclNode:
    """An active node; the map comes as in a bring-up, between configuration and activation."""
    node = AmclNode(room.bench.process, values)
    node.trigger_configure()
    room.bench.process.drain()
    if with_map:
        room.publish_map()
    node.trigger_activate()
    room.bench.process.drain()
    return node
