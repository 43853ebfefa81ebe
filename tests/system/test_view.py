"""`view` in a real browser: the page loads, a drag sends a goal, the robot arrives."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

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
from bringup.viewing.robot.robot_side import RobotSide
from tests.helpers.chromium import Page, find
from tests.helpers.processes import wait_until
from tests.helpers.robots import ROOM, Stack

BROWSER = find()
pytestmark = [
    pytest.mark.ros,
    pytest.mark.system,
    pytest.mark.skipif(BROWSER is None, reason="no Chromium here"),
]
KEPT = "ARJUNA_SCREENSHOTS"  # a folder to keep screenshots in
PATIENCE = 240.0  # [s, wall]: a browser without a GPU on a busy machine


class Watched:
    """A lock-step robot under a viewer, watched by a browser."""

    def __init__(self, robot: LockStep, folder: Path) -> None:
        self.robot = robot
        with ExitStack() as opened:
            self.side = RobotSide(robot.process.context)
            opened.callback(self.side.close)
            server = self.server = open_server("127.0.0.1", 0)
            opened.callback(server.stop)
            self.viewer = Viewer(server, self.side)
            assert BROWSER is not None
            self.page = opened.enter_context(
                Page(BROWSER, folder, f"http://127.0.0.1:{server.get_port()}")
            )
            self._opened = opened.pop_all()

    def until(self, done: Callable[[], Any], ticks: int = 5) -> None:
        """Run the viewer, and the robot some ticks a picture, until something is done."""

        def step() -> None:
            for _ in range(ticks):
                self.robot.step()
            self.viewer.step(0.05)

        wait_until(done, step, self, PATIENCE)

    def until_it_says(self, text: str) -> None:
        """Wait for the page with the robot's time standing still: what it shall say stays so."""
        self.until(lambda: text in self.page.text(), ticks=0)

    def press(self, label: str, answer: str) -> None:
        """Press a button and wait until the page says and shows that it was."""
        self.page.press(label)
        self.until_it_says(answer)
        self.page.draw()  # words come first; a drag before the scene follows turns the view

    @property
    def looks_at(self) -> list[Any]:
        """The point that the page looks at, as it says itself [m]."""
        return [each.camera.look_at for each in self.server.get_clients().values()]

    def looks_at_map(self) -> bool:
        """Return whether the page does as it was asked to when the map came."""
        middle = self.viewer._scene._middle
        return any(np.allclose(point, middle, atol=0.01) for point in self.looks_at)

    def __str__(self) -> str:
        return f"a page that looks at {self.looks_at} and says: {self.page.text()}"

    def close(self) -> None:
        self._opened.close()


@pytest.fixture
def watched(stack: Stack, tmp_path: Path) -> Iterator[Watched]:
    groups = LOCALIZATION_GROUP, NAVIGATION_GROUP
    robot = stack(*groups, parameters=ROOM, transport="dds")  # the viewer has nodes of its own
    with closing(Watched(robot, tmp_path / "profile")) as made:
        made.until(lambda: made.side.frames.fixed and made.viewer._map is not None)
        made.until_it_says("2D goal")
        made.until(made.looks_at_map, ticks=0)
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
    watched.until(lambda: navigation.state.state == "driving")
    watched.until_it_says("m to go")
    watched.until(lambda: navigation.state.state == "arrived", ticks=25)
    watched.until_it_says("arrived")
    kept(page, "view.png", tmp_path)
    facing = watched.robot.sim.simulator.robot.truth().pose.theta
    assert abs(facing) < 0.3  # as it was dragged: to the right


def test_a_pose_estimate_localizes_a_kidnapped_robot(watched: Watched, tmp_path: Path) -> None:
    page, robot = watched.page, watched.robot
    clicked: list[PointStamped] = []
    robot.client.create_subscription(PointStamped, "clicked_point", clicked.append, 10)
    watched.press("publish point", "Click on the ground")
    page.drag(SPOT, SPOT)
    watched.until(lambda: clicked)
    spot = SE2(clicked[-1].point.x, clicked[-1].point.y, 0.0)
    request = SetEntityState.Request(entity="arjuna", set_pose=True)
    request.state.pose = pose_msg(spot)
    assert robot.call(SetEntityState, "set_entity_state", request).result.result == Result.RESULT_OK
    assert apart(watched) > 0.5
    watched.press("2D pose estimate", "drag to where it looks")
    page.drag(SPOT, ITS_RIGHT)
    watched.until(lambda: apart(watched) < 0.1)
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
    watched.until(lambda: navigation.state.state == "driving")
    watched.until(lambda: abs(watched.robot.sim.simulator.robot.truth().v) > 0.1)
    page.press("Stop")
    watched.until(lambda: navigation.state.state == "cancelled")
    watched.until_it_says("cancelled")
    watched.robot.run(1.0)
    assert abs(watched.robot.sim.simulator.robot.truth().v) < 0.01
    kept(page, "stop.png", tmp_path)
