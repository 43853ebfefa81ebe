"""The rest of the robot for tests of slam_toolbox: transforms and scans of a drive."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import MapMetaData
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.convert import scan_msg, se2_from_pose, seconds, time_msg, transform_msg
from arjuna_core.se2 import SE2
from arjuna_slam.nodes.slam_toolbox import SlamToolboxNode
from bringup.parameters.files import shipped_parameters
from tests.helpers.ros import RosBench
from tests.slam.slam_room import drive

DT = 0.1
LOG = drive(seed=8, laps=0.3)


class Robot:
    """The rest of the robot: transforms and scans of a drive through the room."""

    base = "base_footprint"  # its frame

    def __init__(self, bench: RosBench) -> None:
        self.bench = bench
        self.k = 0
        self.now = 0.0
        self._truths: dict[float, SE2] = {}
        self.maps = bench.collect(OccupancyGridMsg, "/map", qos.LATCHED)
        self.metadata = bench.collect(MapMetaData, "/map_metadata", qos.LATCHED)
        self.poses = bench.collect(PoseWithCovarianceStamped, "/pose")
        self.transforms: list[Any] = []
        bench.node.create_subscription(TFMessage, "/tf", self._on_tf, qos.TF)
        mount = transform_msg(SE2(), self.base, "lidar_link", 0.0)
        bench.publish(TFMessage, "/tf_static", TFMessage(transforms=[mount]), qos.TF_STATIC)

    def _on_tf(self, message: Any) -> None:
        self.transforms += [t for t in message.transforms if t.header.frame_id == "map"]

    def drive(self, steps: int) -> None:
        """Drive on: at each step time, odometry, then the scan."""
        for _ in range(steps):
            self.wait()
            self.send_odometry()
            self.send(self.scan())

    def wait(self) -> None:
        """Advance to the next scan of the drive."""
        self.bench.advance(DT)
        self.now += DT
        self.odometry, self.truth = LOG[self.k][1:]
        self._truths[round(self.now, 3)] = self.truth
        self.k += 1

    def send_odometry(self) -> None:
        transform = transform_msg(self.odometry, "odom", self.base, self.now)
        self.bench.publish(TFMessage, "/tf", TFMessage(transforms=[transform]), qos.TF)

    def scan(self) -> Any:
        """Return the scan of here and now."""
        message = scan_msg(LOG[self.k - 1][0], "lidar_link", DT)
        message.header.stamp = time_msg(self.now)
        return message

    def send(self, message: Any) -> None:
        self.bench.publish(LaserScan, "/scan", message, qos.SENSOR_PUBLISHER)

    def error(self) -> float:
        """Return how far off the last pose is [m]; the map begins where the drive does."""
        pose = se2_from_pose(self.poses[-1].pose.pose)
        truth = self._truths[round(seconds(self.poses[-1].header.stamp), 3)]
        return pose.distance(LOG[0][2].inverse() @ truth)

    def call(self, service: Any, name: str, /, **fields: Any) -> Any:
        return self.bench.call(service, f"/slam_toolbox/{name}", service.Request(**fields))


def started(robot: Robot, **values: Any) -> SlamToolboxNode:
    """Return an active node with the shipped parameters, and some of one's own over them."""
    shipped = shipped_parameters()["slam_toolbox"]
    node = SlamToolboxNode(robot.bench.process, {**shipped, **values})
    node.trigger_configure()
    robot.bench.process.drain()
    node.trigger_activate()
    robot.bench.process.drain()
    return node
