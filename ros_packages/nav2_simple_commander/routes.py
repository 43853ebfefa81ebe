"""Routes on the route server's graph, tracked beside another task."""

from __future__ import annotations

from typing import Any

from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import ComputeAndTrackRoute, ComputeRoute

from nav2_simple_commander.services import RobotServices
from nav2_simple_commander.task import RunningTask, Task


class RouteRobot(RobotServices):
    """A robot of which a route is tracked while it runs another task, as following its path.

    Attributes:
        route_goal_handle: Of the last route that was tracked.
        route_result_future: The future of its result, None before the first.
        route_feedback: What has not been taken yet, oldest first.
    """

    status: int | None
    compute_route_client: Any
    compute_and_track_route_client: Any

    def __init__(self, node_name: str, namespace: str) -> None:
        super().__init__(node_name, namespace)
        self.route_goal_handle: Any = None
        self.route_result_future: Any = None
        self.route_feedback: list[Any] = []
        self._route = Task(self, "route_")

    def _routeFeedbackCallback(self, msg: Any) -> None:
        self.route_feedback.append(msg.feedback)

    def getRoute(self, start: Any, goal: Any, use_start: bool = False) -> list[Any] | None:
        """Return the path and the route between two nodes' IDs or two poses."""
        request = self._between(ComputeRoute.Goal(use_start=use_start), start, goal)
        if request is None:
            return None
        self.info("Getting route...")
        result = self._task.finish(self.compute_route_client, request)
        if self.status != GoalStatus.STATUS_SUCCEEDED:
            self.warn(f"Getting route failed with status code: {self.status}")
            return None
        return [result.path, result.route]

    def getAndTrackRoute(
        self, start: Any, goal: Any, use_start: bool = False
    ) -> RunningTask | None:
        """Begin to track a route; `isTaskComplete` and `getFeedback` take what is returned."""
        request = self._between(ComputeAndTrackRoute.Goal(use_start=use_start), start, goal)
        self.route_feedback.clear()
        if request is None:
            return None
        self.info("Computing and tracking route...")
        started = self._route.start(self.compute_and_track_route_client, request)
        return RunningTask.COMPUTE_AND_TRACK_ROUTE if started else None

    def _between(self, request: Any, start: Any, goal: Any) -> Any:
        if isinstance(start, int) and isinstance(goal, int):
            request.start_id, request.goal_id = start, goal
        elif isinstance(start, PoseStamped) and isinstance(goal, PoseStamped):
            request.start, request.goal, request.use_poses = start, goal, True
        else:
            self.error("Invalid start and goal types. Must be PoseStamped for pose or int for ID")
            return None
        return request
