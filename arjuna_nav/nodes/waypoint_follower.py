"""Node waypoint_follower: follow_waypoints, follow_gps_waypoints."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import Any

from nav2_msgs.action import FollowGPSWaypoints, FollowWaypoints, NavigateToPose
from nav2_msgs.msg import MissedWaypoint

from arjuna_core.config import fixed, param, plugin_names
from arjuna_core.ros.convert import pose_stamped
from arjuna_core.ros.goal_client import GoalClient, GoalOutcome
from arjuna_core.ros.goal_server import GoalError, GoalServer, result_timeout
from arjuna_core.timing import Periodic
from arjuna_nav.nodes.goals.memory import GoalMemory, ResumingNode
from arjuna_nav.nodes.gps.anchor import GpsAnchor, GpsConfig, GpsError
from arjuna_nav.nodes.waypoints.tasks import TASKS, WaypointTask

_UNKNOWN = FollowWaypoints.Result.UNKNOWN
_TASK_FAILED = FollowWaypoints.Result.TASK_EXECUTOR_FAILED
_GPS = "follow_gps_waypoints"
_ACTIONS = {"follow_waypoints": FollowWaypoints, _GPS: FollowGPSWaypoints}


@dataclass(frozen=True)
class WaypointFollowerConfig:
    """Parameters of the node `waypoint_follower`, by Nav2's names."""

    loop_rate: int = fixed(20, "Feedbacks a second.", unit="Hz", minimum=1)
    action_server_result_timeout: float = result_timeout(900.0)
    stop_on_failure: bool = param(True, "Whether a waypoint that is not reached ends it all.")
    waypoint_task_executor_plugin: str = plugin_names(
        "wait_at_waypoint", "Name of the task at each waypoint.", TASKS
    )
    global_frame_id: str = fixed("map", "Frame of GPS waypoints' poses.")
    gps: GpsConfig = field(default_factory=GpsConfig)
    resume_file: str = param(
        "", "Keeps the list under way, to resume it after a crash; empty: no.", path=True
    )


class WaypointFollowerNode(ResumingNode):
    """Sends a `navigate_to_pose` goal for each waypoint; a newer list replaces the running one."""

    Config = WaypointFollowerConfig
    DEFAULT_NAME = "waypoint_follower"

    def configure(self) -> None:
        self._index = 0
        self._loops_left = 0
        self._poses: list[Any] = []
        self._missed: list[MissedWaypoint] = []
        self._arrived = self._at_task = False
        self._task_name = str(self.config.waypoint_task_executor_plugin)
        self._task: WaypointTask = TASKS.make(getattr(self.config, self._task_name), self)
        self._gps = GpsAnchor(self, self.config.gps, self.config.global_frame_id)
        self._navigator = self.keep(GoalClient(self, NavigateToPose, "navigate_to_pose"))
        self._look = Periodic(0.2)  # 0.3 ms each: it searches the graph
        self._kind = "follow_waypoints"
        self._servers = {
            kind: self.offer(
                action, kind, partial(self._on_goal, kind), on_cancel=self._check_cancelled
            )
            for kind, action in _ACTIONS.items()
        }
        self.memory = GoalMemory(self, self.config.resume_file, _ACTIONS)
        self.every(1.0 / self.config.loop_rate, self._tick)

    def resume_goal(self) -> None:
        """Let the navigator continue; a task that runs at a waypoint ends."""
        if self._at_task:
            self._at_task, self._arrived = False, True

    @property
    def _server(self) -> GoalServer:
        """The server of the list that is driven, or was last."""
        return self._servers[self._kind]

    def halt(self) -> None:
        if self._server.goal is not None:
            self._navigator.cancel()

    def _on_goal(self, kind: str) -> None:
        """Begin with a list; the waypoints of another one are dropped.

        A list that cannot be driven is aborted alone: the one that runs continues.
        """
        server = self._servers[kind]
        goal: Any = server.newest
        poses = self._poses_of(kind, goal)
        if kind != self._kind and self._server.goal is not None:
            self._fail(f"replaced by {kind} at {self.now:.2f} s")
        self._kind = kind
        server.take_newest()
        self._poses, self._index, self._loops_left = poses, goal.goal_index, goal.number_of_loops
        self._missed, self._arrived, self._at_task = [], False, False
        self._drive()

    def _poses_of(self, kind: str, goal: Any) -> list[Any]:
        """Return the poses of a list.

        Raises:
            GoalError: It cannot be driven.
        """
        poses = self._gps_poses(goal) if kind == _GPS else list(goal.poses)
        if goal.goal_index < len(poses):
            return poses
        message = f"there is no waypoint {goal.goal_index}: {len(poses)} poses were given"
        raise GoalError(_UNKNOWN, message)

    def _gps_poses(self, goal: Any) -> list[Any]:
        frame = self.config.global_frame_id
        poses = []
        for k, each in enumerate(goal.gps_poses):
            try:
                poses.append(pose_stamped(self._gps.pose(each), frame, self.now))
            except GpsError as error:
                message = f"waypoint {k} of {len(goal.gps_poses)}: {error}"
                raise GoalError(_UNKNOWN, message) from error
        return poses

    def _drive(self) -> None:
        self._publish_waypoint()
        goal: Any = self._server.goal
        goal.goal_index, goal.number_of_loops = self._index, self._loops_left
        self.memory.keep(self._kind, goal)
        if self._navigator.ready:
            request = NavigateToPose.Goal(pose=self._poses[self._index])
            self._navigator.send(request, self._on_outcome)
        else:
            self._miss(_UNKNOWN, "the action server navigate_to_pose is not there")

    def _publish_waypoint(self) -> None:
        feedback = _ACTIONS[self._kind].Feedback(current_waypoint=self._index)
        self._server.feedback(feedback)

    def _on_outcome(self, outcome: GoalOutcome) -> None:
        if self._server.goal is None:
            return
        self._navigator.cancel_replaced()
        if outcome.succeeded:
            self._task.start(self._poses[self._index], self._index, self.now)
            self._at_task = True
        elif outcome.result is None:
            self._miss(_UNKNOWN, "navigate_to_pose refused the goal")
        else:
            self._miss(outcome.result.error_code, outcome.result.error_msg)

    def _miss(self, code: int, reason: str) -> None:
        """Note a waypoint that was not reached; continue with the next or end."""
        pose = self._poses[self._index]
        self._missed.append(MissedWaypoint(index=self._index, goal=pose, error_code=code))
        failed = "was not served" if code == _TASK_FAILED else "was not reached"
        message = f"waypoint {self._index} of {len(self._poses)} {failed}: {reason}"
        if self.config.stop_on_failure:
            self._fail(message, _TASK_FAILED if code == _TASK_FAILED else _UNKNOWN)
            return
        self.get_logger().warning(message)
        self._arrived = True

    def _tick(self) -> None:
        self._check_cancelled()
        if self._server.goal is None:
            self.memory.resume()
            return
        if self._at_task:
            self._run_task()
        elif not self._arrived:
            self._publish_waypoint()
            if self._look.due(self.now) and not self._navigator.ready:
                self._miss(_UNKNOWN, "the action server navigate_to_pose has gone")
        if self._arrived and self._server.goal is not None:
            self._arrived = False
            self._continue()

    def _run_task(self) -> None:
        done = self._task.tick(self.now)
        if done is None:
            return
        self._at_task = False
        if done:
            self._arrived = True
        else:
            self._miss(_TASK_FAILED, f"{self._task_name}: {self._task.problem}")

    def _continue(self) -> None:
        self._index += 1
        if self._index == len(self._poses):
            if not self._loops_left:
                self._server.succeed(self._result())
                self.memory.forget()
                return
            self._loops_left -= 1
            self._index = 0
        self._drive()

    def _check_cancelled(self) -> None:
        if self._server.cancel_requested:
            self._navigator.cancel()
            self._server.cancel(self._result())
            self.memory.forget()

    def _result(self, **fields: Any) -> Any:
        return _ACTIONS[self._kind].Result(missed_waypoints=self._missed, **fields)

    def _fail(self, message: str, code: int = _UNKNOWN) -> None:
        self._at_task = False
        self.get_logger().error(f"{self._kind} failed: {message}")
        self._server.abort(self._result(error_code=code, error_msg=message))
        self.memory.forget()
