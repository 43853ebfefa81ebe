"""TurtleBot4Navigator: BasicNavigator that docks, and waits for what it starts."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import Any

import rclpy
from geometry_msgs.msg import Pose, PoseStamped, PoseWithCovarianceStamped
from irobot_create_msgs.action import Dock, Undock
from irobot_create_msgs.msg import DockStatus
from nav2_simple_commander.robot_navigator import BasicNavigator, TaskResult
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.qos import qos_profile_sensor_data, qos_profile_system_default

from bringup.terminal import write

__all__ = ["TurtleBot4Directions", "TurtleBot4Navigator"]
_OUTCOMES = {
    TaskResult.SUCCEEDED: "Goal succeeded!",
    TaskResult.CANCELED: "Goal was canceled!",
    TaskResult.FAILED: "Goal failed!",
    TaskResult.UNKNOWN: "Goal has an invalid return status!",
}


class TurtleBot4Directions(IntEnum):
    """Headings in the map [deg]."""

    NORTH = 0
    NORTH_WEST = 45
    WEST = 90
    SOUTH_WEST = 135
    SOUTH = 180
    SOUTH_EAST = 225
    EAST = 270
    NORTH_EAST = 315


class TurtleBot4Navigator(BasicNavigator):
    """Navigates a TurtleBot 4."""

    creating_path = False

    def __init__(self, namespace: str = "") -> None:
        super().__init__(namespace=namespace)
        self.is_docked: bool | None = None
        self.new_pose: Pose | None = None
        self.dock_action_client = ActionClient(self, Dock, "dock")
        self.undock_action_client = ActionClient(self, Undock, "undock")
        self.create_subscription(
            DockStatus, "dock_status", self._dockCallback, qos_profile_sensor_data
        )
        self.create_subscription(
            PoseWithCovarianceStamped,
            "initialpose",
            self._poseEstimateCallback,
            qos_profile_system_default,
        )

    def getPoseStamped(self, position: Sequence[float], rotation: float) -> PoseStamped:
        """Return a pose of the map, by its heading [deg]."""
        pose = Pose()
        pose.position.x, pose.position.y = float(position[0]), float(position[1])
        half = math.radians(rotation) / 2.0
        pose.orientation.z, pose.orientation.w = math.sin(half), math.cos(half)
        return self.stampPose(pose)

    def stampPose(self, pose: Pose) -> PoseStamped:
        stamped = PoseStamped(pose=pose)
        stamped.header.frame_id = "map"
        stamped.header.stamp = self.get_clock().now().to_msg()
        return stamped

    def createPath(self) -> list[PoseStamped]:
        """Return the poses that RViz's "2D Pose Estimate" gives until Ctrl-C."""
        poses: list[PoseStamped] = []
        self.new_pose, self.creating_path = None, True
        self.info("Creating a path. Press CTRL+C to finish.")
        self.info('Use the "2D Pose Estimate" tool in Rviz to add a pose to the path.')
        try:
            while self.creating_path:
                rclpy.spin_once(self, timeout_sec=0.1)
                if self.new_pose is not None:
                    self.info("Pose added.")
                    poses.append(self.stampPose(self.new_pose))
                    self.new_pose = None
                    self.clearAllCostmaps()
        except KeyboardInterrupt:
            self.creating_path = False
        self.info("Path created.")
        for number, each in enumerate(poses):
            at, q = each.pose.position, each.pose.orientation
            values = f"[x,y]=[{at.x:.3f},{at.y:.3f}] [z,w]=[{q.z:.3f},{q.w:.3f}]"
            self.info(f"Pose {number} {values}")
        return poses

    def _poseEstimateCallback(self, msg: Any) -> None:
        if self.creating_path:
            self.new_pose = msg.pose.pose

    def _dockCallback(self, msg: Any) -> None:
        self.is_docked = msg.is_docked

    def getDockedStatus(self) -> bool:
        """Wait for the dock's status and return whether the robot is docked."""
        rclpy.spin_once(self, timeout_sec=0.1)
        while self.is_docked is None:
            rclpy.spin_once(self, timeout_sec=0.1)
        return self.is_docked

    def undock(self) -> None:
        self.info("Undocking...")
        self.undock_send_goal()
        while not self.isUndockComplete():
            pass

    def undock_send_goal(self) -> None:
        self._task.start(self.undock_action_client, Undock.Goal())

    def isUndockComplete(self) -> bool:
        return self._ended("Undock")

    def dock(self) -> None:
        self.info("Docking...")
        self.dock_send_goal()
        while not self.isDockComplete():
            pass

    def dock_send_goal(self) -> None:
        self._task.start(self.dock_action_client, Dock.Goal())

    def isDockComplete(self) -> bool:
        return self._ended("Dock")

    def _ended(self, what: str) -> bool:
        if not self.isTaskComplete():
            return False
        if self.getResult() == TaskResult.SUCCEEDED:
            self.info(f"{what} succeeded")
        else:
            self.info(f"{what} failed with status code: {self.status}")
        return True

    def startToPose(self, pose: PoseStamped) -> None:
        """Drive to a pose and print the time left until it ends."""
        self.goToPose(pose)
        self._follow(_time_left)

    def startThroughPoses(self, poses: list[PoseStamped]) -> None:
        """Drive through poses and print the time left until it ends."""
        self.goThroughPoses(poses)
        self._follow(_time_left)

    def startFollowWaypoints(self, poses: list[PoseStamped]) -> None:
        """Drive to poses one after the other and print which one until it ends."""
        self.followWaypoints(poses)
        self._follow(lambda feedback: _waypoint(feedback, len(poses)))

    def _follow(self, line_of: Callable[[Any], str], given_up: float = 600.0) -> None:
        """Print feedback until the task ends; cancel it after a time [s], as the original does."""
        looks = 0
        while not self.isTaskComplete():
            feedback, looks = self.getFeedback(), looks + 1
            if not feedback or looks % 5:
                continue
            write(line_of(feedback) + "\r")
            since = getattr(feedback, "navigation_time", None)
            if since and Duration.from_msg(since) > Duration(seconds=given_up):
                self.cancelTask()
        self.info(_OUTCOMES[self.getResult()])


def _time_left(feedback: Any) -> str:
    left = Duration.from_msg(feedback.estimated_time_remaining).nanoseconds / 1e9
    return f"Estimated time of arrival: {left:.0f}{'seconds.': <20}"


def _waypoint(feedback: Any, count: int) -> str:
    return f"Executing current waypoint: {feedback.current_waypoint + 1}/{count: <5}"
