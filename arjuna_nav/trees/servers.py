"""The nodes of Nav2's servers: planning, following, smoothing, docking, behaviors, clearing.

Source: nav2_behavior_tree, plugins/action; BtCancelActionNode.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import UNKNOWN
from arjuna_nav.planners import path as paths
from arjuna_nav.trees.asking import Action, Asking, Service
from arjuna_nav.trees.exchange import Answer
from arjuna_nav.trees.node import Status, TreeNode
from arjuna_nav.trees.ports import ANY, NUMBER, PATH, POSE, POSES, TEXT, TRUTH, WHOLE, Kind, Port


class _Planning(Action):
    """Plans; a goal that changes is planned to at once, and a path to the older one is dropped."""

    start = Port(POSE, None, "start")
    use_start = Port(TRUTH, True)
    planner_id = Port(TEXT, "", "planner_id")
    path = Port(PATH, None, output=True)

    def _tick(self) -> Status:
        if self._key is not None and not self._cancelled and self._is_outdated():
            return self._ask()
        return super()._tick()

    def _request(self) -> dict[str, Any]:
        """Return a request from a start where one is given, else from the robot's pose."""
        fields = super()._request()
        if not self.use_start:
            fields.pop("start", None)
        return {**fields, "use_start": "start" in fields}


class ComputePathToPose(_Planning):
    """Plans to a pose."""

    KIND, SERVER, RENEWS = "ComputePathToPose", "compute_path_to_pose", ("goal",)
    goal = Port(POSE, field="goal")


class ComputePathThroughPoses(_Planning):
    """Plans through poses."""

    KIND, SERVER, RENEWS = "ComputePathThroughPoses", "compute_path_through_poses", ("goals",)
    goals = Port(POSES, field="goals")


class FollowPath(Action):
    """Follows a path; a new path, controller or checker on the blackboard is taken at once."""

    KIND, SERVER = "FollowPath", "follow_path"
    RENEWS = ("path", "controller_id", "goal_checker_id", "progress_checker_id")
    path = Port(PATH, field="path")
    controller_id = Port(TEXT, "", "controller_id")
    goal_checker_id = Port(TEXT, "", "goal_checker_id")
    progress_checker_id = Port(TEXT, "", "progress_checker_id")


class _Costing(Service):
    """Asks what a pose costs on a costmap."""

    KIND, SERVER = "GetCost", "/global_costmap/get_cost_global_costmap"
    cost_threshold = Port(NUMBER, 254.0)
    use_footprint = Port(TRUTH, True, "use_footprint")
    consider_unknown_as_obstacle = Port(TRUTH, False)

    def _asked_about(self) -> SE2:
        raise NotImplementedError

    def _request(self) -> dict[str, Any]:
        pose = self._asked_about()
        return {**super()._request(), "x": pose.x, "y": pose.y, "theta": pose.theta}

    def _is_occupied(self, answer: Answer) -> bool:
        cost = float(answer.values["cost"])
        unknown = cost == UNKNOWN and not self.consider_unknown_as_obstacle
        return not (cost < self.cost_threshold or unknown)


class IsPoseOccupied(_Costing):
    """Succeeds where a pose costs too much on a costmap."""

    pose = Port(POSE)

    def _asked_about(self) -> SE2:
        pose: SE2 = self.pose
        return pose

    def _take(self, answer: Answer) -> Status:
        occupied = answer.succeeded and self._is_occupied(answer)
        return Status.SUCCESS if occupied else Status.FAILURE


class RemoveInCollisionGoals(_Costing):
    """Removes goals at which a costmap costs too much; the costs are asked for one by one.

    While a later node runs, the same goals are not asked about again, or that would be halted.
    """

    input_goals = Port(POSES)
    output_goals = Port(POSES, None, output=True)
    input_waypoint_statuses = Port(ANY, None)
    output_waypoint_statuses = Port(ANY, None, output=True)
    _left: tuple[SE2, ...] = ()
    _free: tuple[SE2, ...] = ()

    def _tick(self) -> Status:
        if self._key is None:
            goals = self.input_goals
            if not goals or (self.status is Status.SUCCESS and goals == self._free):
                self.output_goals = goals
                return Status.SUCCESS
            self._left, self._free = goals, ()
        return super()._tick()

    def _asked_about(self) -> SE2:
        return self._left[0]

    def _take(self, answer: Answer) -> Status:
        if not answer.succeeded:
            return Status.FAILURE
        if not self._is_occupied(answer):
            self._free = (*self._free, self._left[0])
        self._left = self._left[1:]
        if self._left:
            return self._ask()
        self.output_goals = self._free
        return Status.SUCCESS


def _only(*values: str) -> Kind:
    """Return the kind of a port of which the service's request of Jazzy has no field."""
    same = {value: value for value in values}
    return Kind(f"{' or '.join(values) or 'none'}, as Jazzy's service judges", same.__getitem__)


class IsPathValid(Service):
    """Succeeds where a path is free, as far ahead as asked; fails where there is no path yet."""

    KIND, SERVER = "IsPathValid", "is_path_valid"
    path = Port(PATH, None)
    max_lookahead_distance = Port(NUMBER, -1.0)
    max_cost = Port(_only("253", "254", "255"), "254")
    consider_unknown_as_obstacle = Port(_only("false"), "false")
    layer_name = Port(_only(""), "")
    footprint = Port(_only("", "[]"), "")
    check_full_path = Port(TRUTH, False)
    stop_at_first_collision = Port(TRUTH, True)

    def _tick(self) -> Status:
        return Status.FAILURE if self.path is None else super()._tick()

    def _request(self) -> dict[str, Any]:
        path, pose, reach = self.path, self.tree.state.pose, self.max_lookahead_distance
        if reach >= 0.0 and pose is not None and len(path):
            lengths = paths.along(path)
            path = path[lengths <= lengths[paths.nearest(path, pose)] + reach]
        return {"path": path}


class ValidatePath(IsPathValid):
    """IsPathValid by the name that Nav2 gave it later."""


class ToggleCollisionMonitor(Service):
    """Turns the collision monitor on or off."""

    KIND, SERVER = "Toggle", "collision_monitor/toggle"
    enable = Port(TRUTH, True, "enable")


_ALLOWANCE = {"time_allowance": Port(NUMBER, 10.0, "time_allowance")}
_ROUTE = {
    **{name: Port(WHOLE, None, name) for name in ("start_id", "goal_id")},
    **{name: Port(POSE, None, name) for name in ("start", "goal")},
    **{name: Port(TRUTH, False, name) for name in ("use_start", "use_poses")},
    "route": Port(POSES, None, output=True),
    "path": Port(PATH, None, output=True),
}
_ACTIONS: dict[str, tuple[str, dict[str, Port]]] = {
    "SmoothPath": (
        "smooth_path",
        {
            "unsmoothed_path": Port(PATH, field="path"),
            "max_smoothing_duration": Port(NUMBER, 3.0, "max_smoothing_duration"),
            "check_for_collisions": Port(TRUTH, False, "check_for_collisions"),
            "smoother_id": Port(TEXT, "", "smoother_id"),
            "smoothed_path": Port(PATH, None, "path", output=True),
            "smoothing_duration": Port(NUMBER, 0.0, output=True),
            "was_completed": Port(TRUTH, False, output=True),
        },
    ),
    "Spin": ("spin", {"spin_dist": Port(NUMBER, 1.57, "target_yaw"), **_ALLOWANCE}),
    "Wait": ("wait", {"wait_duration": Port(NUMBER, 1.0, "time")}),
    "BackUp": (
        "backup",
        {
            "backup_dist": Port(NUMBER, 0.15, "target"),
            "backup_speed": Port(NUMBER, 0.025, "speed"),
            **_ALLOWANCE,
        },
    ),
    "DriveOnHeading": (
        "drive_on_heading",
        {
            "dist_to_travel": Port(NUMBER, 0.15, "target"),
            "speed": Port(NUMBER, 0.025, "speed"),
            **_ALLOWANCE,
        },
    ),
    "AssistedTeleop": ("assisted_teleop", {**_ALLOWANCE, "is_recovery": Port(TRUTH, False)}),
    "DockRobot": (
        "dock_robot",
        {
            "use_dock_id": Port(TRUTH, True, "use_dock_id"),
            "dock_id": Port(TEXT, "", "dock_id"),
            "dock_pose": Port(POSE, None, "dock_pose"),
            "dock_type": Port(TEXT, "", "dock_type"),
            "max_staging_time": Port(NUMBER, 1000.0, "max_staging_time"),
            "navigate_to_staging_pose": Port(TRUTH, True, "navigate_to_staging_pose"),
            "num_retries": Port(WHOLE, 0, output=True),
            "success": Port(TRUTH, False, output=True),
        },
    ),
    "UndockRobot": (
        "undock_robot",
        {
            "dock_type": Port(TEXT, "", "dock_type"),
            "max_undocking_time": Port(NUMBER, 30.0, "max_undocking_time"),
            "success": Port(TRUTH, False, output=True),
        },
    ),
    "ComputeRoute": ("compute_route", {**_ROUTE, "planning_time": Port(NUMBER, 0.0, output=True)}),
    "ComputeAndTrackRoute": (
        "compute_and_track_route",
        {
            **_ROUTE,
            **{
                name: Port(WHOLE, 0, output=True)
                for name in ("last_node_id", "next_node_id", "current_edge_id")
            },
            "rerouted": Port(TRUTH, False, output=True),
            "execution_time": Port(NUMBER, 0.0, "execution_duration", output=True),
            "execution_duration": Port(NUMBER, 0.0, output=True),
        },
    ),
    "NavigateToPose": (
        "navigate_to_pose",
        {"goal": Port(POSE, field="pose"), "behavior_tree": Port(TEXT, "", "behavior_tree")},
    ),
    "NavigateThroughPoses": (
        "navigate_through_poses",
        {"goals": Port(POSES, field="poses"), "behavior_tree": Port(TEXT, "", "behavior_tree")},
    ),
}
_RECOVERING = ("Spin", "Wait", "BackUp", "AssistedTeleop")
_ROUTES = ("ComputeRoute", "ComputeAndTrackRoute")


def _action(name: str, server: str, ports: Mapping[str, Port]) -> type[Asking]:
    recovers = {"is_recovery": Port(TRUTH, True)} if name in _RECOVERING else {}
    renews = tuple(port.field for port in _ROUTE.values() if port.field)
    parts = {
        "KIND": name,
        "SERVER": server,
        "FEEDBACK": name == "ComputeAndTrackRoute",
        "RENEWS": renews if name in _ROUTES else (),
    }
    return type(name, (Action,), {**parts, **recovers, **ports})


_REGION = {"reset_distance": Port(NUMBER, 1.0, "reset_distance")}
_CLEARING: dict[str, dict[str, Port]] = {
    "ClearEntireCostmap": {},
    "ClearCostmapExceptRegion": _REGION,
    "ClearCostmapAroundRobot": _REGION,
    "ClearCostmapAroundPose": {**_REGION, "pose": Port(POSE, field="pose")},
}


class _Recovering(Service):
    is_recovery = Port(TRUTH, True)


class ReinitializeGlobalLocalization(_Recovering):
    """Spreads the localization over the whole map."""

    KIND, SERVER = "Empty", "reinitialize_global_localization"


class _Cancel(TreeNode):
    """Cancels what the tree asked of a server, or of all of its kind where it names none.

    The node that asked succeeds, as Nav2's do.
    """

    server_name = Port(TEXT, "")
    server_timeout = Port(NUMBER, 0.0)
    KIND: ClassVar[str]

    def _tick(self) -> Status:
        for node in self.tree.asking:
            if not isinstance(node, Asking) or node.KIND != self.KIND:
                continue
            if self.server_name in ("", node.server):
                node.cancel()
        return Status.SUCCESS


_CANCELS = {
    "CancelControl": "FollowPath",
    **{f"Cancel{kind}": kind for kind in (*_RECOVERING, "DriveOnHeading", "ComputeAndTrackRoute")},
}
SERVERS: dict[str, type[TreeNode]] = {
    **{name: _action(name, server, ports) for name, (server, ports) in _ACTIONS.items()},
    **{
        name: type(name, (_Recovering,), {"KIND": name, "service_name": Port(TEXT), **ports})
        for name, ports in _CLEARING.items()
    },
    **{name: type(name, (_Cancel,), {"KIND": kind}) for name, kind in _CANCELS.items()},
}
"""The nodes that only fill a request, and those that cancel one."""
