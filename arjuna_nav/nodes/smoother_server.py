"""Smooths paths on the global costmap: smooth_path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nav2_msgs.action import SmoothPath
from nav_msgs.msg import Path

from arjuna_core.config import param, plugin_names
from arjuna_core.ros import qos
from arjuna_core.ros.convert import path_msg, poses_from_path
from arjuna_core.ros.goal_server import GoalNode, result_timeout
from arjuna_core.ros.tf import TransformError
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.nodes.costmap.node import CostmapNode
from arjuna_nav.smoothers.base import SMOOTHERS, Smoother, SmoothResult, SmoothStatus


@dataclass(frozen=True)
class SmootherServerConfig:
    """Parameters of the node `smoother_server`, by Nav2's names."""

    smoother_plugins: tuple[str, ...] = plugin_names(
        ("simple_smoother",), "The smoothers.", SMOOTHERS
    )
    action_server_result_timeout: float = result_timeout(10.0)
    costmap_update_timeout: float = param(1.0, "How old the costmap may be.", unit="s", minimum=0.0)


class SmootherServerNode(GoalNode):
    """Answers each goal at once; `max_smoothing_duration` is never reached."""

    Config = SmootherServerConfig
    DEFAULT_NAME = "smoother_server"

    def configure(self) -> None:
        """Create the smoother and its interfaces."""
        self._costmap: CostmapNode = self.process.find("global_costmap/global_costmap")
        self._out = self.publisher(Path, "plan_smoothed", qos.LATEST)
        self._server = self.offer(SmoothPath, "smooth_path", self._on_goal)

    def _on_goal(self) -> None:
        goal: Any = self._server.goal
        smoothed = self._smooth(goal)
        result = SmoothPath.Result(error_msg=smoothed.message)
        # a pass that would touch an obstacle was undone: what came before it is a good path
        if smoothed.status in (SmoothStatus.SUCCEEDED, SmoothStatus.FAILED_TO_SMOOTH_PATH):
            result.path = path_msg(smoothed.path, goal.path.header.frame_id, self.now)
            result.was_completed = smoothed.status is SmoothStatus.SUCCEEDED
            self._out.publish(result.path)
            self._server.succeed(result)
            return
        self.get_logger().warning(f"not smoothed: {smoothed.message}")
        result.error_code = int(smoothed.status)
        self._server.abort(result)

    def _smooth(self, goal: Any) -> SmoothResult:
        """Return the smoothed path of a goal, or why there is none."""
        if goal.smoother_id not in ("", *self.config.smoother_plugins):
            valid = ", ".join(self.config.smoother_plugins)
            message = f"smoother '{goal.smoother_id}' does not exist; valid: {valid}"
            return SmoothResult.failed(SmoothStatus.INVALID_SMOOTHER, message)
        if not goal.path.poses:
            return SmoothResult.failed(
                SmoothStatus.INVALID_PATH, "the path has 0 poses, at least 1 is needed"
            )
        try:
            path = poses_from_path(goal.path)
            costmap = self._seen_from(goal.path.header.frame_id.lstrip("/"))
        except (TransformError, ValueError) as error:
            return SmoothResult.failed(SmoothStatus.INVALID_PATH, str(error))
        if costmap is None:
            return SmoothResult.failed(SmoothStatus.UNKNOWN, self._costmap.why_not_current())
        name = goal.smoother_id or self.config.smoother_plugins[0]
        smoother: Smoother = SMOOTHERS.make(getattr(self.config, name))
        smoothed = smoother.smooth(path, costmap)
        return self._checked(smoothed, costmap) if goal.check_for_collisions else smoothed

    def _seen_from(self, frame: str) -> Costmap | None:
        """Return the costmap placed in the path's frame, or None if it is not current."""
        T_path_costmap = self.transforms.lookup(frame, self._costmap.config.global_frame)
        costmap = self._costmap.current(self.config.costmap_update_timeout)
        return None if costmap is None else costmap.seen_from(T_path_costmap)

    def _checked(self, smoothed: SmoothResult, costmap: Costmap) -> SmoothResult:
        """Return a smoothed path, or where the robot on it would collide."""
        hit = first_collision(costmap, self._costmap.layered.footprint, smoothed.path)
        if hit is None:
            return smoothed
        x, y = smoothed.path[hit, :2]
        message = f"the robot would collide at ({x:.2f}, {y:.2f}), pose {hit} of the smoothed path"
        return SmoothResult.failed(SmoothStatus.SMOOTHED_PATH_IN_COLLISION, message)
