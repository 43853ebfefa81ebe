"""A robot whose collision monitor sees by one source of a kind alone, as a scan or a costmap."""

from __future__ import annotations

import array
import math
from typing import Any

import numpy as np
from geometry_msgs.msg import Point32, Polygon, PolygonInstance, PolygonInstanceStamped, Twist
from nav2_msgs.msg import Costmap
from sensor_msgs.msg import LaserScan, PointCloud2, Range

from arjuna_core.grid import GridFrame
from arjuna_core.ros import qos
from arjuna_core.ros.convert import cloud_msg, header
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from arjuna_nav.costmap import Costmap as CostGrid
from arjuna_nav.nodes.costmap.messages import costmap_raw_msg
from bringup.parameters.files import shipped_parameters
from bringup.stack import COLLISION_MONITOR, LOCAL_COSTMAP
from tests.helpers.nav.navigation import PlayedRobot

KINDS = {"scan": LaserScan, "pointcloud": PointCloud2, "range": Range,
         "polygon": PolygonInstanceStamped, "costmap": Costmap}  # fmt: skip
BODY, RADIUS, ZONE = 0.25, 0.1, 0.55  # of the robot, the obstacle and the zone [m]
STOP = {"type": "circle", "action_type": "stop", "radius": ZONE, "min_points": 1}
FOV = 1.2  # of the range sensor [rad]


def drive(robot: PlayedRobot, v: float, duration: float, yaw_rate: float = 0.0) -> None:
    """Command a speed at 25 Hz."""
    message = Twist()
    message.linear.x, message.angular.z = v, yaw_rate
    for _ in range(round(duration / 0.04)):
        robot.bench.publish(Twist, "/cmd_vel_smoothed", message)
        robot.run(0.04)


def cloud(points: list[tuple[float, float, float]], stamp: float) -> PointCloud2:
    """Return a cloud of points in the lidar's frame."""
    return cloud_msg(np.array(points).reshape(-1, 3), "lidar_link", stamp)


def costs(cells: list[tuple[float, float, int]], stamp: float) -> Costmap:
    """Return a costmap about the robot that costs nothing but within RADIUS of some points."""
    frame = GridFrame(0.05, 80, 80, SE2(-2.0, -2.0))
    data = np.zeros(frame.shape, np.uint8)
    points = frame.to_points(np.indices(frame.shape).reshape(2, -1).T)
    for x, y, cost in cells:
        near = np.hypot(*(points - (x, y)).T) <= RADIUS
        data[near.reshape(frame.shape)] = cost
    return costmap_raw_msg(CostGrid(frame, data, stamp), "base_link", stamp)


def message(kind: str, at: tuple[float, float] | None, stamp: float) -> Any:
    """Return what a source says of a round obstacle, seen from the robot; None for none."""
    distance = math.inf if at is None else math.hypot(*at) - RADIUS
    bearing = 0.0 if at is None else math.atan2(at[1], at[0])
    if kind == "scan":
        angles = np.arange(-180, 180) * math.pi / 180.0
        width = math.asin(min(RADIUS / max(distance + RADIUS, RADIUS), 1.0))
        ranges = np.where(np.abs(angles - bearing) <= max(width, 0.02), distance, np.inf)
        return LaserScan(header=header("lidar_link", stamp), angle_min=-math.pi,
            angle_max=math.pi, angle_increment=math.pi / 180.0, range_min=0.05, range_max=12.0,
            ranges=array.array("f", ranges.astype(np.float32).tobytes()))  # fmt: skip
    if kind == "pointcloud":
        above = [(0.35, 0.0, 0.9), (0.35, 0.1, 0.01)]  # a table's top and the floor
        seen = (
            []
            if at is None
            else [(distance * math.cos(bearing), distance * math.sin(bearing), 0.3)]
        )
        return cloud(above + seen, stamp)
    if kind == "costmap":
        return costs([] if at is None else [(*at, 254)], stamp)
    if kind == "range":
        return Range(header=header("lidar_link", stamp), field_of_view=FOV, min_range=0.02,
            max_range=4.0, range=float(distance))  # fmt: skip
    turns = np.arange(8) * math.pi / 4.0
    middle = (9.0, 9.0) if at is None else at
    corners = [Point32(x=middle[0] + RADIUS * math.cos(t), y=middle[1] + RADIUS * math.sin(t))
               for t in turns]  # fmt: skip
    instance = PolygonInstance(id=3, polygon=Polygon(points=corners))
    return PolygonInstanceStamped(header=header("lidar_link", stamp), polygon=instance)


class Monitored:
    """A robot that sees by one source alone."""

    def __init__(self, kind: str, **values: Any) -> None:
        own = {"type": kind, "topic": "/it"}
        monitor = {"observation_sources": ["it"], "it": own, "polygons": ["Stop"], "Stop": STOP,
                   "source_timeout": 0.5}  # fmt: skip
        self.kind = kind
        ours = {**shipped_parameters(), "collision_monitor": {**monitor, **values}}
        self.robot = PlayedRobot(ours, shipped=False)
        self.robot.bring_up(LOCAL_COSTMAP, COLLISION_MONITOR)
        self.obstacle: tuple[float, float] | None = None

    def say(self) -> None:
        """Publish what the source sees from where the robot is."""
        robot = self.robot
        at = None
        if self.obstacle is not None:
            x, y = robot.pose.inverse().apply(np.array([self.obstacle]))[0]
            at = float(x), float(y)
        profile = qos.LATCHED if self.kind == "costmap" else qos.DEFAULT
        robot.bench.publish(KINDS[self.kind], "/it", message(self.kind, at, robot.now), profile)

    def drive(self, v: float, duration: float) -> None:
        """Command a speed and publish what the source sees."""
        for _ in range(round(duration / 0.1)):
            self.say()
            drive(self.robot, v, 0.1)

    def gap_at_rest(self, seed: int) -> float:
        """Return how far before a random obstacle it stops [m]; NaN where it does not.

        Raises:
            AssertionError: It stands where nothing is.
        """
        rng, robot = np.random.default_rng(seed), self.robot
        robot.pose = SE2.from_array(rng.uniform(-3.0, 3.0, 3))
        self.obstacle = None
        self.drive(0.3, 0.4)
        assert abs(robot.command.x - 0.3) < 1e-6, "it stands before nothing"
        bearing, distance = rng.uniform(-0.3, 0.3), rng.uniform(0.8, 1.4)
        at = robot.pose @ SE2(distance * math.cos(bearing), distance * math.sin(bearing))
        self.obstacle = at.x, at.y
        self.drive(0.3, 5.0)
        gap = robot.pose.distance(at) - RADIUS - BODY
        return gap if robot.command == STILL else math.nan
