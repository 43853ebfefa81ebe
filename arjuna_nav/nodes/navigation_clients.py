"""What bt_navigator asks of the other servers, and what came of it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from geometry_msgs.msg import Point
from nav2_msgs.action import (
    BackUp,
    ComputePathThroughPoses,
    ComputePathToPose,
    FollowPath,
    Spin,
    Wait,
)
from nav2_msgs.srv import ClearEntireCostmap, IsPathValid
from numpy.typing import NDArray
from std_msgs.msg import String

from arjuna_core.ros import qos
from arjuna_core.ros.convert import duration_msg, path_msg, pose_stamped, poses_from_path
from arjuna_core.ros.goal_client import GoalClient, GoalOutcome
from arjuna_core.ros.node import ManagedNode
from arjuna_core.se2 import SE2
from arjuna_core.timing import Periodic
from arjuna_nav.commands import (
    GLOBAL_COSTMAP,
    LOCAL_COSTMAP,
    CheckPath,
    Clear,
    Command,
    ComputePath,
    Finish,
    Follow,
    Outcome,
    Recover,
    Recovery,
    Stop,
)
from arjuna_nav.planners.base import PlanResult, PlanStatus

_LOOK = 0.2  # [s] from one look for the servers to the next: 0.3 ms each, it searches the graph
_ALLOWANCE = 10.0  # time_allowance of recoveries in Nav2's default tree [s]
_UNKNOWN = {"follow": FollowPath.Result.UNKNOWN, "behavior": Spin.Result.UNKNOWN}
_THROUGH = 100  # ComputePathThroughPoses' codes are those of ComputePathToPose plus this
_SELECTED = ("controller", "goal_checker", "progress_checker", "planner")
"""Plug-ins chosen on the topics `*_selector`, as RViz's selector panel publishes them."""


class NavigationClients:
    """Carries out the navigator's commands and collects their outcomes.

    Args:
        node: bt_navigator; made in its `configure`.
        config: Its parameters.
    """

    def __init__(self, node: ManagedNode, config: Any) -> None:
        self._node = node
        self._config = config
        self._plan = self._action(ComputePathToPose, "compute_path_to_pose")
        self._plan_through = self._action(ComputePathThroughPoses, "compute_path_through_poses")
        self._trials = (
            self._action(ComputePathToPose, "compute_path_to_pose"),
            self._action(ComputePathThroughPoses, "compute_path_through_poses"),
        )
        self._trial: PlanResult | Outcome | GoalClient | None = None
        self._follow = self._action(FollowPath, "follow_path")
        self._recoveries = {
            Recovery.SPIN: self._action(Spin, "spin"),
            Recovery.WAIT: self._action(Wait, "wait"),
            Recovery.BACK_UP: self._action(BackUp, "backup"),
        }
        self._clear = {
            name: node.client(ClearEntireCostmap, f"{name}/clear_entirely_{name}")
            for name in (GLOBAL_COSTMAP, LOCAL_COSTMAP)
        }
        self._check = node.client(IsPathValid, "is_path_valid")
        self._chosen = dict.fromkeys(_SELECTED, "")
        for kind in _SELECTED:
            topic, take = f"{kind}_selector", partial(self._select, kind)
            node.subscribe(String, topic, take, qos.LATCHED, while_inactive=True)
        self._clearing: dict[str, float] = {}
        self._outcomes: dict[str, Any] = {}
        self._waiting_for: dict[str, GoalClient] = {}
        self._look = Periodic(_LOOK)

    def _select(self, kind: str, message: Any) -> None:
        self._chosen[kind] = message.data

    def _chosen_to_follow(self) -> dict[str, str]:
        """Return which plug-ins of the controller server were chosen, as fields of its goal."""
        return {f"{kind}_id": self._chosen[kind] for kind in _SELECTED if kind != "planner"}

    def _action(self, action: Any, name: str) -> GoalClient:
        client: GoalClient = self._node.keep(GoalClient(self._node, action, name))
        return client

    def take_outcomes(self) -> dict[str, Any]:
        """Return what has come since the last call, as NavigatorState's fields."""
        self._give_up_on_the_dead()
        outcomes, self._outcomes = self._outcomes, {}
        return outcomes

    def stop(self) -> None:
        """Cancel following and recoveries; no outcome of theirs is told any more."""
        for key in ("follow", "behavior"):
            client = self._waiting_for.pop(key, None)
            if client is not None:
                client.cancel()
            self._outcomes.pop(key, None)

    def carry_out(self, command: Command) -> None:
        """Do what the navigator says; its end is its node's to tell."""
        match command:
            case Stop() | Finish():
                self.stop()
            case Clear(name):
                self._send_clear(name)
            case CheckPath(path):
                self._send_check(path)
            case ComputePath(goals):
                self._send_plan(goals)
            case Follow(path):
                goal = FollowPath.Goal(path=self._path(path), **self._chosen_to_follow())
                self._send("follow", self._follow, goal)
            case Recover(kind):
                goal = self._recovery_goal(kind)
                self._send("behavior", self._recoveries[kind], goal)

    def _send(self, key: str, client: GoalClient, goal: Any) -> None:
        """Send a goal; its outcome is told under a key of NavigatorState."""
        self._outcomes.pop(key, None)
        self._waiting_for[key] = client

        def outcome(value: GoalOutcome) -> None:
            if self._waiting_for.get(key) is client:
                del self._waiting_for[key]
                self._outcomes[key] = self._outcome(key, client.name, value)

        if client.ready:  # a goal sent to nobody is never answered
            client.send(goal, outcome)
        else:
            self._lose(key, client)

    def _send_plan(self, goals: tuple[SE2, ...]) -> None:
        client = self._plan if len(goals) == 1 else self._plan_through
        self._send("plan", client, self._plan_goal(goals))

    def _plan_goal(self, goals: tuple[SE2, ...]) -> Any:
        frame, now, planner = self._config.global_frame, self._node.now, self._chosen["planner"]
        poses = [pose_stamped(goal, frame, now) for goal in goals]
        if len(poses) == 1:
            return ComputePathToPose.Goal(goal=poses[0], planner_id=planner)
        return ComputePathThroughPoses.Goal(goals=poses, planner_id=planner)

    def forget_trial(self) -> None:
        """Let the next trial be one of other goals."""
        self._trial = None

    def trial(self, goals: tuple[SE2, ...], on_plan: Callable[[], None]) -> PlanResult | None:
        """Return a plan that is only looked at, None until it has come.

        Args:
            goals: Where to; the same until `forget_trial`.
            on_plan: Called once it has come.
        """
        client = self._trials[len(goals) > 1]
        if self._trial is None and client.ready:
            self._trial = client

            def take(value: GoalOutcome) -> None:
                if self._trial is client:
                    self._trial = self._outcome("plan", client.name, value)
                    on_plan()

            client.send(self._plan_goal(goals), take)
        if isinstance(self._trial, PlanResult):
            return self._trial
        return None if client.ready else PlanResult.failed(PlanStatus.UNKNOWN, "no planner")

    def _recovery_goal(self, recovery: Recovery) -> Any:
        config, allowance = self._config, duration_msg(_ALLOWANCE)
        if recovery is Recovery.SPIN:
            return Spin.Goal(target_yaw=config.spin_dist, time_allowance=allowance)
        if recovery is Recovery.WAIT:
            return Wait.Goal(time=duration_msg(config.wait_duration))
        return BackUp.Goal(
            target=Point(x=config.backup_dist),
            speed=config.backup_speed,
            time_allowance=allowance,
        )

    def _path(self, path: NDArray[Any]) -> Any:
        return path_msg(path, self._config.global_frame, self._node.now)

    def _send_check(self, path: NDArray[Any]) -> None:
        if not self._check.service_is_ready():
            return
        future = self._check.call_async(IsPathValid.Request(path=self._path(path)))
        future.add_done_callback(self._on_check)

    def _on_check(self, future: Any) -> None:
        self._outcomes["path_valid"] = bool(future.result().is_valid)

    def _send_clear(self, name: str) -> None:
        self._clearing[name] = self._node.now
        if self._clear[name].service_is_ready():
            future = self._clear[name].call_async(ClearEntireCostmap.Request())
            future.add_done_callback(lambda _: self._on_cleared(name))

    def _on_cleared(self, name: str) -> None:
        self._clearing.pop(name, None)
        done = self._outcomes.get("cleared", frozenset())
        self._outcomes["cleared"] = done | {name}

    def _give_up_on_the_dead(self) -> None:
        """Go on where a service does not answer or a server has gone."""
        limit = self._config.wait_for_service_timeout / 1000.0
        for name in [n for n, since in self._clearing.items() if self._node.now - since > limit]:
            self._node.get_logger().warning(f"{name} was not cleared within {limit:g} s")
            self._on_cleared(name)
        if self._look.due(self._node.now):
            for key, client in list(self._waiting_for.items()):
                if not client.ready:
                    self._lose(key, client)

    def _lose(self, key: str, client: GoalClient) -> None:
        del self._waiting_for[key]
        message = f"the action server {client.name} is not there at {self._node.now:.2f} s"
        self._outcomes[key] = _failed(key, 0, message)

    def _outcome(self, key: str, name: str, outcome: GoalOutcome) -> PlanResult | Outcome:
        result = outcome.result
        if result is None:
            now = self._node.now
            return _failed(key, 0, f"{name} refused the goal at {now:.2f} s; its log says why")
        if outcome.succeeded and key != "plan":
            return Outcome()
        if outcome.succeeded and result.path.poses:
            return PlanResult(PlanStatus.SUCCEEDED, poses_from_path(result.path))
        return _failed(key, result.error_code, result.error_msg or "aborted")


def _failed(key: str, code: int, message: str) -> PlanResult | Outcome:
    """Return a failure; a code that is 0 or not nav2_msgs' becomes the unknown one."""
    if key != "plan":
        return Outcome(code or _UNKNOWN[key], message)
    code -= _THROUGH if code >= ComputePathThroughPoses.Result.UNKNOWN else 0
    known = code in list(PlanStatus) and code
    return PlanResult.failed(PlanStatus(code) if known else PlanStatus.UNKNOWN, message)
