"""Node planner_server: compute_path_to_pose, compute_path_through_poses, is_path_valid."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, PoseArray
from nav2_msgs.action import ComputePathThroughPoses, ComputePathToPose
from nav2_msgs.srv import IsPathValid
from nav_msgs.msg import Path
from visualization_msgs.msg import Marker, MarkerArray

from arjuna_core.arrays import Bools, Floats
from arjuna_core.config import duration_param, param, plugin_names
from arjuna_core.ros import qos
from arjuna_core.ros.convert import duration_msg, path_msg, pose_msg, poses_from_path
from arjuna_core.ros.goal_server import GoalError, GoalNode, GoalServer, chosen, result_timeout
from arjuna_core.ros.tf import TransformError
from arjuna_core.ros.worker import Worker
from arjuna_core.se2 import SE2
from arjuna_nav.controllers.motion import min_turning_radius
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.nodes.costmap.node import CostmapNode
from arjuna_nav.nodes.frames import pose_in
from arjuna_nav.planners import Planner, PlanResult, PlanStatus, plan_through
from arjuna_nav.planners.base import PLANNERS, stopped_by, too_tight

_ACTIONS: dict[str, Any] = {
    "compute_path_to_pose": ComputePathToPose,
    "compute_path_through_poses": ComputePathThroughPoses,
}


@dataclass(frozen=True)
class PlannerServerConfig:
    """Parameters of the node `planner_server`, by Nav2's names."""

    planner_plugins: tuple[str, ...] = plugin_names(("GridBased",), "The planners.", PLANNERS)
    expected_planner_frequency: float = param(
        1.0,
        "Plans that take longer than its period are noted in the log; none from 0 down.",
        unit="Hz",
    )
    action_server_result_timeout: float = result_timeout(10.0)
    costmap_update_timeout: float = duration_param(1.0, "How old the costmap may be.")
    min_turning_radius: float = min_turning_radius(
        " (planners keep to one of their own: where that is less, it is logged)"
    )
    fit_outline: bool = param(
        True,
        "Whether a path that the outline cannot follow is replaced by one that it can, and gaps are"
        " tried that only the cells' size closes; else, as Nav2, the planner has the last word.",
        theirs=False,
    )
    retry_period: float = duration_param(
        0.1, "Time between two looks for a current costmap.", minimum=0.001, read_only=True
    )


@dataclass(eq=False)
class _Plan:
    """A plan that is being made.

    Attributes:
        ends: The poses to pass and the goal.
        began: When [s].
        limit: How long it may take [s].
        stop: Set where nobody waits for it any more.
    """

    outline: Footprint
    ends: Sequence[SE2]
    began: float
    limit: float
    stop: Bools = field(default_factory=lambda: np.zeros(1, np.bool_))


class PlannerServerNode(GoalNode):
    """Answers each goal at once; where the costmap is not current, as soon as it is.

    Outside lock-step a thread plans, and a goal that is cancelled, replaced or late ends at once.
    """

    Config = PlannerServerConfig
    DEFAULT_NAME = "planner_server"

    def configure(self) -> None:
        self._costmap: CostmapNode = self.process.find("global_costmap/global_costmap")
        self._planners: dict[str, tuple[Footprint, Planner]] = {}
        self._asked_at: dict[str, float] = {}
        self._plans: dict[str, _Plan] = {}
        self._worker: Worker = self.keep(Worker(self.process))
        self._out = self.publisher(Path, "plan", qos.LATEST)
        configs = [getattr(self.config, name) for name in self.config.planner_plugins]
        if any(getattr(config, "debug_visualizations", False) for config in configs):
            self._expansions = self.publisher(PoseArray, "expansions", qos.LATEST)
            self._footprints = self.publisher(MarkerArray, "planned_footprints", qos.LATEST)
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
        self._planners.clear()

    def halt(self) -> None:
        for name in _ACTIONS:
            self._stop(name)

    def _stop(self, name: str) -> None:
        plan = self._plans.pop(name, None)
        if plan is not None:
            plan.stop[0] = True

    def _planner(self, name: str) -> Planner:
        footprint = self._costmap.layered.footprint
        made = self._planners.get(name)
        if made is None or made[0] is not footprint:
            made = footprint, PLANNERS.make(getattr(self.config, name), footprint.of_axle)
            self._planners[name] = made
            if text := too_tight(f"planner {name}", made[1], self.config.min_turning_radius):
                self.get_logger().warning(text)
        return made[1]

    def _on_goal(self, name: str) -> None:
        self._stop(name)
        self._servers[name].take_newest()
        self._asked_at[name] = self.now
        self._attempt_plans()

    def _attempt_plans(self) -> None:
        for name, server in self._servers.items():
            if server.goal is not None:
                self._try(name, server)

    def _try(self, name: str, server: GoalServer) -> None:
        """Begin a goal's plan, unless the costmap may still become current, or end it early."""
        plan, waited = self._plans.get(name), self.now - self._asked_at[name]
        through = name == "compute_path_through_poses"
        try:
            if server.cancel_requested:
                self._stop(name)
                server.cancel(_ACTIONS[name].Result())
            elif plan is None:
                self._begin(name, server.goal, waited, through)
            elif self.now - plan.began > plan.limit:
                self._stop(name)
                message = f"no path within max_planning_time = {plan.limit:g} s"
                raise GoalError(PlanStatus.TIMEOUT.code(through), message)
        except GoalError as error:
            server.fail(error, planning_time=duration_msg(waited))

    def _begin(self, name: str, goal: Any, waited: float, through: bool) -> None:
        """Begin the plan of a goal that has waited for a time [s]; its end is `_finish`.

        Raises:
            GoalError: There is no path.
        """
        stops = goal.goals if through else [goal.goal]
        unknown, names = PlanStatus.INVALID_PLANNER.code(through), self.config.planner_plugins
        planner = chosen("planner", goal.planner_id, names, unknown)
        if not stops:
            code = ComputePathThroughPoses.Result.NO_VIAPOINTS_GIVEN
            raise GoalError(code, "0 goals were given, at least 1 is needed")
        costmap = self._costmap.current(self.config.costmap_update_timeout)
        if costmap is None:
            if waited <= self.config.costmap_update_timeout:
                return
            raise GoalError(PlanStatus.TIMEOUT.code(through), self._costmap.why_not_current())
        frame = self._costmap.config.global_frame
        try:
            here = self._costmap.robot_pose
            start = pose_in(self, frame, goal.start) if goal.use_start else here()
            ends = [pose_in(self, frame, stop) for stop in stops]
        except TransformError as error:
            raise GoalError(PlanStatus.TF_ERROR.code(through), str(error)) from error
        if not self.process.isolated:  # updates change it in place while the thread plans
            costmap = costmap.copied()
        limit = getattr(getattr(self.config, planner), "max_planning_time", math.inf)
        plan = _Plan(self._costmap.layered.footprint, ends, self.now, limit)
        self._plans[name] = plan
        shape = plan.outline, self.config.fit_outline
        self._worker.run(
            partial(_made, plan.stop, self._planner(planner), costmap, start, ends, *shape),
            self.guarded(name, partial(self._finish, name, plan), partial(self._failed, name)),
        )

    def _failed(self, name: str, reason: str, outcome: Callable[[], PlanResult]) -> None:
        self._servers[name].abort_all(f"the node failed: {reason}")

    def _finish(self, name: str, plan: _Plan, outcome: Callable[[], PlanResult]) -> None:
        """Answer a goal with its plan, unless it has ended meanwhile."""
        if self._plans.get(name) is not plan:
            return
        del self._plans[name]
        made, server = outcome(), self._servers[name]
        taken, rate = self.now - plan.began, self.config.expected_planner_frequency
        if rate > 0.0 and taken > 1.0 / rate:
            message = f"a plan took {taken:.2f} s, 1 / expected_planner_frequency is {1 / rate:.2f}"
            self.get_logger().warning(message)
        result = _ACTIONS[name].Result(planning_time=duration_msg(self.now - self._asked_at[name]))
        if made.status is not PlanStatus.SUCCEEDED:
            code = self._lasting(made.status, plan).code(name == "compute_path_through_poses")
            server.fail(GoalError(code, made.message), planning_time=result.planning_time)
            return
        result.path = path_msg(made.path, self._costmap.config.global_frame, self.now)
        if self._out.get_subscription_count():
            self._out.publish(result.path)
        if made.expansions is not None:
            self._show(made.expansions, made.path, plan.outline, result.path.header)
        server.succeed(result)

    def _lasting(self, status: PlanStatus, plan: _Plan) -> PlanStatus:
        """Return how a plan failed: where what stands on a goal may leave, recoveries may help."""
        if status is not PlanStatus.GOAL_OCCUPIED:
            return status
        lasts = any(map(self._costmap.layered.is_blocked_for_good, plan.ends))
        return status if lasts else PlanStatus.NO_VALID_PATH

    def _show(self, expansions: Floats, path: Floats, outline: Footprint, head: Any) -> None:
        """Publish the poses that a search expanded, and the robot's outline along its path."""
        poses = [pose_msg(SE2.from_array(row)) for row in expansions]
        self._expansions.publish(PoseArray(header=head, poses=poses))
        marker = Marker(header=head, ns="planned_footprint", type=Marker.LINE_LIST)
        marker.scale.x, marker.color.b, marker.color.a = 0.01, 1.0, 1.0
        for row in path:
            corners = SE2.from_array(row).apply(outline.points)
            for pair in zip(corners, np.roll(corners, -1, axis=0), strict=True):
                marker.points += [Point(x=float(x), y=float(y)) for x, y in pair]
        self._footprints.publish(MarkerArray(markers=[marker]))

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

    def _ahead(self, path: Any) -> Floats:
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


def _made(stop: Bools, *query: Any) -> PlanResult:
    """Return what `plan_through` does for a query, ended early by a flag."""
    with stopped_by(stop):
        return plan_through(*query)
