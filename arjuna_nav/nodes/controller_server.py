"""Follows paths on the local costmap: follow_path."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, PointStamped
from nav2_msgs.action import FollowPath
from nav2_msgs.msg import SpeedLimit
from nav_msgs.msg import Odometry, Path

from arjuna_core.arrays import Floats
from arjuna_core.config import duration_param, fixed, param, speed_param, yaw_rate_param
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, seconds, velocity_from_twist
from arjuna_core.ros.goal_server import GoalError, GoalNode, chosen, result_timeout
from arjuna_core.ros.silence import Silence, subscribe_watched
from arjuna_core.ros.tf import TransformError
from arjuna_core.ros.velocity import VelocityOutput
from arjuna_core.se2 import SE2
from arjuna_core.twist import RecentVelocities, Velocity
from arjuna_nav.controllers import ControlStatus
from arjuna_nav.controllers.display import Plan, shown_by
from arjuna_nav.controllers.follower import (
    Chosen,
    FollowerConfig,
    FollowResult,
    FollowState,
    PathFollower,
)
from arjuna_nav.costmap import Costmap
from arjuna_nav.nodes.controller_display import ControllerDisplay
from arjuna_nav.nodes.costmap.node import CostmapNode
from arjuna_nav.nodes.frames import poses_of, robot_pose


@dataclass(frozen=True)
class ControllerServerConfig(FollowerConfig):
    """Parameters of the node `controller_server`, by Nav2's names."""

    action_server_result_timeout: float = result_timeout(10.0)
    costmap_update_timeout: float = duration_param(0.3, "How old the costmap may be.")
    cmd_vel_topic: str = fixed("cmd_vel_nav", "Topic of what to drive; velocity_smoother listens.")
    enable_stamped_cmd_vel: bool = fixed(False, "Whether cmd_vel is TwistStamped.")
    use_realtime_priority: bool = fixed(
        False, "Whether its process runs before all others of the machine."
    )
    odom_topic: str = fixed("odom", "Topic of the odometry.")
    odom_duration: float = duration_param(
        0.0, "Time over which the mean of the odometry is taken; 0 for the newest."
    )
    speed_limit_topic: str = fixed("speed_limit", "Topic of speed limits.")
    min_x_velocity_threshold: float = speed_param(
        0.0001, "Measured forward speed below which it counts as 0."
    )
    min_y_velocity_threshold: float = speed_param(
        0.0001, "Measured sideways speed below which it counts as 0."
    )
    min_theta_velocity_threshold: float = yaw_rate_param(
        0.0001, "Measured yaw rate below which it counts as 0."
    )
    local_plan_time: float = duration_param(
        1.7, "How far ahead `local_plan` shows the motion, as Nav2's DWB.", minimum=0.1
    )
    publish_zero_velocity: bool = param(
        True, "Whether zero is commanded once a path is done with; on a cancel it always is."
    )


class ControllerServerNode(GoalNode):
    """Drives along the path of its goal at `controller_frequency`."""

    Config = ControllerServerConfig
    DEFAULT_NAME = "controller_server"

    def configure(self) -> None:
        config: ControllerServerConfig = self.config
        if config.use_realtime_priority:
            self.process.use_realtime_priority()
        self._follower: PathFollower | None = None
        self._outdated, self._warned = False, ""
        self._costmap: CostmapNode = self.process.find("local_costmap/local_costmap")
        self._velocity, self._recent = Velocity(), RecentVelocities(config.odom_duration)
        self._speed_limit = SpeedLimit()
        self._frame = ""
        self._unknown_since = math.inf
        self._output = VelocityOutput(
            self, config.enable_stamped_cmd_vel, topic=config.cmd_vel_topic
        )
        self._carrot_out = self.publisher(PointStamped, "lookahead_point", qos.LATEST)
        self._plan_out = self.publisher(Path, "received_global_plan", qos.LATEST)
        plugins = [getattr(config, name) for name in config.controller_plugins]
        self._display = ControllerDisplay(self, plugins)
        of = Silence(Odometry, "odometry message", qos.DEFAULT, "set odom_topic", rare=True)
        subscribe_watched(self, config.odom_topic, of, self._on_odometry)
        self.subscribe(SpeedLimit, config.speed_limit_topic, self._on_speed_limit, qos.DEFAULT)
        self._server = self.offer(
            FollowPath, "follow_path", self._on_goal, on_cancel=self._on_cancel
        )
        self.every(1.0 / config.controller_frequency, self._control)

    def halt(self) -> None:
        if self._server.goal is not None:
            self._output.stop()

    def on_config(self, config: ControllerServerConfig) -> None:
        self._outdated, self._recent = True, RecentVelocities(config.odom_duration)

    def _on_odometry(self, message: Any) -> None:
        config, measured = self.config, velocity_from_twist(message.twist.twist)
        self._recent.add(measured, seconds(message.header.stamp))
        velocity = self._recent.mean()
        x, y, w = velocity.x, velocity.y, velocity.yaw_rate
        self._velocity = Velocity(
            x if abs(x) > config.min_x_velocity_threshold else 0.0,
            y=y if abs(y) > config.min_y_velocity_threshold else 0.0,
            yaw_rate=w if abs(w) > config.min_theta_velocity_threshold else 0.0,
        )

    def _on_speed_limit(self, message: Any) -> None:
        """Take a limit, absolute [m/s] or in per cent of the desired speed; 0 lifts it."""
        self._speed_limit = message
        if self._follower is not None:
            self._limit(self._follower)

    def _limit(self, follower: PathFollower) -> None:
        limit = self._speed_limit.speed_limit
        if self._speed_limit.percentage:
            limit *= follower.controller.desired_speed / 100.0
        follower.speed_limit = limit if limit > 0.0 else math.inf

    def _on_goal(self) -> None:
        replaced = self._server.preempt_requested
        goal = self._server.take_newest()
        try:
            plugins, poses = self._checked(goal)
        except GoalError as error:
            self._end(error)
            return
        self._frame = goal.path.header.frame_id.lstrip("/")
        self._plugin = getattr(self.config, plugins.controller)
        shows = getattr(self._plugin, "publish_global_plan", True)
        if shows and self._plan_out.get_subscription_count():
            self._plan_out.publish(goal.path)
        self._take(poses, plugins, replaced)

    def _checked(self, goal: Any) -> tuple[Chosen, Floats]:
        """Return the plug-ins and the path of a goal.

        Raises:
            GoalError: It cannot be followed.
        """
        config: ControllerServerConfig = self.config
        invalid, unknown = ControlStatus.INVALID_CONTROLLER, ControlStatus.UNKNOWN
        plugins = Chosen(
            chosen("controller", goal.controller_id, config.controller_plugins, invalid),
            chosen("goal checker", goal.goal_checker_id, config.goal_checker_plugins, unknown),
            chosen(
                "progress checker",
                goal.progress_checker_id,
                config.progress_checker_plugins,
                unknown,
            ),
        )
        if not self._costmap.active:
            raise GoalError(ControlStatus.CONTROLLER_TIMED_OUT, self._costmap.why_not_current())
        return plugins, poses_of(goal.path, ControlStatus.INVALID_PATH)

    def _take(self, poses: Floats, chosen: Chosen, replaced: bool) -> None:
        """Follow a path; one that replaces another keeps what was reached and the progress."""
        kept = self._follower if replaced and not self._outdated else None
        if kept is not None and kept.chosen == chosen:
            kept.change(poses)
            return
        self._unknown_since, self._outdated = math.inf, False
        footprint = self._costmap.layered.footprint
        self._follower = PathFollower(self.config, footprint, chosen, self._costmap.layered.body)
        if self._follower.warning and self._follower.warning != self._warned:
            self.get_logger().warning(self._follower.warning)
        self._warned = self._follower.warning
        self._limit(self._follower)
        self._follower.start(poses, self.now)

    def _on_cancel(self) -> None:
        follower, lost = self._follower, math.isfinite(self._unknown_since)
        if self._server.cancel_requested and (follower is None or lost or follower.cancel()):
            self._output.stop()
            self._server.cancel(FollowPath.Result())

    def _control(self) -> None:
        self._on_cancel()
        if self._server.goal is None or self._follower is None:
            return
        try:
            result = self._follow(self._follower)
            if result.state is FollowState.FAILED:
                raise GoalError(result.error, result.message)
        except GoalError as error:
            self._end(error)
            return
        if result.state is FollowState.SUCCEEDED:
            self._end()
            return
        self._output.publish(result.velocity)
        self._publish_carrot(self._follower.controller.carrot)
        shown = shown_by(self._follower.controller)
        self._display.publish(shown, self._frame, self.now)
        if "local_plan" not in shown and getattr(self._plugin, "publish_local_plan", True):
            self._publish_local_plan(result.velocity)
        self._server.feedback(
            FollowPath.Feedback(distance_to_goal=result.distance, speed=result.velocity.speed)
        )

    def _publish_carrot(self, carrot: SE2 | None) -> None:
        if carrot is None or self._carrot_out.get_subscription_count() == 0:
            return
        stamp = header(self._costmap.config.robot_base_frame, self.now)
        axle = self._costmap.layered.footprint.axle
        point = Point(x=carrot.x + axle, y=carrot.y)
        self._carrot_out.publish(PointStamped(header=stamp, point=point))

    def _publish_local_plan(self, velocity: Velocity) -> None:
        """Show what the robot drives if the command holds, whatever controller gave it."""
        if self._follower is None or "local_plan" not in self._follower.wanted:
            return
        times = np.linspace(0.0, self.config.local_plan_time, 18)
        v = self._costmap.layered.footprint.base_velocity(velocity)
        poses = [SE2.exp((v.x * t, v.y * t, v.yaw_rate * t)).array() for t in times]
        plan = {"local_plan": Plan(np.array(poses))}
        self._display.publish(plan, self._costmap.config.robot_base_frame, self.now)

    def _follow(self, follower: PathFollower) -> FollowResult:
        """Ask the follower; at rest while the pose or the costmap is missing for a short time."""
        try:
            pose, placed = self._surroundings()
        except GoalError:
            self._unknown_since = min(self._unknown_since, self.now)
            tolerance, waited = self.config.failure_tolerance, self.now - self._unknown_since
            if tolerance == -1.0 or waited <= max(tolerance, self.config.costmap_update_timeout):
                return FollowResult(FollowState.RUNNING)
            raise
        self._unknown_since = math.inf
        follower.wanted = self._display.wanted()
        return follower.tick(pose, self._velocity, placed, self.now)

    def _surroundings(self) -> tuple[SE2, Costmap]:
        """Return the robot's pose and the costmap in the path's frame.

        Raises:
            GoalError: One of them is not known, or too old.
        """
        config, frame = self._costmap.config, self._frame
        try:
            self._costmap.robot_pose()  # it may be known in the path's frame and yet be old
            own = getattr(self._plugin, "transform_tolerance", 0.0)
            tolerance = max(config.transform_tolerance, own)
            pose = robot_pose(self, frame, config.robot_base_frame, tolerance)
            T_path_costmap = self.transforms.lookup(frame, config.global_frame)
        except TransformError as error:
            message = f"the robot's pose is not known: {error}"
            raise GoalError(ControlStatus.TF_ERROR, message) from error
        costmap = self._costmap.current(self.config.costmap_update_timeout)
        if costmap is None:
            message = self._costmap.why_not_current()
            raise GoalError(ControlStatus.CONTROLLER_TIMED_OUT, message)
        return pose, costmap.seen_from(T_path_costmap)

    def _end(self, error: GoalError | None = None) -> None:
        if self.config.publish_zero_velocity:
            self._output.stop()
        if error is None:
            self._server.succeed(FollowPath.Result())
        else:
            self._server.fail(error)
