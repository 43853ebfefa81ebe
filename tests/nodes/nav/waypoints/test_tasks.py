"""Waypoint tasks by any name: to wait, a picture, a message, one of one's own."""

from __future__ import annotations

import array
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from nav2_msgs.action import FollowWaypoints
from PIL import Image as Picture
from rclpy.lifecycle import TransitionCallbackReturn
from sensor_msgs.msg import Image
from std_msgs.msg import Empty

from arjuna_core.config import load, param
from arjuna_core.errors import ConfigError
from arjuna_core.ros.convert import pose_stamped
from arjuna_core.se2 import SE2
from arjuna_nav.nodes.waypoint_follower import WaypointFollowerConfig, WaypointFollowerNode
from bringup.stack import NAVIGATION_GROUP
from tests.helpers.nav.navigation import SUCCEEDED, Goal, PlayedRobot, assert_failed, started

NAV2 = "nav2_waypoint_follower::"
FAILED = FollowWaypoints.Result.TASK_EXECUTOR_FAILED


def made(plugin: str, stop: bool = True, **values: Any) -> PlayedRobot:
    """Return a robot whose waypoint follower does something under a name of its own."""
    task = {"plugin": plugin, **values}
    follower = {"waypoint_task_executor_plugin": "errand", "errand": task, "stop_on_failure": stop}
    return started(*NAVIGATION_GROUP.nodes, waypoint_follower=follower)


def follow(robot: PlayedRobot, count: int = 1) -> Goal:
    """Send waypoints where the robot is."""
    poses = [pose_stamped(SE2(), "map", 7.0)] * count
    request = FollowWaypoints.Goal(poses=poses)
    return robot.send(FollowWaypoints, "follow_waypoints", request)


def test_waiting_may_have_any_name() -> None:
    robot = made(NAV2 + "WaitAtWaypoint", waypoint_pause_duration=2000)
    goal = follow(robot)
    robot.run(1.8)
    assert not goal.done
    robot.run_until_done(goal, 1.5)
    assert goal.status == SUCCEEDED


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
    robot = made(NAV2 + "InputAtWaypoint", stop, timeout=4.0, input_topic="/word")
    robot.bench.publish(Empty, "/word", Empty())  # too early: it does not count
    goal = follow(robot)
    robot.run(3.0)
    assert not goal.done
    if comes:
        robot.bench.publish(Empty, "/word", Empty())
    robot.run_until_done(goal, 0.5 if comes else 3.0)
    if comes or not stop:
        assert goal.status == SUCCEEDED
    else:
        assert_failed(goal, FAILED)
        assert "nothing came on /word in 4 s" in goal.result.error_msg
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
    robot = made(NAV2 + "PhotoAtWaypoint", **values)
    goal = follow(robot)
    robot.run_until_done(goal, 5.0)
    assert_failed(goal, FAILED)
    assert "no image has come on /eye" in goal.result.error_msg
    colours = np.zeros((4, 6, 3), np.uint8)
    colours[..., 2] = 200
    data = array.array("B", colours.tobytes())
    message = Image(height=4, width=6, encoding="bgr8", step=18, data=data)
    robot.bench.publish(Image, "/eye", message)
    goal = follow(robot, 2)
    robot.run_until_done(goal, 6.0)
    assert goal.status == SUCCEEDED
    files = sorted(each.name for each in (tmp_path / "seen").iterdir())
    assert files == [f"0_7.{image_format}", f"1_7.{image_format}"]
    with Picture.open(tmp_path / "seen" / files[0]) as picture:
        assert picture.size == (6, 4)
        red, green, blue = np.asarray(picture.convert("RGB"))[2, 3]
    assert red > 190
    assert max(green, blue) < 10


def test_pictures_go_below_home_or_the_working_folder_only() -> None:
    robot = PlayedRobot()
    values = {"waypoint_task_executor_plugin": "eye", "eye": {"plugin": NAV2 + "PhotoAtWaypoint"}}
    node = WaypointFollowerNode(robot.bench.process, values)
    assert node.trigger_configure() == TransitionCallbackReturn.FAILURE


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
    robot = made(f"{__name__}:Twice", ticks=4)
    goal = follow(robot, 3)
    robot.run_until_done(goal, 10.0)
    assert goal.status == SUCCEEDED
    assert Twice.seen == [0, 1, 2]


def test_a_task_that_there_is_not_is_refused() -> None:
    values = {"waypoint_task_executor_plugin": "errand", "errand": {"plugin": "a::Coffee"}}
    with pytest.raises(
        ConfigError, match=r"'errand\.plugin': no waypoint task 'a::Coffee'; valid: "
    ):
        load(WaypointFollowerConfig, values)
