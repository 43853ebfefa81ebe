"""Claims: what is shown becomes scene nodes, and the panel's buttons command the robot."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser", reason="no viewer here")

from geometry_msgs.msg import PolygonStamped, PoseStamped, PoseWithCovarianceStamped, Twist
from nav2_msgs.msg import Particle, ParticleCloud
from nav_msgs.msg import OccupancyGrid as GridMsg
from nav_msgs.msg import Path
from sensor_msgs.msg import Image, LaserScan
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_msg, header, path_msg, pose_msg, transform_msg
from arjuna_core.se2 import SE2
from bringup.viewing.browser.panel import Tool
from bringup.viewing.browser.server import open_server
from bringup.viewing.browser.viewer import Viewer
from bringup.viewing.drawing.values import LAYERS
from bringup.viewing.robot.robot_side import RobotOptions, RobotSide
from tests.bringup.viewing.drives import URDF
from tests.helpers.processes import wait_until
from tests.helpers.ros import RosBench

GRID = grid_msg(OccupancyGrid(GridFrame(0.5, 4, 2), np.zeros((2, 4), np.int8)), "map", 0.0)


class Shown:
    """A viewer of every layer, with a browser that only counts, beside a played robot."""

    def __init__(self, opened: ExitStack) -> None:
        self.ros = opened.enter_context(closing(RosBench(transport="dds")))
        side = opened.enter_context(closing(RobotSide(RobotOptions(), self.ros.process.context)))
        server = open_server("127.0.0.1", 0)
        opened.callback(server.stop)
        self.viewer = Viewer(server, side, lambda uri: None, list(LAYERS))
        self.viewer._count_viewers(1)
        self.handles = server.scene._handle_from_node_name

    def until(self, done: Callable[[], Any], publish: Callable[[], None] = lambda: None) -> None:
        def step() -> None:
            publish()
            self.ros.process.drain()
            self.viewer.step(0.01)

        wait_until(done, step, "the viewer")


@pytest.fixture
def shown() -> Iterator[Shown]:
    with ExitStack() as opened:
        yield Shown(opened)


def publish_everything(ros: RosBench) -> None:
    """Publish a message of each topic that is drawn, and their frames."""
    moving = [transform_msg(SE2(1.0, 0.0, 0.0), "map", "base_link", 1.0)]
    ros.publish(TFMessage, "/tf", TFMessage(transforms=moving))
    ros.publish(String, "/robot_description", String(data=URDF), qos.LATCHED)
    for topic in ("/map", "/global_costmap/costmap", "/local_costmap/costmap"):
        ros.publish(GridMsg, topic, GRID, qos.LATCHED)
    scan = LaserScan(header=header("base_link", 1.0), range_max=9.0, ranges=[1.0])
    ros.publish(LaserScan, "/scan", scan, qos.SENSOR_PUBLISHER)
    footprint = PolygonStamped(header=header("map", 1.0))
    ros.publish(PolygonStamped, "/local_costmap/published_footprint", footprint, qos.DEFAULT)
    cloud = ParticleCloud(header=header("map", 1.0), particles=[Particle(weight=1.0)] * 200)
    ros.publish(ParticleCloud, "/particle_cloud", cloud, qos.SENSOR_PUBLISHER)
    belief = PoseWithCovarianceStamped(header=header("map", 1.0))
    ros.publish(PoseWithCovarianceStamped, "/amcl_pose", belief, qos.LATCHED)
    for topic in ("/plan", "/local_plan"):
        ros.publish(Path, topic, path_msg(np.zeros((2, 3)), "map", 1.0), qos.DEFAULT)
    goal = PoseStamped(header=header("map", 1.0), pose=pose_msg(SE2()))
    ros.publish(PoseStamped, "/goal_pose", goal, qos.DEFAULT)
    image = Image(encoding="rgb8", height=1, width=1, step=3, data=b"abc")
    ros.publish(Image, "/camera/image_raw", image, qos.SENSOR_PUBLISHER)


def test_each_topic_is_drawn_in_its_layer(shown: Shown) -> None:
    expected = {
        *("map/map1", "global_costmap/global_costmap", "local_costmap/local_costmap"),
        *("local_costmap/footprint", "scan/scan", "particles/particles", "particles/belief"),
        *("global_path/plan", "local_path/local_plan", "goals/goal"),
    }
    nodes = {f"/layers/{name}" for name in expected} | {"/tf/map/base_link/visual"}

    def drawn() -> bool:
        visible = {name for name, handle in shown.handles.items() if handle.visible}
        return nodes <= visible and shown.viewer._panel._camera.image.shape[:2] == (1, 1)

    shown.until(drawn, lambda: publish_everything(shown.ros))
    overlay = shown.handles["/layers/local_costmap/local_costmap"]
    assert tuple(overlay.position) == pytest.approx((1.0, 0.5, 0.02))  # its middle


def test_a_goal_is_sent_and_marked_and_the_tool_laid_down(shown: Shown) -> None:
    shown.until(lambda: shown.viewer._robot.frames.fixed, lambda: publish_everything(shown.ros))
    shown.viewer._take(Tool.GOAL)
    assert "press where the robot shall go" in shown.viewer._panel._hint.content.lower()
    shown.viewer._point((1.0, 1.0), (1.0, 2.0))
    assert "no navigator is running" in shown.viewer._robot.navigation.state.error
    assert shown.viewer._tool is Tool.LOOK
    assert "/layers/goals/goal" in shown.handles


def test_what_the_panel_calls_is_done_by_the_next_step(shown: Shown) -> None:
    twists = shown.ros.collect(Twist, "/cmd_vel")
    panel, robot = shown.viewer._panel, shown.viewer._robot
    shown.until(lambda: robot.node.count_subscribers("/cmd_vel"))
    drive = panel._call(robot.drive, lambda: 0.25, lambda: -0.5)
    shown.until(lambda: twists, lambda: asyncio.run(drive(None)))
    assert (twists[0].linear.x, twists[0].angular.z) == (0.25, -0.5)
    asyncio.run(panel._call(shown.viewer._toggle, lambda: "scan", lambda: False)(None))
    shown.viewer.step(0.01)
    assert not shown.handles["/layers/scan"].visible
