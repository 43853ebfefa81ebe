"""Drives to one waypoint after the other: follow_waypoints."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from nav2_msgs.action import FollowWaypoints, NavigateToPose
from nav2_msgs.msg import MissedWaypoint

from arjuna_core.config import param
from arjuna_core.ros.goal_client import GoalClient, GoalOutcome
from arjuna_core.ros.goal_node import GoalNode
from arjuna_core.ros.goal_server import GoalServer

_PLUGIN = "nav2_waypoint_follower::WaitAtWaypoint"
_UNKNOWN = FollowWaypoints.Result.UNKNOWN


@dataclass(frozen=True)
class WaitConfig:
    """The task at each waypoint: to wait."""

    plugin: str = param(_PLUGIN, "Nav2's name of what is used.", choices=(_PLUGIN,))
    enabled: bool = param(True, "Whether to wait.")
    waypoint_pause_duration: int = param(0, "How long to wait.", unit="ms", minimum=0)


@dataclass(frozen=True)
class WaypointFollowerConfig:
    """Parameters of the node `waypoint_follower`, by Nav2's names."""

    loop_rate: int = param(20, "Feedbacks a second.", unit="Hz", minimum=1, read_only=True)
    stop_on_failure: bool = param(True, "Whether a waypoint that is not reached ends it all.")
    waypoint_task_executor_plugin: str = param(
        "wait_at_waypoint", "The task.", choices=("wait_at_waypoint",), read_only=True
    )
    wait_at_waypoint: WaitConfig = field(default_factory=WaitConfig)


class WaypointFollowerNode(GoalNode):
    """Sends a `navigate_to_pose` goal for each waypoint; a newer list replaces the running one."""

    Config = WaypointFollowerConfig
    DEFAULT_NAME = "waypoint_follower"

    def configure(self) -> None:
        """Create the action and its client."""
        self._index = 0
        self._loops_left = 0
        self._missed: list[MissedWaypoint] = []
        self._go_on_at: float | None = None
        self._navigator = self.keep(GoalClient(self, NavigateToPose, "navigate_to_pose"))
        self._server = self.keep(
            GoalServer(
                self,
                FollowWaypoints,
                "follow_waypoints",
                self._on_goal,
                on_cancel=self._check_cancelled,
            )
        )
        self.every(1.0 / self.config.loop_rate, self._tick)

    def halt(self) -> None:
        """Stop driving to a waypoint."""
        if self._server.goal is not None:
            self._navigator.cancel()

    def _on_goal(self) -> None:
        """Begin with a list; what was driven to for another one is dropped."""
        replaced = self._server.preempt_requested
        goal = self._server.accept_pending() if replaced else self._server.goal
        self._index, self._loops_left = goal.goal_index, goal.number_of_loops
        self._missed, self._go_on_at = [], None
        if self._index < len(goal.poses):
            self._drive(goal)
            return
        if replaced:
            self._navigator.cancel()
        self._fail(f"there is no waypoint {self._index}: {len(goal.poses)} poses were given")

    def _drive(self, goal: Any) -> None:
        self._server.feedback(FollowWaypoints.Feedback(current_waypoint=self._index))
        if self._navigator.ready:
            request = NavigateToPose.Goal(pose=goal.poses[self._index])
            self._navigator.send(request, self._on_outcome)
        else:
            self._miss(_UNKNOWN, "the action server navigate_to_pose is not there")

    def _on_outcome(self, outcome: GoalOutcome) -> None:
        if self._server.goal is None:
            return
        if outcome.succeeded:
            task = self.config.wait_at_waypoint
            pause = task.waypoint_pause_duration / 1000.0 if task.enabled else 0.0
            self._go_on_at = self.now + pause
        elif outcome.result is None:
            self._miss(_UNKNOWN, "navigate_to_pose refused the goal")
        else:
            self._miss(outcome.result.error_code, outcome.result.error_msg)

    def _miss(self, code: int, reason: str) -> None:
        """Note a waypoint that was not reached; go on with the next or end."""
        goal = self._server.goal
        pose = goal.poses[self._index]
        self._missed.append(MissedWaypoint(index=self._index, goal=pose, error_code=code))
        message = f"waypoint {self._index} of {len(goal.poses)} was not reached: {reason}"
        if self.config.stop_on_failure:
            self._fail(message)
            return
        self.get_logger().warning(message)
        self._go_on_at = self.now

    def _tick(self) -> None:
        self._check_cancelled()
        goal = self._server.goal
        if goal is None:
            return
        if self._go_on_at is None:
            self._server.feedback(FollowWaypoints.Feedback(current_waypoint=self._index))
            self._notice_a_lost_navigator()
        elif self.now >= self._go_on_at:
            self._go_on_at = None
            self._go_on(goal)

    def _notice_a_lost_navigator(self) -> None:
        if not self._navigator.ready:
            self._miss(_UNKNOWN, "the action server navigate_to_pose has gone")

    def _go_on(self, goal: Any) -> None:
        """Drive to the next waypoint, begin another round, or be done."""
        self._index += 1
        if self._index == len(goal.poses):
            if not self._loops_left:
                self._server.succeed(FollowWaypoints.Result(missed_waypoints=self._missed))
                return
            self._loops_left -= 1
            self._index = 0
        self._drive(goal)

    def _check_cancelled(self) -> None:
        """Stop driving at once where the list that runs was cancelled."""
        if self._server.cancel_requested:
            self._navigator.cancel()
            self._server.cancel(FollowWaypoints.Result(missed_waypoints=self._missed))

    def _fail(self, message: str) -> None:
        self.get_logger().error(f"follow_waypoints failed: {message}")
        result = FollowWaypoints.Result(
            missed_waypoints=self._missed, error_code=_UNKNOWN, error_msg=message
        )
        self._server.abort(result)
