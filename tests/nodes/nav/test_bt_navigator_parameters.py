"""bt_navigator's parameters: time-outs of servers, folders of trees, names on the blackboard."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from nav2_msgs.action import NavigateThroughPoses, Spin
from nav2_msgs.srv import ClearEntireCostmap
from rclpy.task import Future

from arjuna_core.ros.goal_client import GoalClient
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.nodes.trees.clients import TreeClients
from bringup.stack import BEHAVIOR_SERVER, BT_NAVIGATOR, LOCAL_COSTMAP
from tests.helpers.nav.navigation import SUCCEEDED, Goal, PlayedRobot, assert_failed, started
from tests.helpers.nav.navigator_goals import go, made, stamped, written_tree

HERE = SE2()
CLEAR = '<ClearEntireCostmap service_name="clear" {}/>'
SPIN = '<Spin spin_dist="3.0" {}/>'
WAITS = "<KeepRunningUntilFailure><AlwaysSuccess/></KeepRunningUntilFailure>"
SUCCEEDS, FAILS = "<AlwaysSuccess/>", "<AlwaysFailure/>"


def alone(**values: Any) -> PlayedRobot:
    """Return a robot with servers that spin, and a navigator with parameters."""
    specs = LOCAL_COSTMAP, BEHAVIOR_SERVER, BT_NAVIGATOR
    return started(*specs, settle=0.5, bt_navigator=values)


@pytest.mark.parametrize(
    ("port", "default", "limit"),
    [("", 1000, 1.0), ("", 2000, 2.0), ('server_timeout="400"', 2000, 0.4)],
)
@pytest.mark.parametrize("node", [CLEAR, SPIN])
def test_a_server_that_does_not_answer_is_given_up_after_its_time(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    node: str,
    port: str,
    default: int,
    limit: float,
) -> None:
    robot = alone(bt_folder=str(tmp_path), default_server_timeout=default)
    robot.bench.node.create_service(ClearEntireCostmap, "clear", lambda request, answer: answer)
    monkeypatch.setattr(TreeClients, "_call", lambda self, key, request: None)
    monkeypatch.setattr(GoalClient, "_on_response", lambda self, *answer: None)
    goal, since = go(robot, HERE, written_tree(tmp_path, node.format(port))), robot.now
    robot.run_until_done(goal, 5.0)
    assert limit < robot.now - since < limit + 0.45  # a look each 0.2 s, and one more


def test_a_server_that_answers_may_take_its_time(tmp_path: Path) -> None:
    robot = alone(bt_folder=str(tmp_path), default_server_timeout=20)
    robot.succeed(go(robot, HERE, written_tree(tmp_path, SPIN.format(""))), 10.0)


@pytest.mark.parametrize(("limit", "warned"), [(300, True), (3000, False)])
def test_a_cancel_without_an_answer_is_logged(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    limit: int,
    warned: bool,
) -> None:
    robot = alone(bt_folder=str(tmp_path), default_cancel_timeout=limit)
    goal = go(robot, HERE, written_tree(tmp_path, SPIN.format("")))
    robot.run(0.5)
    (handle,) = robot.nodes["bt_navigator"]._requests._client("Spin", "spin")._running.values()
    monkeypatch.setattr(handle, "cancel_goal_async", Future)
    goal.cancel()
    robot.run(1.0)
    assert ("spin: a cancel was not answered within 0.3 s" in capfd.readouterr().err) is warned


def test_trees_are_found_in_further_folders(tmp_path: Path) -> None:
    for name in ("own", "first", "second"):
        (tmp_path / name).mkdir()
    folders = [str(tmp_path / name) for name in ("first", "second")]
    robot = alone(bt_folder=str(tmp_path / "own"), bt_search_directories=folders)
    go(robot, HERE, written_tree(tmp_path / "second", SUCCEEDS, "other.xml"))
    written_tree(tmp_path / "first", FAILS, "both.xml")
    assert go(robot, HERE, "other.xml").status == SUCCEEDED
    assert_failed_by_tree(go(robot, HERE, written_tree(tmp_path / "second", SUCCEEDS, "both.xml")))


def assert_failed_by_tree(goal: Goal) -> None:
    assert goal.done
    assert "the behavior tree failed" in goal.result.error_msg


@pytest.mark.parametrize("reload", [True, False])
def test_a_tree_that_has_changed_is_read_again_where_asked(tmp_path: Path, reload: bool) -> None:
    robot = alone(bt_folder=str(tmp_path), always_reload_bt_xml=reload)
    assert go(robot, HERE, written_tree(tmp_path, SUCCEEDS)).status == SUCCEEDED
    changed = go(robot, HERE, written_tree(tmp_path, FAILS))
    assert (changed.status == SUCCEEDED) is not reload
    assert go(robot, HERE, written_tree(tmp_path, SUCCEEDS, "other.xml")).status == SUCCEEDED
    assert_failed_by_tree(go(robot, HERE, "mine.xml"))  # another tree drove before


@pytest.mark.parametrize("prefixes", [[], ["whirl"]])
def test_error_codes_are_found_by_their_prefix(tmp_path: Path, prefixes: list[str]) -> None:
    robot = alone(
        bt_folder=str(tmp_path), error_code_name_prefixes=prefixes, wait_for_service_timeout=0
    )
    port = 'server_name="whirl" error_code_id="{whirl_error_code}" error_msg="{whirl_error_msg}"'
    goal = go(robot, HERE, written_tree(tmp_path, SPIN.format(port)))
    robot.run(0.5)
    if prefixes:
        assert_failed(goal, Spin.Result.UNKNOWN, "whirl is not there")
    else:
        assert_failed_by_tree(goal)


@pytest.mark.parametrize("name", ["target", "goal"])
def test_the_goal_stands_under_its_name(tmp_path: Path, name: str) -> None:
    robot = alone(bt_folder=str(tmp_path), goal_blackboard_id="target")
    goal = go(robot, HERE, written_tree(tmp_path, f'<GoalReached goal="{{{name}}}"/>'))
    assert (goal.status == SUCCEEDED) is (name == "target")


@pytest.mark.parametrize("name", ["stops", "goals"])
def test_goals_stand_under_their_name(tmp_path: Path, name: str) -> None:
    robot = alone(bt_folder=str(tmp_path), goals_blackboard_id="stops")
    ports = f'input_goals="{{{name}}}" output_goals="{{left}}"'
    inside = f"<Sequence><RemovePassedGoals {ports}/>{WAITS}</Sequence>"
    request = NavigateThroughPoses.Goal(
        poses=[stamped(SE2(3.0)), stamped(SE2(4.0))], behavior_tree=written_tree(tmp_path, inside)
    )
    goal = robot.send(NavigateThroughPoses, "navigate_through_poses", request)
    robot.run(0.3)
    assert goal.done is (name == "goals")


@pytest.mark.parametrize("name", ["route", "path"])
@pytest.mark.parametrize("duration", [0.0, 0.6])
def test_feedback_has_path_name_and_mean_speed(tmp_path: Path, name: str, duration: float) -> None:
    ids = {"path_blackboard_id": "route", "filter_duration": duration}
    robot = made(bt_folder=str(tmp_path), **ids)
    plan = f'<ComputePathToPose goal="{{goal}}" path="{{{name}}}"/>'
    robot.command = Velocity(0.4)
    robot.run(0.4)
    goal = go(robot, SE2(3.0, 1.0), written_tree(tmp_path, f"<Sequence>{plan}{WAITS}</Sequence>"))
    robot.command = Velocity()
    robot.run(0.3)
    feedback = goal.feedback[-1]
    at = feedback.current_pose.pose.position
    straight = math.hypot(3.0 - at.x, 1.0 - at.y)  # which counts where no path is known
    assert (feedback.distance_remaining == pytest.approx(straight, abs=1e-3)) is (name == "path")
    left = feedback.estimated_time_remaining
    assert (left.sec > 2) is (duration > 0.0)
