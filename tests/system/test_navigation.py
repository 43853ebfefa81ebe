"""Navigation on a map through the whole robot: localized, simulated, in lock-step."""

from __future__ import annotations

import pytest
from action_msgs.msg import GoalStatus
from nav2_msgs.action import NavigateToPose

from arjuna_core.se2 import SE2
from bringup.lockstep import LockStep
from bringup.stack import (
    EXPLORER_GROUP,
    LOCALIZATION_GROUP,
    NAVIGATION_GROUP,
    SIM_GROUP,
    SLAM_GROUP,
)
from tests.helpers.robots import ON_MAP, REACHED, Stack, outcome, send, to_pose, truth

pytestmark = [pytest.mark.ros, pytest.mark.system]
GOAL = SE2(1.5, 1.0, 0.5)
TREE = "navigate_to_pose_w_replanning_and_recovery.xml"
STOPPING = 0.15  # from 0.4 m/s, command and motors have their delays [m]


def on_map(stack: Stack) -> LockStep:
    """Return a robot that knows its pose on the shipped map."""
    robot = stack(LOCALIZATION_GROUP, NAVIGATION_GROUP, parameters=ON_MAP)
    robot.run(1.0)
    return robot


def test_a_goal_on_a_map_is_reached_by_nav2s_own_tree(stack: Stack) -> None:
    robot = on_map(stack)
    end = outcome(robot, NavigateToPose, "navigate_to_pose", to_pose(GOAL, TREE))
    assert (end.status, end.result.error_msg) == (GoalStatus.STATUS_SUCCEEDED, "")
    assert truth(robot).distance(GOAL) < REACHED


def test_cancellation_stops_the_robot_within_its_stopping_distance(stack: Stack) -> None:
    robot = on_map(stack)
    goal = send(robot, NavigateToPose, "navigate_to_pose", to_pose(SE2(3.0, 1.2)))
    ended = goal.get_result_async()
    robot.run(5.0)
    before = truth(robot)
    robot.run(0.1)
    assert before.distance(truth(robot)) > 0.02  # it drives
    before = truth(robot)
    goal.cancel_goal_async()
    robot.process.drain()
    assert ended.result().status == GoalStatus.STATUS_CANCELED
    robot.run(1.0)
    stopped = truth(robot)
    assert before.distance(stopped) < STOPPING
    robot.run(2.0)
    assert stopped.distance(truth(robot)) < 0.005


def test_nothing_but_the_test_can_learn_the_truth(stack: Stack) -> None:
    on_slam = stack(SLAM_GROUP, NAVIGATION_GROUP, EXPLORER_GROUP)
    localized = stack(LOCALIZATION_GROUP, NAVIGATION_GROUP, parameters=ON_MAP)
    for robot in (on_slam, localized):
        robot.run(0.5)
        topics = [topic for topic, _ in robot.client.get_topic_names_and_types()]
        assert "/ground_truth/odom" in topics
        for topic in topics:
            if "truth" in topic:
                assert robot.client.get_subscriptions_info_by_topic(topic) == []
        transforms = robot.process.transforms
        assert transforms.try_lookup("world", "map") == SE2(0.0, 0.0, 0.0)
        elsewhere = SE2(1.0, 1.0, 0.0)  # the truth knows at once, the transforms must not
        robot.sim.simulator.robot.set_pose(elsewhere)
        robot.step()
        believed = transforms.try_lookup("world", "base_footprint")
        assert believed is None or believed.distance(elsewhere) > 0.5


def test_navigation_takes_no_part_of_the_simulator(stack: Stack) -> None:
    robot = on_map(stack)
    own = {spec.name for spec in SIM_GROUP.nodes}
    for name, node in robot.nodes.items():
        held = [
            item for item in vars(node).values() if type(item).__module__.startswith("arjuna_sim")
        ]
        assert name in own or held == []
