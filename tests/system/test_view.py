"""`view` in a real browser: the page loads, a drag sends a goal, the robot arrives."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS here")
pytest.importorskip("viser", reason="no viewer here")

from geometry_msgs.msg import PointStamped
from simulation_interfaces.msg import Result
from simulation_interfaces.srv import SetEntityState

from arjuna_core.ros.convert import pose_msg
from arjuna_core.se2 import SE2
from bringup.lockstep import LockStep
from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP
from bringup.viewing.browser.server import open_server
from bringup.viewing.browser.viewer import Viewer
from bringup.viewing.robot.robot_side import RobotOptions, RobotSide
from tests.helpers.chromium import Page, find
from tests.helpers.robots import ROOM

BROWSER = find()
pytestmark = [
    pytest.mark.ros,
    pytest.mark.system,
    pytest.mark.skipif(BROWSER is None, reason="no Chromium here"),
]
KEPT = "ARJUNA_SCREENSHOTS"  # a folder to keep screenshots in
LOADING = 300  # pictures that a browser without a GPU may need to show the first


class Watched:
    """A lock-step robot under a viewer, watched by a browser."""

    def __init__(self, robot: LockStep, folder: Path) -> None:
        self.robot = robot
        with ExitStack() as opened:
            self.side = RobotSide(RobotOptions(), robot.process.context)
            opened.callback(self.side.close)
            server = open_server("127.0.0.1", 0)
            opened.callback(server.stop)
            self.viewer = Viewer(server, self.side)
            assert BROWSER is not None
            self.page = opened.enter_context(
                Page(BROWSER, folder, f"http://127.0.0.1:{server.get_port()}")
            )
            self._opened = opened.pop_all()

    def until(self, done: Callable[[], Any], pictures: int, ticks: int = 5) -> None:
        """Run the robot, some ticks for each picture, and the viewer until something is done."""
        for _ in range(pictures):
            if done():
                return
            for _ in range(ticks):
                self.robot.step()
            self.viewer.step(0.01)
        assert done(), f"not within {pictures} pictures; the page says: {self.page.text()}"

    def press(self, label: str, answer: str) -> None:
        """Press a button until the page says that it was; a page that loads may miss it."""
        for _ in range(10):
            self.page.press(label)
            for _ in range(10):
                self.viewer.step(0.05)
            if answer in self.page.text():
                return
        pytest.fail(f"{label!r} does nothing; the page says: {self.page.text()}")

    def says(self, text: str) -> Callable[[], bool]:
        return lambda: text in self.page.text()

    def close(self) -> None:
        self._opened.close()


@pytest.fixture
def watched(stack: Callable[..., LockStep], tmp_path: Path) -> Iterator[Watched]:
    groups = LOCALIZATION_GROUP, NAVIGATION_GROUP
    robot = stack(*groups, parameters=ROOM, transport="dds")  # the viewer has nodes of its own
    with closing(Watched(robot, tmp_path / "profile")) as made:
        made.until(lambda: made.side.frames.fixed, LOADING)
        made.until(made.says("2D goal"), LOADING)
        yield made


SPOT, ITS_RIGHT = (200.0, 200.0), (260.0, 200.0)  # pixels of the ground


def kept(page: Page, name: str, folder: Path) -> None:
    """Keep a screenshot where one is wanted."""
    picture = page.screenshot()
    assert picture.startswith(b"\x89PNG")
    (Path(os.environ.get(KEPT, folder)) / name).write_bytes(picture)


def test_a_drag_on_the_ground_sends_the_robot_there(watched: Watched, tmp_path: Path) -> None:
    page, navigation = watched.page, watched.side.navigation
    watched.press("2D goal", "drag to where it shall look")
    page.drag(SPOT, ITS_RIGHT)
    watched.until(lambda: navigation.state.state == "driving", 100)
    watched.until(watched.says("m to go"), 50)
    watched.until(lambda: navigation.state.state == "arrived", 120, ticks=25)
    watched.until(watched.says("arrived"), 50)
    kept(page, "view.png", tmp_path)
    facing = watched.robot.sim.simulator.robot.truth().pose.theta
    assert abs(facing) < 0.3  # as it was dragged: to the right


def test_a_pose_estimate_localizes_a_kidnapped_robot(watched: Watched, tmp_path: Path) -> None:
    page, robot = watched.page, watched.robot
    clicked: list[PointStamped] = []
    robot.client.create_subscription(PointStamped, "clicked_point", clicked.append, 10)
    watched.press("publish point", "Click on the ground")
    page.drag(SPOT, SPOT)
    watched.until(lambda: clicked, 50)
    spot = SE2(clicked[-1].point.x, clicked[-1].point.y, 0.0)
    request = SetEntityState.Request(entity="arjuna", set_pose=True)
    request.state.pose = pose_msg(spot)
    assert robot.call(SetEntityState, "set_entity_state", request).result.result == Result.RESULT_OK
    assert apart(watched) > 0.5
    watched.press("2D pose estimate", "drag to where it looks")
    page.drag(SPOT, ITS_RIGHT)
    watched.until(lambda: apart(watched) < 0.1, 100)
    kept(page, "estimate.png", tmp_path)


def apart(watched: Watched) -> float:
    """Return how far from the truth the robot believes to be [m]."""
    believed = watched.robot.nodes["amcl"].transforms.try_lookup("map", "base_link")
    truth = watched.robot.sim.simulator.robot.truth().pose
    return math.inf if believed is None else float(believed.distance(truth))


def test_the_stop_button_ends_the_goal_and_the_robot_stands(
    watched: Watched, tmp_path: Path
) -> None:
    page, navigation = watched.page, watched.side.navigation
    watched.press("2D goal", "drag to where it shall look")
    page.drag(SPOT, ITS_RIGHT)
    watched.until(lambda: navigation.state.state == "driving", 100)
    watched.until(lambda: abs(watched.robot.sim.simulator.robot.truth().v) > 0.1, 100)
    page.press("Stop")
    watched.until(watched.says("cancelled"), 100)
    watched.robot.run(1.0)
    assert abs(watched.robot.sim.simulator.robot.truth().v) < 0.01
    kept(page, "stop.png", tmp_path)
