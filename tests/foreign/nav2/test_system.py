"""Nav2's system tests, by clients of its interfaces alone."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav2_msgs.action import FollowWaypoints, NavigateThroughPoses, NavigateToPose
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from simulation_interfaces.srv import SpawnEntity

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, planar_covariance, pose_msg, pose_stamped
from arjuna_core.ros.local.actions import action_client
from arjuna_core.se2 import SE2
from bringup.lockstep import LockStep
from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP
from tests.foreign.nav2.waffle import START, in_its_world

pytestmark = [pytest.mark.ros, pytest.mark.system]
GOAL = SE2(-0.5, 1.8, 0.0)
NEAR = SE2(-1.5, 0.5, 0.0)
OUTSIDE = SE2(100.0, 100.0, 0.0)
REACHED = 0.35  # nav2's tolerance of 0.25 m, and what localization errs
BOX = (
    '<sdf version="1.7"><model name="box"><static>true</static><link name="link">'
    '<collision name="c"><geometry><box><size>0.25 0.25 0.5</size></box></geometry></collision>'
    "</link></model></sdf>"
)


class User:
    """A client of a robot.

    Args:
        robot: The robot.
    """

    def __init__(self, robot: LockStep) -> None:
        self.robot = robot
        self._pose = robot.client.create_publisher(
            PoseWithCovarianceStamped, "initialpose", qos.DEFAULT
        )
        robot.process.drain()

    @property
    def truth(self) -> SE2:
        pose: SE2 = self.robot.sim.last.truth.pose
        return pose

    def say_where(self, pose: SE2) -> None:
        """Publish an initial pose, as RViz does."""
        message = PoseWithCovarianceStamped(header=header("map", self.robot.now))
        message.pose.pose = pose_msg(pose)
        message.pose.covariance = planar_covariance(np.diag([0.25, 0.25, 0.07]))
        self._pose.publish(message)
        self.robot.run(1.0)

    def send(self, action: Any, name: str, goal: Any) -> Any:
        """Send a goal; return its handle."""
        client = action_client(self.robot.client, action, name)
        self.robot.process.drain()
        sent = client.send_goal_async(goal)
        self.robot.run_until(sent.done, 5.0, "an answer")
        return sent.result()

    def end(self, handle: Any, timeout: float = 120.0) -> tuple[int, Any]:
        """Return status and result of a goal."""
        outcome = handle.get_result_async()
        self.robot.run_until(outcome.done, timeout, "the goal's end")
        return outcome.result().status, outcome.result().result

    def pose(self, pose: SE2) -> Any:
        return pose_stamped(pose, "map", self.robot.now)

    def to_pose(self, pose: SE2) -> Any:
        goal = NavigateToPose.Goal(pose=self.pose(pose))
        return self.send(NavigateToPose, "navigate_to_pose", goal)

    def along(self, *poses: SE2) -> Any:
        goal = FollowWaypoints.Goal(poses=[self.pose(pose) for pose in poses])
        return self.send(FollowWaypoints, "follow_waypoints", goal)


@pytest.fixture
def alone(tmp_path: Path) -> Iterator[User]:
    """A user of a robot of its own, for tests that leave something behind."""
    with closing(in_its_world(tmp_path)) as robot:
        user = User(robot)
        user.say_where(START)
        yield user


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[User]:
    with closing(in_its_world(tmp_path_factory.mktemp("world"))) as robot:
        yield User(robot)


@pytest.fixture
def user(shared: User) -> User:
    shared.robot.sim.simulator.robot.set_pose(START)
    shared.robot.run(0.5)
    shared.say_where(START)
    return shared


def test_a_goal_is_reached_though_the_first_initial_pose_was_wrong(alone: User) -> None:
    alone.say_where(SE2(-1.0, 0.5, 1.5))
    alone.say_where(START)
    status, result = alone.end(alone.to_pose(GOAL))
    assert (status, result.error_code) == (GoalStatus.STATUS_SUCCEEDED, 0)
    assert alone.truth.distance(GOAL) < REACHED


def test_a_goal_yields_to_the_next(user: User) -> None:
    first = user.to_pose(GOAL)
    user.robot.run(2.0)
    second = user.to_pose(NEAR)
    assert user.end(first)[0] == GoalStatus.STATUS_ABORTED
    assert user.end(second)[0] == GoalStatus.STATUS_SUCCEEDED
    assert user.truth.distance(NEAR) < REACHED


def test_poses_are_passed_and_none_is_no_goal(user: User) -> None:
    name, action = "navigate_through_poses", NavigateThroughPoses
    through = [user.pose(NEAR), user.pose(SE2(-1.2, 1.7, 0.0)), user.pose(GOAL)]
    status, _ = user.end(user.send(action, name, action.Goal(poses=through)))
    assert status == GoalStatus.STATUS_SUCCEEDED
    assert user.truth.distance(GOAL) < REACHED
    none = user.send(action, name, action.Goal(poses=[]))
    assert not none.accepted or user.end(none)[0] == GoalStatus.STATUS_ABORTED
    beyond = action.Goal(poses=[user.pose(OUTSIDE)])
    refused = user.send(action, name, beyond)
    assert not refused.accepted or user.end(refused)[0] == GoalStatus.STATUS_ABORTED


def test_waypoints_are_followed_preempted_and_cancelled(user: User) -> None:
    first = user.along(GOAL)
    user.robot.run(1.0)
    second = user.along(NEAR, SE2(-2.0, 0.2, 0.0))
    status, result = user.end(second)
    assert status == GoalStatus.STATUS_SUCCEEDED
    assert not result.missed_waypoints
    assert user.end(first)[0] != GoalStatus.STATUS_SUCCEEDED
    third = user.along(GOAL)
    user.robot.run(1.0)
    third.cancel_goal_async()
    assert user.end(third)[0] == GoalStatus.STATUS_CANCELED


@pytest.mark.parametrize("stop", [True, False])
def test_a_waypoint_that_cannot_be_reached_stops_where_asked(alone: User, stop: bool) -> None:
    value = Parameter("stop_on_failure", value=stop).to_parameter_msg()
    request = SetParameters.Request(parameters=[value])
    answer = alone.robot.call(SetParameters, "/waypoint_follower/set_parameters", request)
    assert answer.results[0].successful
    status, result = alone.end(alone.along(OUTSIDE, NEAR))
    assert [missed.index for missed in result.missed_waypoints][:1] == [0]
    assert (status == GoalStatus.STATUS_ABORTED) == stop
    assert (alone.truth.distance(NEAR) < REACHED) == (not stop)


def test_an_obstacle_that_the_map_lacks_is_gone_round(alone: User) -> None:
    request = SpawnEntity.Request(name="box")
    request.entity_resource.resource_string = BOX
    request.initial_pose = pose_stamped(SE2(-1.9, 0.5, 0.0), "world", 0.0)
    assert alone.robot.call(SpawnEntity, "/spawn_entity", request).result.result == 1
    touched: list[Any] = []
    alone.robot.on_tick = lambda: touched.extend(alone.robot.sim.last.contacts)
    status, _ = alone.end(alone.to_pose(SE2(-1.5, 1.2, 1.57)))
    assert status == GoalStatus.STATUS_SUCCEEDED
    assert touched == []


def test_a_goal_that_fails_leaves_the_robot_ready_for_the_next(user: User) -> None:
    failing = user.to_pose(SE2(0.0, 0.0, 0.0))  # in a pillar
    if failing.accepted:
        status, result = user.end(failing)
        assert status in (GoalStatus.STATUS_ABORTED, GoalStatus.STATUS_SUCCEEDED)
        assert (status == GoalStatus.STATUS_ABORTED) == bool(result.error_code)
    assert user.end(user.to_pose(NEAR))[0] == GoalStatus.STATUS_SUCCEEDED


def test_up_and_down_without_an_error(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    with closing(in_its_world(tmp_path)) as robot:
        for _ in range(2):
            robot.stop(LOCALIZATION_GROUP, NAVIGATION_GROUP)
            robot.start(LOCALIZATION_GROUP, NAVIGATION_GROUP)
            robot.run(1.0)
        user = User(robot)
        user.say_where(START)
        assert user.end(user.to_pose(NEAR))[0] == GoalStatus.STATUS_SUCCEEDED
    assert "[ERROR]" not in capfd.readouterr().err
