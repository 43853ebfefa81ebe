"""BasicNavigator against a stand-in of Nav2: goals, feedback, results, services, deadlines."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from irobot_create_msgs import action as create3
from irobot_create_msgs.msg import DockStatus
from lifecycle_msgs.srv import GetState
from nav2_msgs.action import (
    ComputeAndTrackRoute,
    ComputePathToPose,
    ComputeRoute,
    NavigateToPose,
)
from nav2_msgs.srv import ClearEntireCostmap
from nav2_simple_commander import task
from nav2_simple_commander.robot_navigator import (
    BasicNavigator,
    NavigationResult,
    RunningTask,
    TaskResult,
)
from rclpy.action import ActionServer, CancelResponse
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from turtlebot4_navigation.turtlebot4_navigator import TurtleBot4Directions, TurtleBot4Navigator


class StandIn(Node):
    """Accepts every goal; one at x = 1 is reached, at x = 2 fails, at x = 3 waits for a cancel."""

    def __init__(self) -> None:
        super().__init__("stand_in")
        self.cleared: list[str] = []
        self.cancelled = threading.Event()
        ActionServer(
            self, NavigateToPose, "navigate_to_pose", self.execute, cancel_callback=self.on_cancel
        )
        ActionServer(self, ComputePathToPose, "compute_path_to_pose", self.plan)
        ActionServer(self, ComputeRoute, "compute_route", self.route)
        self.tracked = threading.Event()
        ActionServer(self, ComputeAndTrackRoute, "compute_and_track_route", self.track)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        pose = self.create_publisher(PoseWithCovarianceStamped, "amcl_pose", latched)
        self.create_subscription(PoseWithCovarianceStamped, "initialpose", pose.publish, 10)
        for name in ("amcl", "bt_navigator"):
            self.create_service(GetState, f"{name}/get_state", self.state)
        for name in ("local", "global"):
            service = f"{name}_costmap/clear_entirely_{name}_costmap"
            self.create_service(ClearEntireCostmap, service, self.clear)

    def on_cancel(self, handle: Any) -> Any:
        self.cancelled.set()
        return CancelResponse.ACCEPT

    def execute(self, handle: Any) -> Any:
        x = handle.request.pose.pose.position.x
        handle.publish_feedback(NavigateToPose.Feedback(distance_remaining=float(x)))
        if x == 3.0 and self.cancelled.wait(10.0):
            handle.canceled()
        elif x == 1.0:
            handle.succeed()
        else:
            handle.abort()
        return NavigateToPose.Result()

    def plan(self, handle: Any) -> Any:
        result = ComputePathToPose.Result()
        if handle.request.goal.pose.position.x > 0.0:
            handle.succeed()
            result.path.poses = [handle.request.goal]
        else:
            handle.abort()
        return result

    def route(self, handle: Any) -> Any:
        handle.succeed()
        result = ComputeRoute.Result()
        result.route.route_cost = handle.request.goal_id + handle.request.goal.pose.position.x
        return result

    def track(self, handle: Any) -> Any:
        for node in (1, 2):
            handle.publish_feedback(ComputeAndTrackRoute.Feedback(last_node_id=node))
        self.tracked.wait(10.0)
        handle.succeed()
        return ComputeAndTrackRoute.Result()

    def state(self, request: Any, response: Any) -> Any:
        response.current_state.label = "active"
        return response

    def clear(self, request: Any, response: Any) -> Any:
        self.cleared.append("costmap")
        return response


@pytest.fixture
def nav2(monkeypatch: pytest.MonkeyPatch) -> Iterator[StandIn]:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    rclpy.init()
    node, executor = StandIn(), MultiThreadedExecutor(4)
    executor.add_node(node)
    thread = threading.Thread(target=executor.spin, daemon=True)
    thread.start()
    yield node
    executor.shutdown()
    thread.join(5.0)
    node.destroy_node()
    rclpy.try_shutdown()


class Dock(Node):
    """Drives on and off a dock, and says so."""

    def __init__(self) -> None:
        super().__init__("dock")
        self.docked = True
        ActionServer(self, create3.Dock, "dock", self.execute)
        ActionServer(self, create3.Undock, "undock", self.execute)
        status = self.create_publisher(DockStatus, "dock_status", 10)
        self.create_timer(0.05, lambda: status.publish(DockStatus(is_docked=self.docked)))

    def execute(self, handle: Any) -> Any:
        undock = isinstance(handle.request, create3.Undock.Goal)
        if self.docked == undock:
            self.docked = not undock
            handle.succeed()
        else:
            handle.abort()
        return (create3.Undock if undock else create3.Dock).Result(is_docked=self.docked)


@pytest.fixture
def navigator(nav2: StandIn) -> Iterator[BasicNavigator]:
    navigator = BasicNavigator()
    yield navigator
    navigator.destroy_node()


def at(x: float) -> PoseStamped:
    pose = PoseStamped()
    pose.header.frame_id = "map"
    pose.pose.position.x = x
    return pose


@pytest.mark.parametrize(("x", "result"), [(1.0, TaskResult.SUCCEEDED), (2.0, TaskResult.FAILED)])
def test_a_goal_ends_as_the_server_says(
    navigator: BasicNavigator, x: float, result: TaskResult
) -> None:
    navigator.waitUntilNav2Active()
    assert navigator.goToPose(at(x))
    while not navigator.isTaskComplete():
        pass
    assert navigator.getResult() is result
    assert navigator.getFeedback().distance_remaining == x


def test_a_turtlebot4_leaves_its_dock_and_drives(
    nav2: StandIn, capfd: pytest.CaptureFixture[str]
) -> None:
    dock, navigator = Dock(), TurtleBot4Navigator()
    nav2.executor.add_node(dock)
    assert navigator.getDockedStatus()
    navigator.undock()
    while navigator.getDockedStatus():
        pass
    navigator.undock()  # it cannot twice
    pose = navigator.getPoseStamped([1, 0.5], TurtleBot4Directions.WEST)
    assert (pose.header.frame_id, pose.pose.position.x) == ("map", 1.0)
    assert pose.pose.orientation.z == pytest.approx(pose.pose.orientation.w)
    navigator.startToPose(pose)
    assert navigator.getResult() is TaskResult.SUCCEEDED
    navigator.dock()
    said = capfd.readouterr().err
    wanted = ("Undock succeeded", "Undock failed", "Goal succeeded!", "Dock succeeded")
    assert [part for part in wanted if part not in said] == []
    navigator.destroy_node()
    dock.destroy_node()


@pytest.mark.parametrize(
    "cancel",
    [
        BasicNavigator.cancelTask,
        lambda navigator: navigator.cancelNav(),  # as Galactic calls it
        lambda navigator: navigator.goal_handle.cancel_goal_async(),
    ],
)
def test_a_cancelled_goal_says_so(navigator: BasicNavigator, cancel: Any) -> None:
    assert navigator.goToPose(at(3.0))
    assert not navigator.isTaskComplete()
    assert not navigator.result_future.done()
    assert navigator.getResult() is TaskResult.UNKNOWN
    cancel(navigator)
    while not navigator.isNavComplete():
        rclpy.spin_once(navigator, timeout_sec=0.1)
    assert navigator.isTaskComplete()
    assert navigator.getResult() is TaskResult.CANCELED is NavigationResult.CANCELED


def test_a_program_sends_a_goal_by_the_navigator_s_own_client(navigator: BasicNavigator) -> None:
    own: Any = navigator
    assert (own.goal_handle, own.result_future, own.feedback, own.status) == (None,) * 4
    assert own.nav_to_pose_client.wait_for_server(timeout_sec=10.0)
    goal = NavigateToPose.Goal(pose=at(1.0))
    sent = own.nav_to_pose_client.send_goal_async(goal, own._feedbackCallback)
    rclpy.spin_until_future_complete(own, sent)
    own.goal_handle = sent.result()
    own.result_future = own.goal_handle.get_result_async()
    while not own.isTaskComplete():
        pass
    assert own.getResult() is TaskResult.SUCCEEDED
    assert own.result_future.result().result.error_code == 0
    assert own.feedback.distance_remaining == 1.0


def test_there_is_feedback_from_the_second_goal_s_start_on(navigator: BasicNavigator) -> None:
    for x in (1.0, 2.0):
        assert navigator.goToPose(at(x))
        assert x == 1.0 or navigator.getFeedback().distance_remaining in (1.0, 2.0)
        while not navigator.isTaskComplete():
            pass


def test_a_task_says_what_it_does(
    navigator: BasicNavigator, capfd: pytest.CaptureFixture[str]
) -> None:
    navigator.goToPose(at(2.0))
    navigator.getPath(at(0.0), at(1.0))
    said = capfd.readouterr().err
    assert "Navigating to goal: 2.0 0.0..." in said
    assert "Getting path..." in said


def test_a_path_or_none(navigator: BasicNavigator) -> None:
    assert len(navigator.getPath(at(0.0), at(1.0)).poses) == 1
    assert navigator.getPath(at(0.0), at(-1.0)) is None
    assert navigator._getPathImpl(at(0.0), at(-1.0)).path.poses == []
    assert navigator.getResult() is TaskResult.FAILED


def test_a_route_is_tracked_beside_another_task(navigator: BasicNavigator, nav2: StandIn) -> None:
    for start, goal in ((0, 4), (at(0.0), at(4.0))):
        found = navigator.getRoute(start, goal)
        assert found is not None
        path, route = found
        assert (route.route_cost, path.poses) == (4.0, [])
    assert navigator.getRoute(0, at(1.0)) is None

    task = navigator.getAndTrackRoute(0, 4)
    assert task is RunningTask.COMPUTE_AND_TRACK_ROUTE
    passed: list[int] = []
    while len(passed) < 2:
        assert not navigator.isTaskComplete(trackingRoute=True)  # as its first release calls it
        while (feedback := navigator.getFeedback(task=task)) is not None:
            passed.append(feedback.last_node_id)
    assert passed == [1, 2]
    assert navigator.goToPose(at(1.0))
    while not navigator.isTaskComplete(task=RunningTask.NAVIGATE_TO_POSE):
        pass
    assert not navigator.isTaskComplete(task=task)
    nav2.tracked.set()
    while not navigator.isTaskComplete(task=task):
        pass
    assert navigator.getResult() is TaskResult.SUCCEEDED


def test_both_costmaps_are_cleared(navigator: BasicNavigator, nav2: StandIn) -> None:
    navigator.clearAllCostmaps()
    assert len(nav2.cleared) == 2


def test_time_allowances_may_have_fractions(
    navigator: BasicNavigator, monkeypatch: pytest.MonkeyPatch
) -> None:
    goals = list[Any]()
    monkeypatch.setattr(navigator, "_start", lambda client, goal, doing: goals.append(goal))
    navigator.spin(time_allowance=1.5)
    navigator.driveOnHeading(time_allowance=2.0)
    navigator.backup(time_allowance=4)
    navigator.assistedTeleop(3)
    found = [(each.time_allowance.sec, each.time_allowance.nanosec) for each in goals]
    assert found == [(1, 500_000_000), (2, 0), (4, 0), (3, 0)]


def test_a_server_that_is_not_there_is_named(
    navigator: BasicNavigator, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(task, "SERVER_TIMEOUT", 0.3)
    with pytest.raises(task.NavigatorError, match="the action 'spin' did not come within"):
        navigator.spin()
