"""Node planner_server: compute_path_to_pose, compute_path_through_poses, is_path_valid."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from nav2_msgs.action import ComputePathThroughPoses, ComputePathToPose
from nav2_msgs.srv import IsPathValid
from nav_msgs.msg import Path
from numpy.typing import NDArray

from arjuna_core.config import param, plugin_names
from arjuna_core.ros import qos
from arjuna_core.ros.convert import duration_msg, path_msg, poses_from_path
from arjuna_core.ros.goal_server import (
    GoalError,
    GoalNode,
    GoalServer,
    chosen,
    result_timeout,
)
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.nodes.costmap.node import CostmapNode
from arjuna_nav.nodes.frames import pose_in
from arjuna_nav.planners import Planner, PlanStatus, plan_through
from arjuna_nav.planners.base import PLANNERS, too_tight

_ACTIONS: dict[str, Any] = {
    "compute_path_to_pose": ComputePathToPose,
    "compute_path_through_poses": ComputePathThroughPoses,
}


@dataclass(frozen=True)
class PlannerServerConfig:
    """Parameters of the node `planner_server`, by Nav2's names."""

    planner_plugins: tuple[str, ...] = plugin_names(("GridBased",), "The planners.", PLANNERS)
    action_server_result_timeout: float = result_timeout(10.0)
    costmap_update_timeout: float = param(1.0, "How old the costmap may be.", unit="s", minimum=0.0)
    min_turning_radius: float = param(
        0.0,
        "Radius of the tightest bend of a steered robot; 0: it turns on the spot. Planners keep to"
        " one of their own: where that is less, it is logged.",
        unit="m",
        minimum=0.0,
    )
    retry_period: float = param(
        0.1,
        "Time between two looks for a current costmap.",
        unit="s",
        minimum=0.001,
        read_only=True,
    )


class PlannerServerNode(GoalNode):
    """Answers each goal at once; where the costmap is not current, as soon as it is."""

    Config = PlannerServerConfig
    DEFAULT_NAME = "planner_server"

    def configure(self) -> None:
        """Create the planner and its interfaces."""
        self._costmap: CostmapNode = self.process.find("global_costmap/global_costmap")
        self._planners: dict[str, tuple[Footprint, Planner]] = {}
        self._asked_at: dict[str, float] = {}
        self._out = self.publisher(Path, "plan", qos.LATEST)
        self._servers: dict[str, GoalServer] = {
            name: self.offer(
                action,
                name,
                partial(self._on_goal, name),
                on_cancel=self._attempt_plans,
                invalid=action.Result.TF_ERROR,
            )
            for name, action in _ACTIONS.items()
        }
        self.serve(IsPathValid, "is_path_valid", self._on_is_path_valid)
        self.every(self.config.retry_period, self._attempt_plans)

    def on_config(self, config: PlannerServerConfig) -> None:
        """Plan by the new parameters from now on."""
        if hasattr(self, "_planners"):
            self._planners.clear()

    def _planner(self, name: str) -> Planner:
        footprint = self._costmap.layered.footprint
        made = self._planners.get(name)
        if made is None or made[0] is not footprint:
            made = footprint, PLANNERS.make(getattr(self.config, name), footprint)
            self._planners[name] = made
            if text := too_tight(f"planner {name}", made[1], self.config.min_turning_radius):
                self.get_logger().warning(text)
        return made[1]

    def _on_goal(self, name: str) -> None:
        self._servers[name].take_newest()
        self._asked_at[name] = self.now
        self._attempt_plans()

    def _attempt_plans(self) -> None:
        for name, server in self._servers.items():
            if server.goal is not None:
                self._try(name, server)

    def _try(self, name: str, server: GoalServer) -> None:
        """Answer a goal, unless the costmap may still become current."""
        result = _ACTIONS[name].Result()
        if server.cancel_requested:
            server.cancel(result)
            return
        waited = self.now - self._asked_at[name]
        result.planning_time = duration_msg(waited)
        try:
            path = self._plan(server.goal, waited)
        except GoalError as error:
            server.fail(error, planning_time=result.planning_time)
            return
        if path is not None:
            result.path = path_msg(path, self._costmap.config.global_frame, self.now)
            self._out.publish(result.path)
            server.succeed(result)

    def _plan(self, goal: Any, waited: float) -> NDArray[np.float64] | None:
        """Return the path of a goal, None while the costmap may still become current.

        Args:
            goal: A goal of either action.
            waited: How long it has waited [s].

        Raises:
            GoalError: There is no path.
        """
        through = isinstance(goal, ComputePathThroughPoses.Goal)
        stops = goal.goals if through else [goal.goal]
        unknown, names = PlanStatus.INVALID_PLANNER.code(through), self.config.planner_plugins
        planner = chosen("planner", goal.planner_id, names, unknown)
        if not stops:
            code = ComputePathThroughPoses.Result.NO_VIAPOINTS_GIVEN
            raise GoalError(code, "0 goals were given, at least 1 is needed")
        costmap = self._costmap.current(self.config.costmap_update_timeout)
        if costmap is None:
            if waited <= self.config.costmap_update_timeout:
                return None
            raise GoalError(PlanStatus.TIMEOUT.code(through), self._costmap.why_not_current())
        frame = self._costmap.config.global_frame
        try:
            here = self._costmap.robot_pose
            start = pose_in(self, frame, goal.start) if goal.use_start else here()
            ends = [pose_in(self, frame, stop) for stop in stops]
        except TransformError as error:
            raise GoalError(PlanStatus.TF_ERROR.code(through), str(error)) from error
        outline = self._costmap.layered.footprint
        plan = plan_through(self._planner(planner), costmap, start, ends, outline)
        if plan.status is not PlanStatus.SUCCEEDED:
            raise GoalError(plan.status.code(through), plan.message)
        return plan.path

    def _on_is_path_valid(self, request: Any, response: Any) -> Any:
        """Answer for the part of a path that is still ahead of the robot."""
        costmap = self._costmap.current(self.config.costmap_update_timeout)
        response.is_valid = False
        try:
            poses = self._ahead(request.path)
        except (TransformError, ValueError) as error:
            self.get_logger().warning(f"path not valid: {error}")
            return response
        if costmap is None or not len(poses):
            return response
        hit = first_collision(costmap, self._costmap.layered.footprint, poses)
        response.is_valid = hit is None
        if hit is not None:
            response.invalid_pose_indices = [len(request.path.poses) - len(poses) + hit]
        return response

    def _ahead(self, path: Any) -> NDArray[np.float64]:
        """Return a path's poses from the one nearest to the robot on, in the costmap's frame."""
        frame, poses = self._costmap.config.global_frame, poses_from_path(path)
        source = path.header.frame_id.lstrip("/") or frame
        pose = self._costmap.robot_pose()
        if source != frame:
            T_map_path = self.transforms.lookup(frame, source)
            rows = [(T_map_path @ SE2.from_array(row)).array() for row in poses]
            poses = np.array(rows, dtype=np.float64).reshape(-1, 3)
        near = np.argmin(np.hypot(*(poses[:, :2] - (pose.x, pose.y)).T)) if len(poses) else 0
        return poses[near:]
