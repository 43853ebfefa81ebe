"""Plans paths on the global costmap: compute_path_to_pose."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from nav2_msgs.action import ComputePathToPose
from nav2_msgs.srv import IsPathValid
from nav_msgs.msg import Path

from arjuna_core.config import param
from arjuna_core.ros import qos
from arjuna_core.ros.actions import GoalServer
from arjuna_core.ros.convert import path_msg, poses_from_path
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import SE2
from arjuna_nav.collision import first_collision
from arjuna_nav.nodes.costmap import CostmapNode
from arjuna_nav.nodes.frames import pose_in
from arjuna_nav.planners import NavFn, NavFnConfig, PlanResult, PlanStatus

_RETRY_PERIOD = 0.1


@dataclass(frozen=True)
class PlannerServerConfig:
    """Parameters of the node `planner_server`, by Nav2's names."""

    planner_plugins: tuple[str, ...] = param(
        ("GridBased",), "The planners.", choices=("GridBased",), read_only=True
    )
    costmap_update_timeout: float = param(1.0, "How old the costmap may be.", unit="s", minimum=0.0)
    GridBased: NavFnConfig = field(default_factory=NavFnConfig)


class PlannerServerNode(ManagedNode):
    """Answers each goal at once; where the costmap is not current, as soon as it is."""

    Config = PlannerServerConfig
    DEFAULT_NAME = "planner_server"

    def configure(self) -> None:
        """Create the planner and its interfaces."""
        self._costmap: CostmapNode = self.process.find("global_costmap/global_costmap")
        self._planner = NavFn(self.config.GridBased)
        self._asked_at = 0.0
        self._out = self.publisher(Path, "plan", qos.LATEST)
        self._server = self.keep(
            GoalServer(self, ComputePathToPose, "compute_path_to_pose", self._on_goal)
        )
        self.serve(IsPathValid, "is_path_valid", self._on_is_path_valid)
        self.every(_RETRY_PERIOD, self._attempt_plan)

    def deactivate(self) -> None:
        """Abort what is asked for."""
        self._server.abort_all()

    def on_config(self, config: PlannerServerConfig) -> None:
        """Plan by the new parameters from now on."""
        self._planner = NavFn(config.GridBased)

    def _on_goal(self) -> None:
        if self._server.preempt_requested:
            self._server.accept_pending()
        self._asked_at = self.now
        self._attempt_plan()

    def _attempt_plan(self) -> None:
        """Plan for the goal that waits, if the costmap allows it."""
        goal = self._server.goal
        if goal is None:
            return
        if self._server.cancel_requested:
            self._server.cancel(ComputePathToPose.Result())
            return
        timeout = self.config.costmap_update_timeout
        costmap = self._costmap.current(timeout)
        if costmap is not None:
            self._answer(self._plan(goal, costmap))
        elif self.now - self._asked_at > timeout:
            message = f"the global costmap has not been updated for {timeout:g} s"
            self._answer(PlanResult.failed(PlanStatus.TIMEOUT, message))

    def _plan(self, goal: Any, costmap: Any) -> PlanResult:
        if goal.planner_id not in ("", *self.config.planner_plugins):
            valid = ", ".join(self.config.planner_plugins)
            message = f"planner '{goal.planner_id}' does not exist; valid: {valid}"
            return PlanResult.failed(PlanStatus.INVALID_PLANNER, message)
        try:
            frame = self._costmap.config.global_frame
            end = pose_in(self, frame, goal.goal)
            start = pose_in(self, frame, goal.start) if goal.use_start else self._robot()
        except TransformError as error:
            return PlanResult.failed(PlanStatus.TF_ERROR, str(error))
        return self._planner.plan(costmap, start, end)

    def _robot(self) -> SE2:
        config = self._costmap.config
        return self.transforms.lookup(config.global_frame, config.robot_base_frame)

    def _answer(self, plan: PlanResult) -> None:
        result = ComputePathToPose.Result(error_code=int(plan.status), error_msg=plan.message)
        if plan.status is not PlanStatus.SUCCEEDED:
            self.get_logger().warning(f"no path: {plan.message}")
            self._server.abort(result)
            return
        result.path = path_msg(plan.path, self._costmap.config.global_frame, self.now)
        self._out.publish(result.path)
        self._server.succeed(result)

    def _on_is_path_valid(self, request: Any, response: Any) -> Any:
        costmap = self._costmap.current(self.config.costmap_update_timeout)
        poses = poses_from_path(request.path)
        if costmap is None or not len(poses):
            response.is_valid = False
            return response
        pose = self._costmap.robot_pose()
        if pose is not None:
            near = np.argmin(np.hypot(poses[:, 0] - pose.x, poses[:, 1] - pose.y))
            poses = poses[near:]
        hit = first_collision(costmap, self._costmap.layered.footprint, poses)
        response.is_valid = hit is None
        if hit is not None:
            response.invalid_pose_indices = [len(request.path.poses) - len(poses) + hit]
        return response
