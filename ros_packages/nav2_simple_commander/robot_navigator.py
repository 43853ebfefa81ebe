"""BasicNavigator: Nav2's actions and services as plain methods, under the original's names."""

# ruff: noqa: F401 - scripts import what its module imports
from __future__ import annotations

import time
from enum import Enum
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Point, PoseStamped, PoseWithCovarianceStamped
from lifecycle_msgs.srv import GetState
from nav2_msgs.action import (
    AssistedTeleop,
    BackUp,
    ComputeAndTrackRoute,
    ComputePathThroughPoses,
    ComputePathToPose,
    ComputeRoute,
    DockRobot,
    DriveOnHeading,
    FollowGPSWaypoints,
    FollowPath,
    FollowWaypoints,
    NavigateThroughPoses,
    NavigateToPose,
    SmoothPath,
    Spin,
    UndockRobot,
)
from nav2_msgs.srv import (
    ClearCostmapAroundRobot,
    ClearCostmapExceptRegion,
    ClearEntireCostmap,
    GetCostmap,
    LoadMap,
    ManageLifecycleNodes,
)
from rclpy.action import ActionClient
from rclpy.duration import Duration as rclpyDuration
from rclpy.node import Node
from rclpy.qos import (
    QoSDurabilityPolicy,
    QoSHistoryPolicy,
    QoSProfile,
    QoSReliabilityPolicy,
)

from arjuna_core.ros.convert import duration_msg
from nav2_simple_commander.routes import RouteRobot
from nav2_simple_commander.task import SERVER_TIMEOUT, RunningTask, TaskResult

__all__ = ["BasicNavigator", "NavigationResult", "RunningTask", "TaskResult"]
NavigationResult = TaskResult
"""Its name in Galactic, as `isNavComplete` and `cancelNav` below."""

_CLIENTS = {
    "nav_through_poses_client": (NavigateThroughPoses, "navigate_through_poses"),
    "nav_to_pose_client": (NavigateToPose, "navigate_to_pose"),
    "follow_waypoints_client": (FollowWaypoints, "follow_waypoints"),
    "follow_gps_waypoints_client": (FollowGPSWaypoints, "follow_gps_waypoints"),
    "follow_path_client": (FollowPath, "follow_path"),
    "compute_path_to_pose_client": (ComputePathToPose, "compute_path_to_pose"),
    "compute_path_through_poses_client": (ComputePathThroughPoses, "compute_path_through_poses"),
    "compute_route_client": (ComputeRoute, "compute_route"),
    "compute_and_track_route_client": (ComputeAndTrackRoute, "compute_and_track_route"),
    "smoother_client": (SmoothPath, "smooth_path"),
    "spin_client": (Spin, "spin"),
    "backup_client": (BackUp, "backup"),
    "drive_on_heading_client": (DriveOnHeading, "drive_on_heading"),
    "assisted_teleop_client": (AssistedTeleop, "assisted_teleop"),
    "docking_client": (DockRobot, "dock_robot"),
    "undocking_client": (UndockRobot, "undock_robot"),
}


class BasicNavigator(RouteRobot):
    """Sends one task at a time; ask `isTaskComplete()` until it is, then `getResult()`.

    Attributes:
        goal_handle: Of the last goal, as the action client returns it; programs may set it.
        result_future: The future of its result; None before the first goal, and of a rejected one.
        feedback: The newest, also where it is of the goal before.
        status: The status with which the goal ended, None while it runs.
    """

    def __init__(self, node_name: str = "basic_navigator", namespace: str = "") -> None:
        super().__init__(node_name, namespace)
        self.goal_handle: Any = None
        self.result_future: Any = None
        self.feedback: Any = None
        self.status: int | None = None
        for attribute, (action, name) in _CLIENTS.items():
            setattr(self, attribute, ActionClient(self, action, name))
        self.initial_pose = PoseStamped()
        self.initial_pose.header.frame_id = "map"
        self.initial_pose_received = False
        latched = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
        self.localization_pose_sub = self.create_subscription(
            PoseWithCovarianceStamped, "amcl_pose", self._amclPoseCallback, latched
        )
        self.initial_pose_pub = self.create_publisher(PoseWithCovarianceStamped, "initialpose", 10)

    def destroy_node(self) -> None:
        for attribute in _CLIENTS:
            getattr(self, attribute).destroy()
        super().destroy_node()

    def _start(self, client: str, goal: Any, doing: str) -> bool:
        self.info(f"{doing}...")
        return self._task.start(getattr(self, client), goal)

    def _amclPoseCallback(self, msg: Any) -> None:
        self.initial_pose_received = True

    def _feedbackCallback(self, msg: Any) -> None:
        self.feedback = msg.feedback

    def setInitialPose(self, initial_pose: PoseStamped) -> None:
        self.initial_pose_received = False
        self.initial_pose = initial_pose
        self._setInitialPose()

    def _setInitialPose(self) -> None:
        message = PoseWithCovarianceStamped()
        message.header = self.initial_pose.header
        message.pose.pose = self.initial_pose.pose
        self.info("Publishing Initial Pose")
        self.initial_pose_pub.publish(message)

    def goThroughPoses(self, poses: list[PoseStamped], behavior_tree: str = "") -> bool:
        goal = NavigateThroughPoses.Goal(poses=poses, behavior_tree=behavior_tree)
        return self._start("nav_through_poses_client", goal, f"Navigating with {len(poses)} goals.")

    def goToPose(self, pose: PoseStamped, behavior_tree: str = "") -> bool:
        goal, at = NavigateToPose.Goal(pose=pose, behavior_tree=behavior_tree), pose.pose.position
        return self._start("nav_to_pose_client", goal, f"Navigating to goal: {at.x} {at.y}")

    def followWaypoints(self, poses: list[PoseStamped]) -> bool:
        goal = FollowWaypoints.Goal(poses=poses)
        return self._start("follow_waypoints_client", goal, f"Following {len(poses)} goals.")

    def followGpsWaypoints(self, gps_poses: list[Any]) -> bool:
        goal, doing = FollowGPSWaypoints.Goal(gps_poses=gps_poses), f"{len(gps_poses)} gps goals."
        return self._start("follow_gps_waypoints_client", goal, f"Following {doing}")

    def spin(self, spin_dist: float = 1.57, time_allowance: float = 10) -> bool:
        goal = Spin.Goal(target_yaw=float(spin_dist), time_allowance=duration_msg(time_allowance))
        return self._start("spin_client", goal, f"Spinning to angle {goal.target_yaw}.")

    def backup(
        self, backup_dist: float = 0.15, backup_speed: float = 0.025, time_allowance: float = 10
    ) -> bool:
        goal = _straight(BackUp.Goal(), backup_dist, backup_speed, time_allowance)
        return self._start("backup_client", goal, f"Backing up {backup_dist} m, {backup_speed} m/s")

    def driveOnHeading(
        self, dist: float = 0.15, speed: float = 0.025, time_allowance: float = 10
    ) -> bool:
        goal = _straight(DriveOnHeading.Goal(), dist, speed, time_allowance)
        return self._start(
            "drive_on_heading_client", goal, f"Drive {dist} m on heading, {speed} m/s"
        )

    def assistedTeleop(self, time_allowance: float = 30) -> bool:
        goal = AssistedTeleop.Goal(time_allowance=duration_msg(time_allowance))
        return self._start("assisted_teleop_client", goal, "Running 'assisted_teleop'")

    def followPath(self, path: Any, controller_id: str = "", goal_checker_id: str = "") -> bool:
        goal = FollowPath.Goal(
            path=path, controller_id=controller_id, goal_checker_id=goal_checker_id
        )
        return self._start("follow_path_client", goal, "Executing path")

    def dockRobotByPose(
        self, dock_pose: PoseStamped, dock_type: str, nav_to_dock: bool = True
    ) -> bool:
        goal = DockRobot.Goal(
            use_dock_id=False,
            dock_pose=dock_pose,
            dock_type=dock_type,
            navigate_to_staging_pose=nav_to_dock,
        )
        return self._start("docking_client", goal, f"Docking at pose: {dock_pose}")

    def dockRobotByID(self, dock_id: str, nav_to_dock: bool = True) -> bool:
        goal = DockRobot.Goal(
            use_dock_id=True, dock_id=dock_id, navigate_to_staging_pose=nav_to_dock
        )
        return self._start("docking_client", goal, f"Docking at dock ID: {dock_id}")

    def undockRobot(self, dock_type: str = "") -> bool:
        goal = UndockRobot.Goal(dock_type=dock_type)
        return self._start("undocking_client", goal, f"Undocking from dock of type: {dock_type}")

    def cancelTask(self) -> None:
        self.info("Canceling current task.")
        self._task.end()
        self._route.end()

    def isTaskComplete(self, task: Any = None, trackingRoute: bool = False) -> bool:
        """Return whether the task has ended: that of a route, or the one there is beside it."""
        is_route = trackingRoute or task is RunningTask.COMPUTE_AND_TRACK_ROUTE
        return (self._route if is_route else self._task).complete()

    isNavComplete, cancelNav = isTaskComplete, cancelTask

    def getFeedback(self, task: Any = None, trackingRoute: bool = False) -> Any:
        """Return the newest feedback; of a route the oldest that was not taken yet, or None."""
        if trackingRoute or task is RunningTask.COMPUTE_AND_TRACK_ROUTE:
            return self.route_feedback.pop(0) if self.route_feedback else None
        return self.feedback

    def getResult(self) -> TaskResult:
        return self._task.outcome()

    def getTaskError(self) -> tuple[int, str]:
        return self._task.failure()

    def waitUntilNav2Active(self, navigator: str = "bt_navigator", localizer: str = "amcl") -> None:
        if localizer != "robot_localization":
            self._waitForNodeToActivate(localizer)
        if localizer == "amcl":
            self._waitForInitialPose()
        self._waitForNodeToActivate(navigator)
        self.info("Nav2 is ready for use!")

    def _waitForNodeToActivate(self, node_name: str) -> None:
        self._task.run_until(
            lambda: self._call(GetState, f"{node_name}/get_state").current_state.label == "active",
            SERVER_TIMEOUT,
            f"'{node_name}' in the state active",
        )

    def _waitForInitialPose(self, period: float = 1.0) -> None:
        """Send the initial pose once a period [s] until AMCL has taken it."""
        sent_at = float("-inf")

        def received() -> bool:
            nonlocal sent_at
            if not self.initial_pose_received and time.monotonic() - sent_at >= period:
                sent_at = time.monotonic()
                self._setInitialPose()  # its subscriber may have come just now
            return self.initial_pose_received

        self._task.run_until(received, SERVER_TIMEOUT, "a pose on 'amcl_pose'")

    def getPath(
        self, start: PoseStamped, goal: PoseStamped, planner_id: str = "", use_start: bool = False
    ) -> Any:
        return self._path_of(self._getPathImpl(start, goal, planner_id, use_start))

    def _getPathImpl(
        self, start: PoseStamped, goal: PoseStamped, planner_id: str = "", use_start: bool = False
    ) -> Any:
        """Return the whole result, with an error code where there is no path."""
        request = ComputePathToPose.Goal(
            start=start, goal=goal, planner_id=planner_id, use_start=use_start
        )
        return self._finish("compute_path_to_pose_client", request, "Getting path")

    def getPathThroughPoses(
        self,
        start: PoseStamped,
        goals: list[PoseStamped],
        planner_id: str = "",
        use_start: bool = False,
    ) -> Any:
        return self._path_of(self._getPathThroughPosesImpl(start, goals, planner_id, use_start))

    def _getPathThroughPosesImpl(
        self,
        start: PoseStamped,
        goals: list[PoseStamped],
        planner_id: str = "",
        use_start: bool = False,
    ) -> Any:
        request = ComputePathThroughPoses.Goal(
            start=start, goals=goals, planner_id=planner_id, use_start=use_start
        )
        return self._finish("compute_path_through_poses_client", request, "Getting path")

    def smoothPath(
        self,
        path: Any,
        smoother_id: str = "",
        max_duration: float = 2.0,
        check_for_collision: bool = False,
    ) -> Any:
        return self._path_of(
            self._smoothPathImpl(path, smoother_id, max_duration, check_for_collision)
        )

    def _smoothPathImpl(
        self,
        path: Any,
        smoother_id: str = "",
        max_duration: float = 2.0,
        check_for_collision: bool = False,
    ) -> Any:
        goal = SmoothPath.Goal(
            path=path,
            smoother_id=smoother_id,
            max_smoothing_duration=rclpyDuration(seconds=max_duration).to_msg(),
            check_for_collisions=check_for_collision,
        )
        return self._finish("smoother_client", goal, "Smoothing path")

    def _finish(self, client: str, goal: Any, doing: str) -> Any:
        self.info(f"{doing}...")
        return self._task.finish(getattr(self, client), goal)

    def _path_of(self, result: Any) -> Any:
        """Return a result's path, or None where the task failed."""
        if self.status == GoalStatus.STATUS_SUCCEEDED:
            return result.path
        self.warn(f"Getting path failed with status code: {self.status}")
        return None


def _straight(goal: Any, distance: float, speed: float, time_allowance: float) -> Any:
    goal.target = Point(x=float(distance))
    goal.speed = float(speed)
    goal.time_allowance = duration_msg(time_allowance)
    return goal
