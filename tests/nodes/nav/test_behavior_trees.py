"""bt_navigator with other trees than its own: Nav2's, a user's, along a route, and broken ones."""

from __future__ import annotations

from pathlib import Path

import pytest
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import NavigateThroughPoses
from nav2_msgs.msg import BehaviorTreeLog
from sensor_msgs.msg import BatteryState
from std_srvs.srv import Trigger

from arjuna_core.files.shipped import shipped_file
from arjuna_core.ros import qos
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from bringup.stack import NAVIGATION_GROUP
from tests.helpers.nav.navigation import (
    ABORTED,
    CANCELED,
    SUCCEEDED,
    Goal,
    PlayedRobot,
    assert_failed,
    started,
)
from tests.helpers.nav.navigator_goals import (
    GOAL,
    IN_BOX,
    TOLERANCE,
    assert_stopped_for_good,
    drive,
    go,
    made,
    stamped,
    written_tree,
)
from tests.helpers.nav.routes import written

TO_POSE = "navigate_to_pose_w_replanning_and_recovery.xml"
THROUGH = "navigate_through_poses_w_replanning_and_recovery.xml"
PLAN = '<ComputePathToPose goal="{goal}" path="{path}" planner_id="GridBased"/>'


@pytest.fixture
def robot(tmp_path: Path) -> PlayedRobot:
    return made(bt_folder=str(tmp_path))


def through(robot: PlayedRobot, *poses: SE2) -> Goal:
    request = NavigateThroughPoses.Goal(poses=[stamped(p) for p in poses], behavior_tree=THROUGH)
    return robot.send(NavigateThroughPoses, "navigate_through_poses", request)


def test_nav2s_default_tree_replans_once_a_second_and_its_nodes_are_logged(
    robot: PlayedRobot,
) -> None:
    log = robot.bench.collect(BehaviorTreeLog, "behavior_tree_log")
    goal = go(robot, GOAL, f"/opt/ros/jazzy/share/{TO_POSE}")
    robot.run(3.05)
    named = [c for m in log for c in m.event_log if c.node_name == "ComputePathToPose"]
    plans = max(c.uid for c in named)  # the innermost of that name
    assert [c.current_status for c in named if c.uid == plans].count("RUNNING") in (3, 4)
    assert robot.command.x > 0.2  # a new path is taken without a stop
    robot.run_until_done(goal, 30.0)
    assert (goal.status, goal.result.error_code, goal.result.error_msg) == (SUCCEEDED, 0, "")
    assert robot.pose.distance(GOAL) < TOLERANCE
    assert_stopped_for_good(robot)
    changes = [change for message in log for change in message.event_log]
    assert ("FollowPath", "RUNNING", "SUCCESS") in {
        (change.node_name, change.previous_status, change.current_status) for change in changes
    }
    assert changes[0].node_name == "NavigateRecovery"
    assert goal.feedback[-1].distance_remaining < 0.4 < goal.feedback[10].distance_remaining


def test_poses_are_passed_by_nav2s_default_tree(robot: PlayedRobot) -> None:
    goal = through(robot, SE2(1.5, 1.0), SE2(0.0, 1.8), SE2(-1.2, 0.5))
    robot.succeed(goal, 60.0)
    assert robot.pose.distance(SE2(-1.2, 0.5)) < TOLERANCE
    left = [each.number_of_poses_remaining for each in goal.feedback]
    assert (left[0], left[-1]) == (3, 1)


def test_a_goal_that_cannot_be_reached_is_recovered_from_and_given_up(robot: PlayedRobot) -> None:
    goal = go(robot, IN_BOX, TO_POSE)
    robot.run_until_done(goal, 120.0)
    assert goal.result.error_code in (206, 208)
    if goal.result.error_code == 208:
        assert goal.feedback[-1].number_of_recoveries >= 6
    assert goal.result.error_msg
    assert robot.command == STILL


def test_a_newer_goal_replaces_the_running_one_of_the_same_tree(robot: PlayedRobot) -> None:
    older = go(robot, SE2(3.0, 1.0), TO_POSE)
    drive(robot)
    robot.forget()
    newer = go(robot, SE2(3.0, 1.4), TO_POSE)
    robot.run(1.2)
    assert_failed(older, 0)
    assert min(command.x for command in robot.commands) > 0.1
    assert_failed(go(robot, GOAL), 0, TO_POSE)  # by the default tree
    robot.succeed(newer, 30.0)
    assert robot.pose.distance(SE2(3.0, 1.4)) < TOLERANCE


def test_a_goal_moved_at_the_last_moment_is_still_gone_to(robot: PlayedRobot) -> None:
    """The path to the old goal may end before the next one is planned."""
    go(robot, SE2(0.6, 0.0), TO_POSE)
    while robot.pose.distance(SE2(0.6, 0.0)) > TOLERANCE + 0.05:
        robot.run(0.02)
    robot.succeed(go(robot, SE2(0.6, 1.2), TO_POSE), 30.0)
    assert robot.pose.distance(SE2(0.6, 1.2)) < TOLERANCE


def test_a_tree_of_ones_own(robot: PlayedRobot, tmp_path: Path) -> None:
    name = written_tree(
        tmp_path,
        f'<Sequence>{PLAN}<SmoothPath unsmoothed_path="{{path}}" smoothed_path="{{smooth}}"/>'
        '<IsPathValid path="{smooth}"/><FollowPath path="{smooth}" controller_id="FollowPath"/>'
        '<Spin spin_dist="0.5"/><Wait wait_duration="1.0"/>'
        '<ClearCostmapAroundRobot service_name="local_costmap/clear_around_local_costmap"/>'
        "</Sequence>",
    )
    goal = go(robot, GOAL, name)
    robot.run_until_done(goal, 60.0)
    assert goal.status == SUCCEEDED, goal.result.error_msg
    assert robot.pose.distance(GOAL) < TOLERANCE
    assert robot.pose.theta - GOAL.theta == pytest.approx(0.5, abs=0.25)
    assert goal.feedback[-1].number_of_recoveries in (2, 3)  # the last is over at once


def test_a_tree_of_nav2s_replans_only_where_the_path_is_not_free(robot: PlayedRobot) -> None:
    log = robot.bench.collect(BehaviorTreeLog, "behavior_tree_log")
    go(robot, GOAL, "navigate_w_replanning_only_if_path_becomes_invalid.xml")
    robot.run(4.0)
    changes = [change for message in log for change in message.event_log]
    running = [c.node_name for c in changes if c.current_status == "RUNNING"]
    plans = {c.uid for c in changes if c.node_name == "ComputePathToPose"}
    assert running.count("ComputePathToPose") == len(plans)
    assert running.count("IsPathValid") > 3


@pytest.mark.parametrize(
    "name", sorted(path.name for path in shipped_file("behavior_trees").glob("navigate_w_*.xml"))
)
def test_a_goal_is_reached_by_each_shipped_tree_of_nav2(robot: PlayedRobot, name: str) -> None:
    goal = go(robot, GOAL, name)
    robot.run_until_done(goal, 40.0)
    assert goal.status == SUCCEEDED, goal.result.error_msg
    assert robot.pose.distance(GOAL) < TOLERANCE


def test_a_goal_that_is_moved_is_followed(robot: PlayedRobot, tmp_path: Path) -> None:
    """The shape of Nav2's follow_point: the tree never ends, the robot keeps its distance."""
    name = written_tree(
        tmp_path,
        '<PipelineSequence><RateController hz="1.0"><Sequence>'
        '<GoalUpdater input_goal="{goal}" output_goal="{moved}">'
        '<ComputePathToPose goal="{moved}" path="{path}"/></GoalUpdater>'
        '<TruncatePath distance="0.5" input_path="{path}" output_path="{short}"/></Sequence>'
        '</RateController><KeepRunningUntilFailure><FollowPath path="{short}"/>'
        "</KeepRunningUntilFailure></PipelineSequence>",
    )
    goal = go(robot, SE2(1.5, 0.0), name)
    robot.run(8.0)
    assert robot.pose.distance(SE2(1.0, 0.0)) < 0.3
    robot.bench.publish(PoseStamped, "goal_update", stamped(SE2(1.5, 1.5)))
    robot.run(10.0)
    assert robot.pose.distance(SE2(1.5, 1.5)) < 0.8
    assert not goal.done
    goal.cancel()
    assert goal.status == CANCELED
    assert_stopped_for_good(robot)


def test_a_tree_that_is_wrong_ends_its_goal(robot: PlayedRobot, tmp_path: Path) -> None:
    for inside, says in (
        ("<ComputePath/>", "there is no node 'ComputePath'; did you mean 'ComputePathToPose'?"),
        ("<FollowPath path='{path}'/>", "{path} is not on the blackboard"),
        ("<Spin server_name='whirl'/>", "the behavior tree failed"),
        ("<AlwaysFailure/>", "the behavior tree failed"),
    ):
        goal = go(robot, GOAL, written_tree(tmp_path, inside))
        robot.run_until_done(goal, 5.0)
        assert goal.result.error_code == 0
        assert says in goal.result.error_msg
    robot.succeed(go(robot, SE2(0.4, 0.0)), 30.0)


def test_a_tree_outside_the_folder_is_not_read(robot: PlayedRobot) -> None:
    for name in ("none.xml", "../secret.xml", "/etc/passwd"):
        goal = go(robot, GOAL, name)
        assert_failed(goal, 0, f"there is no behavior tree '{name}'")
        assert "bt_folder" in goal.result.error_msg


def test_a_default_tree_that_does_not_exist_is_refused(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(AssertionError, match="bt_navigator did not configure"):
        made(default_nav_to_pose_bt_xml="nothing.xml")
    assert "there is no behavior tree 'nothing.xml'" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("name", "node"),
    [("", "WaitOutOutage"), ("navigate_to_pose.xml", "WaitOutOutage"), ("mine.xml", "Mine")],
)
def test_goals_that_name_no_tree_are_driven_by_the_default(
    tmp_path: Path, name: str, node: str
) -> None:
    written_tree(tmp_path, f'<Sequence name="Mine">{PLAN}<FollowPath path="{{path}}"/></Sequence>')
    file = tmp_path / name if name == "mine.xml" else name
    robot = made(default_nav_to_pose_bt_xml=str(file))
    log = robot.bench.collect(BehaviorTreeLog, "behavior_tree_log")
    go(robot, GOAL)
    robot.run(1.5)
    assert node in {each.node_name for each in log[0].event_log}
    assert robot.command.x > 0.1


TREE = """
<root BTCPP_format="4"><BehaviorTree ID="Route"><Sequence>
  <TransformAvailable parent="map" child="base_footprint"/>
  <Inverter><IsBatteryLow battery_topic="/battery" min_battery="0.2"/></Inverter>
  <Parallel success_count="2">
    <ComputeAndTrackRoute goal="{goal}" use_poses="true" next_node_id="{next}"/>
    <Sequence>
      <ComputeRoute goal="{goal}" use_poses="true" path="{path}" route="{route}"/>
      <GetPoseFromPath path="{path}" index="-1" pose="{end}"/>
      <FollowPath path="{path}"/>
    </Sequence>
  </Parallel>
</Sequence></BehaviorTree></root>
"""


def on_a_route(tmp_path: Path) -> PlayedRobot:
    (tmp_path / "route.xml").write_text(TREE, encoding="utf-8")
    tree = {"bt_folder": str(tmp_path)}
    route = {
        "graph_filepath": str(written(tmp_path)),
        "radius_to_achieve_node": 0.5,
        "edge_cost_functions": ["DistanceScorer", "CostmapScorer"],
        "operations": ["AdjustSpeedLimit", "ReroutingService", "CollisionMonitor"],
    }
    return started(*NAVIGATION_GROUP.nodes, bt_navigator=tree, route_server=route)


def test_a_route_is_driven_unless_the_battery_is_empty(tmp_path: Path) -> None:
    robot = on_a_route(tmp_path)
    goal = go(robot, SE2(0.0, 4.1), "route.xml")
    robot.run_until_done(goal, 40.0)
    assert (goal.status, goal.result.error_msg) == (SUCCEEDED, "")
    assert robot.pose.distance(SE2(0.0, 4.0)) < TOLERANCE
    battery = robot.bench.node.create_publisher(BatteryState, "/battery", qos.DEFAULT)
    robot.run(0.2)
    battery.publish(BatteryState(percentage=0.1))
    robot.run(0.2)
    goal = go(robot, SE2(0.3, 0.1), "route.xml")
    robot.run_until_done(goal, 5.0)
    assert goal.status == ABORTED
    assert robot.pose.distance(SE2(0.0, 4.0)) < TOLERANCE


def test_a_tree_pauses_by_its_services(robot: PlayedRobot, tmp_path: Path) -> None:
    services = 'pause_service_name="pause" resume_service_name="resume"'
    drives = f'<Sequence>{PLAN}<FollowPath path="{{path}}"/></Sequence>'
    inside = f"<PauseResumeController {services}>{drives}</PauseResumeController>"
    goal = go(robot, SE2(1.5, 0.0), written_tree(tmp_path, inside))
    drive(robot)
    assert robot.bench.call(Trigger, "pause", Trigger.Request()).success
    robot.run(1.5)
    assert robot.command == STILL
    again = robot.bench.call(Trigger, "pause", Trigger.Request())
    assert (again.success, again.message) == (False, "PauseResumeController is paused already")
    assert robot.bench.call(Trigger, "resume", Trigger.Request()).success
    robot.run_until_done(goal, 30.0)
    assert goal.status == SUCCEEDED
    assert not robot.bench.call(Trigger, "pause", Trigger.Request()).success
