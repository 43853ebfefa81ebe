"""Smooths paths on the global costmap: smooth_path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nav2_msgs.action import SmoothPath
from nav_msgs.msg import Path

from arjuna_core.arrays import Floats
from arjuna_core.config import duration_param, fixed, plugin_names
from arjuna_core.ros import qos
from arjuna_core.ros.convert import path_msg
from arjuna_core.ros.goal_server import GoalError, GoalNode, chosen, result_timeout
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import collision_place, first_collision
from arjuna_nav.nodes.costmap.reader import CostmapReader
from arjuna_nav.nodes.frames import poses_of
from arjuna_nav.smoothers.smoothers import SMOOTHERS, Smoother, SmoothResult, SmoothStatus


@dataclass(frozen=True)
class SmootherServerConfig:
    """Parameters of the node `smoother_server`, by Nav2's names."""

    smoother_plugins: tuple[str, ...] = plugin_names(
        ("simple_smoother",), "The smoothers.", SMOOTHERS
    )
    action_server_result_timeout: float = result_timeout(10.0)
    costmap_update_timeout: float = duration_param(1.0, "How old the costmap may be.")
    costmap_topic: str = fixed("global_costmap/costmap_raw", "Costs to keep off.")
    footprint_topic: str = fixed(
        "global_costmap/published_footprint", "Outline that may not collide."
    )
    robot_base_frame: str = fixed("base_link", "Frame of the outline.")
    transform_tolerance: float = duration_param(
        0.1, "How old the transforms to costs and outline may be."
    )


class SmootherServerNode(GoalNode):
    """Answers each goal at once; `max_smoothing_duration` is never reached."""

    Config = SmootherServerConfig
    DEFAULT_NAME = "smoother_server"

    def configure(self) -> None:
        config = self.config
        self._costmap = CostmapReader(
            self,
            config.costmap_topic,
            config.footprint_topic,
            config.robot_base_frame,
            config.transform_tolerance,
        )
        self._out = self.publisher(Path, "plan_smoothed", qos.LATEST)
        self._server = self.offer(SmoothPath, "smooth_path", self._on_goal)

    def _on_goal(self) -> None:
        goal: Any = self._server.goal
        smoothed = self._smooth(goal)
        result = SmoothPath.Result(error_msg=smoothed.message)
        result.path = path_msg(smoothed.path, goal.path.header.frame_id, self.now)
        result.was_completed = smoothed.status is SmoothStatus.SUCCEEDED
        self._out.publish(result.path)
        self._server.succeed(result)

    def _smooth(self, goal: Any) -> SmoothResult:
        """Return the smoothed path of a goal.

        Raises:
            GoalError: There is none.
        """
        names = self.config.smoother_plugins
        name = chosen("smoother", goal.smoother_id, names, SmoothStatus.INVALID_SMOOTHER)
        path = poses_of(goal.path, SmoothStatus.INVALID_PATH)
        timeout, frame = self.config.costmap_update_timeout, goal.path.header.frame_id.lstrip("/")
        try:
            costmap = self._costmap.current(timeout, frame)
        except TransformError as error:
            raise GoalError(SmoothStatus.INVALID_PATH, str(error)) from error
        if costmap is None:
            raise GoalError(SmoothStatus.UNKNOWN, self._costmap.why_not_current())
        smoother: Smoother = SMOOTHERS.make(getattr(self.config, name))
        smoothed = smoother.smooth(path, costmap)
        # a pass that would touch an obstacle was undone: what came before it is a good path
        if smoothed.status not in (SmoothStatus.SUCCEEDED, SmoothStatus.FAILED_TO_SMOOTH_PATH):
            raise GoalError(smoothed.status, smoothed.message)
        if goal.check_for_collisions:
            self._check(smoothed.path, costmap)
        return smoothed

    def _check(self, path: Floats, costmap: Costmap) -> None:
        try:
            footprint = self._costmap.footprint()
        except TransformError as error:
            raise GoalError(SmoothStatus.UNKNOWN, str(error)) from error
        hit = first_collision(costmap, footprint, path)
        if hit is not None:
            where = collision_place(costmap, footprint, SE2.from_array(path[hit]))
            message = f"the robot would collide at pose {hit} of the smoothed path, {where}"
            raise GoalError(SmoothStatus.SMOOTHED_PATH_IN_COLLISION, message)
