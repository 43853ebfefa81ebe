"""waypoint_follower: waypoints in turn, rounds, misses, and tasks by any name at each."""

from __future__ import annotations

import array
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from nav2_msgs.action import FollowWaypoints, NavigateToPose
from PIL import Image as Picture
from rclpy.lifecycle import TransitionCallbackReturn
from sensor_msgs.msg import Image
from std_msgs.msg import Empty

from arjuna_core.config import load, param
from arjuna_core.ros.convert import pose_stamped
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from arjuna_nav.nodes.waypoint_follower import WaypointFollowerConfig, WaypointFollowerNode
from bringup.stack import NAVIGATION_GROUP
from tests.helpers.nav.navigation import SUCCEEDED, Goal, PlayedRobot, assert_failed, started

UNKNOWN = FollowWaypoints.Result.UNKNOWN
OUTSIDE = SE2(9.0, 0.0)
SQUARE = SE2(0.5, 0.0), SE2(0.5, 0.5), SE2(0.0, 0.5)


def made(**parameters: Any) -> PlayedRobot:
    given = {"stop_on_failure": True, **parameters}
    return started(*NAVIGATION_GROUP.nodes, waypoint_follower=given)


def follow(robot: PlayedRobot, *poses: SE2, **fields: int) -> Goal:
    stamped = [pose_stamped(pose, "map", 0.0) for pose in poses]
    request = FollowWaypoints.Goal(poses=stamped, **fields)
    return robot.send(FollowWaypoints, "follow_waypoints", request)


def visited(robot: PlayedRobot, goal: Goal, timeout: float) -> list[int]:
    """Run to the goal's end; return the waypoints in the order in which they were come near to."""
    order: list[int] = []
    deadline = robot.now + timeout
    while not goal.done:
        robot.run(0.1)
        assert robot.now < deadline
        for k, pose in enumerate(SQUARE):
            if robot.pose.distance(pose) < 0.15 and order[-1:] != [k]:
                order.append(k)
    return order


def indices(goal: Goal) -> list[int]:
    """Return the waypoints that feedback names, without repetitions."""
    indices = [each.current_waypoint for each in goal.feedback]
    return [k for i, k in enumerate(indices) if indices[i - 1 : i] != [k]]


def test_waypoints_are_driven_to_in_turn_in_rounds_that_begin_where_asked(
    robot: PlayedRobot,
) -> None:
    goal = follow(robot, *SQUARE, number_of_loops=1, goal_index=1)
    assert visited(robot, goal, 80.0) == [1, 2, 0, 1, 2]
    assert (goal.status, goal.result.error_code, goal.result.error_msg) == (SUCCEEDED, 0, "")
    assert goal.result.missed_waypoints == []
    assert indices(goal) == [1, 2, 0, 1, 2]
    assert robot.command == STILL


def test_a_waypoint_that_is_not_reached_ends_it_all(robot: PlayedRobot) -> None:
    goal = follow(robot, SQUARE[0], OUTSIDE, SQUARE[1])
    robot.fail(goal, 30.0, UNKNOWN, "waypoint 1 of 3 was not reached")
    assert "outside the costmap" in goal.result.error_msg
    (missed,) = goal.result.missed_waypoints
    assert (missed.index, missed.error_code) == (1, 204)
    assert missed.goal.pose.position.x == OUTSIDE.x


def test_a_newer_list_replaces_the_running_one_without_a_stop(robot: PlayedRobot) -> None:
    older = follow(robot, SE2(3.0, 1.0), *SQUARE)
    robot.run(3.0)
    robot.forget()
    newer = follow(robot, SE2(2.0, 0.8), SE2(2.5, 1.0))
    assert_failed(older, UNKNOWN)
    robot.run(0.3)
    assert min(command.x for command in robot.commands) > 0.1
    robot.succeed(newer, 30.0)
    assert indices(newer) == [0, 1]


def test_a_list_without_its_waypoint_leaves_the_running_one_alone(robot: PlayedRobot) -> None:
    running = follow(robot, SE2(3.0, 1.0))
    robot.run(3.0)
    for poses, index, says in (((), 0, "0 poses"), (SQUARE, 3, "no waypoint 3")):
        assert_failed(follow(robot, *poses, goal_index=index), UNKNOWN, says)
    robot.run(0.5)
    assert not running.done
    assert robot.command.x > 0.2


def test_a_list_that_leads_nowhere_ends_also_what_it_was_to_replace(robot: PlayedRobot) -> None:
    running = follow(robot, SE2(3.0, 1.0))
    robot.run(3.0)
    goal = follow(robot, SE2(90.0, 0.0))
    assert_failed(running, UNKNOWN)
    assert_failed(goal, UNKNOWN)
    assert robot.command == STILL


def test_a_goal_of_someone_else_is_a_miss(robot: PlayedRobot) -> None:
    goal = follow(robot, SE2(3.0, 1.0))
    robot.run(2.0)
    request = NavigateToPose.Goal(pose=pose_stamped(SE2(0.5, 0.5), "map", 0.0))
    other = robot.send(NavigateToPose, "navigate_to_pose", request)
    assert_failed(goal, UNKNOWN, "replaced")
    robot.succeed(other, 20.0)


@pytest.mark.parametrize("transition", ["deactivate", "shutdown"])
def test_a_navigator_that_rests_or_goes_ends_it(robot: PlayedRobot, transition: str) -> None:
    goal = follow(robot, SE2(3.0, 1.0))
    robot.run(3.0)
    robot.transition("bt_navigator", transition)
    assert_failed(goal, UNKNOWN)
    robot.fail(follow(robot, SE2(1.0, 0.0)), 1.0, UNKNOWN, "navigate_to_pose")


NAV2 = "nav2_waypoint_follower::"
FAILED = FollowWaypoints.Result.TASK_EXECUTOR_FAILED


def with_task(plugin: str, stop: bool = True, **values: Any) -> PlayedRobot:
    """Return a robot whose waypoint follower does something under a name of its own."""
    task = {"plugin": plugin, **values}
    follower = {"waypoint_task_executor_plugin": "errand", "errand": task, "stop_on_failure": stop}
    return started(*NAVIGATION_GROUP.nodes, waypoint_follower=follower)


def wait_here(robot: PlayedRobot, count: int = 1) -> Goal:
    """Send waypoints where the robot is."""
    poses = [pose_stamped(SE2(), "map", 7.0)] * count
    request = FollowWaypoints.Goal(poses=poses)
    return robot.send(FollowWaypoints, "follow_waypoints", request)


def test_waiting_may_have_any_name() -> None:
    robot = with_task(NAV2 + "WaitAtWaypoint", waypoint_pause_duration=2000)
    goal = wait_here(robot, 2)
    robot.run(3.5)
    assert not goal.done
    robot.succeed(goal, 1.5)


def test_by_default_nothing_is_waited_for() -> None:
    config = WaypointFollowerConfig()
    assert config.waypoint_task_executor_plugin == "wait_at_waypoint"
    loaded: Any = load(WaypointFollowerConfig, {})
    assert loaded.wait_at_waypoint.plugin == NAV2 + "WaitAtWaypoint"
    assert (loaded.wait_at_waypoint.enabled, loaded.wait_at_waypoint.waypoint_pause_duration) == (
        True,
        0,
    )


@pytest.mark.parametrize("comes", [True, False])
@pytest.mark.parametrize("stop", [True, False])
def test_somebodys_word_is_waited_for(comes: bool, stop: bool) -> None:
    robot = with_task(NAV2 + "InputAtWaypoint", stop, timeout=4.0, input_topic="/word")
    robot.bench.publish(Empty, "/word", Empty())  # too early: it does not count
    goal = wait_here(robot)
    robot.run(3.0)
    assert not goal.done
    if comes:
        robot.bench.publish(Empty, "/word", Empty())
    robot.run_until_done(goal, 0.5 if comes else 3.0)
    if comes or not stop:
        assert goal.status == SUCCEEDED
    else:
        assert_failed(goal, FAILED, "nothing came on /word in 4 s")
    codes = [missed.error_code for missed in goal.result.missed_waypoints]
    assert codes == ([] if comes else [FAILED])


@pytest.mark.parametrize("image_format", ["png", "jpg"])
def test_a_picture_is_saved_at_each_waypoint(
    image_format: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    values: dict[str, Any] = {
        "image_topic": "/eye",
        "save_dir": "seen",
        "image_format": image_format,
    }
    robot = with_task(NAV2 + "PhotoAtWaypoint", **values)
    robot.fail(wait_here(robot), 5.0, FAILED, "no image has come on /eye")
    colours = np.zeros((4, 6, 3), np.uint8)
    colours[..., 2] = 200
    data = array.array("B", colours.tobytes())
    message = Image(height=4, width=6, encoding="bgr8", step=18, data=data)
    robot.bench.publish(Image, "/eye", message)
    robot.succeed(wait_here(robot, 2), 6.0)
    files = sorted(each.name for each in (tmp_path / "seen").iterdir())
    assert files == [f"0_7.{image_format}", f"1_7.{image_format}"]
    with Picture.open(tmp_path / "seen" / files[0]) as picture:
        assert picture.size == (6, 4)
        red, green, blue = np.asarray(picture.convert("RGB"))[2, 3]
    assert red > 190
    assert max(green, blue) < 10


@pytest.mark.parametrize(
    ("folder", "uid", "outcome"),
    [
        ("/tmp/waypoint_images", 0, TransitionCallbackReturn.SUCCESS),
        ("/tmp", 1, TransitionCallbackReturn.FAILURE),
        ("/srv/none", 0, TransitionCallbackReturn.FAILURE),
    ],
)
def test_pictures_go_into_folders_of_the_user_s_only(
    folder: str, uid: int, outcome: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("os.getuid", lambda: Path("/tmp").stat().st_uid + uid)
    robot, eye = PlayedRobot(), {"plugin": NAV2 + "PhotoAtWaypoint", "save_dir": folder}
    values = {"waypoint_task_executor_plugin": "eye", "eye": eye}
    node = WaypointFollowerNode(robot.bench.process, values)
    assert node.trigger_configure() == outcome


@dataclass(frozen=True)
class TwiceConfig:
    ticks: int = param(3, "Ticks that it takes.", minimum=1)


class Twice:
    """A task of one's own."""

    Config: ClassVar[type[Any]] = TwiceConfig
    seen: ClassVar[list[int]] = []

    def __init__(self, config: TwiceConfig, node: Any) -> None:
        self._ticks, self._left, self.problem = config.ticks, 0, ""

    def start(self, pose: Any, index: int, now: float) -> None:
        self._left = self._ticks
        self.seen.append(index)

    def tick(self, now: float) -> bool | None:
        self._left -= 1
        return None if self._left else True


def test_a_task_of_ones_own_is_run() -> None:
    robot = with_task(f"{__name__}:Twice", ticks=4)
    robot.succeed(wait_here(robot, 3), 10.0)
    assert Twice.seen == [0, 1, 2]
