"""BasicNavigator: Nav2's actions and services as plain methods, under the original's names."""

# ruff: noqa: D102 - the names are the original's; each method is the action it names
from __future__ import annotations

import time
from typing import Any

from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Point, PoseStamped, PoseWithCovarianceStamped
from lifecycle_msgs.srv import GetState
from nav2_msgs.action import (
    AssistedTeleop,
    BackUp,
    ComputePathThroughPoses,
    ComputePathToPose,
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
from rclpy.qos import DurabilityPolicy, QoSProfile

from arjuna_core.ros.convert import duration_msg
from nav2_simple_commander.services import RobotServices
from nav2_simple_commander.task import SERVER_TIMEOUT, TaskResult

__all__ = ["BasicNavigator", "TaskResult"]


class BasicNavigator(RobotServices):
    """Sends one task at a time; ask `isTaskComplete()` until it is, then `getResult()`."""

    def __init__(self, node_name: str = "basic_navigator", namespace: str = "") -> None:
        super().__init__(node_name, namespace)
        self.initial_pose = PoseStamped()
        self.initial_pose.header.frame_id = "map"
        self.initial_pose_received = False
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(
            PoseWithCovarianceStamped, "amcl_pose", self._on_amcl_pose, latched
        )
        self._initial_pose = self.create_publisher(PoseWithCovarianceStamped, "initialpose", 10)

    def _on_amcl_pose(self, message: Any) -> None:
        self.initial_pose_received = True

    def setInitialPose(self, initial_pose: PoseStamped) -> None:
        self.initial_pose_received = False
        self.initial_pose = initial_pose
        self._setInitialPose()

    def _setInitialPose(self) -> None:
        message = PoseWithCovarianceStamped()
        message.header = self.initial_pose.header
        message.pose.pose = self.initial_pose.pose
        self.info("Publishing Initial Pose")
        self._initial_pose.publish(message)

    def goThroughPoses(self, poses: list[PoseStamped], behavior_tree: str = "") -> bool:
        goal = NavigateThroughPoses.Goal(poses=poses, behavior_tree=behavior_tree)
        return self._task.start(NavigateThroughPoses, "navigate_through_poses", goal)

    def goToPose(self, pose: PoseStamped, behavior_tree: str = "") -> bool:
        goal = NavigateToPose.Goal(pose=pose, behavior_tree=behavior_tree)
        return self._task.start(NavigateToPose, "navigate_to_pose", goal)

    def followWaypoints(self, poses: list[PoseStamped]) -> bool:
        goal = FollowWaypoints.Goal(poses=poses)
        return self._task.start(FollowWaypoints, "follow_waypoints", goal)

    def followGpsWaypoints(self, gps_poses: list[Any]) -> bool:
        goal = FollowGPSWaypoints.Goal(gps_poses=gps_poses)
        return self._task.start(FollowGPSWaypoints, "follow_gps_waypoints", goal)

    def spin(self, spin_dist: float = 1.57, time_allowance: int = 10) -> bool:
        goal = Spin.Goal(target_yaw=float(spin_dist), time_allowance=Duration(sec=time_allowance))
        return self._task.start(Spin, "spin", goal)

    def backup(
        self, backup_dist: float = 0.15, backup_speed: float = 0.025, time_allowance: int = 10
    ) -> bool:
        goal = _straight(BackUp.Goal(), backup_dist, backup_speed, time_allowance)
        return self._task.start(BackUp, "backup", goal)

    def driveOnHeading(
        self, dist: float = 0.15, speed: float = 0.025, time_allowance: int = 10
    ) -> bool:
        goal = _straight(DriveOnHeading.Goal(), dist, speed, time_allowance)
        return self._task.start(DriveOnHeading, "drive_on_heading", goal)

    def assistedTeleop(self, time_allowance: int = 30) -> bool:
        goal = AssistedTeleop.Goal(time_allowance=Duration(sec=time_allowance))
        return self._task.start(AssistedTeleop, "assisted_teleop", goal)

    def followPath(self, path: Any, controller_id: str = "", goal_checker_id: str = "") -> bool:
        goal = FollowPath.Goal(
            path=path, controller_id=controller_id, goal_checker_id=goal_checker_id
        )
        return self._task.start(FollowPath, "follow_path", goal)

    def dockRobotByPose(
        self, dock_pose: PoseStamped, dock_type: str, nav_to_dock: bool = True
    ) -> bool:
        goal = DockRobot.Goal(
            use_dock_id=False,
            dock_pose=dock_pose,
            dock_type=dock_type,
            navigate_to_staging_pose=nav_to_dock,
        )
        return self._task.start(DockRobot, "dock_robot", goal)

    def dockRobotByID(self, dock_id: str, nav_to_dock: bool = True) -> bool:
        goal = DockRobot.Goal(
            use_dock_id=True, dock_id=dock_id, navigate_to_staging_pose=nav_to_dock
        )
        return self._task.start(DockRobot, "dock_robot", goal)

    def undockRobot(self, dock_type: str = "") -> bool:
        return self._task.start(UndockRobot, "undock_robot", UndockRobot.Goal(dock_type=dock_type))

    def cancelTask(self) -> None:
        self.info("Canceling current task.")
        self._task.end()

    def isTaskComplete(self) -> bool:
        return self._task.complete()

    def getFeedback(self) -> Any:
        return self._task.feedback

    def getResult(self) -> TaskResult:
        return self._task.outcome()

    def getTaskError(self) -> tuple[int, str]:
        return self._task.failure()

    @property
    def status(self) -> int | None:
        """The action status of the last task, None while it runs."""
        return self._task.status

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
        request = ComputePathToPose.Goal(
            start=start, goal=goal, planner_id=planner_id, use_start=use_start
        )
        result = self._task.finish(ComputePathToPose, "compute_path_to_pose", request)
        return None if result is None else result.path

    def getPathThroughPoses(
        self,
        start: PoseStamped,
        goals: list[PoseStamped],
        planner_id: str = "",
        use_start: bool = False,
    ) -> Any:
        request = ComputePathThroughPoses.Goal(
            start=start, goals=goals, planner_id=planner_id, use_start=use_start
        )
        result = self._task.finish(ComputePathThroughPoses, "compute_path_through_poses", request)
        return None if result is None else result.path

    def smoothPath(
        self,
        path: Any,
        smoother_id: str = "",
        max_duration: float = 2.0,
        check_for_collision: bool = False,
    ) -> Any:
        goal = SmoothPath.Goal(
            path=path,
            smoother_id=smoother_id,
            max_smoothing_duration=duration_msg(max_duration),
            check_for_collisions=check_for_collision,
        )
        result = self._task.finish(SmoothPath, "smooth_path", goal)
        return None if result is None else result.path


def _straight(goal: Any, distance: float, speed: float, time_allowance: int) -> Any:
    goal.target = Point(x=float(distance))
    goal.speed = float(speed)
    goal.time_allowance = Duration(sec=time_allowance)
    return goal
