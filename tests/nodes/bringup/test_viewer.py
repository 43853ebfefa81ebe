"""Claims: what is shown becomes scene nodes, and the panel's buttons command the robot."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser", reason="no viewer here")

from arjuna_interfaces.msg import LocalizationQuality
from geometry_msgs.msg import (
    PointStamped,
    PolygonStamped,
    PoseStamped,
    PoseWithCovarianceStamped,
    Twist,
)
from nav2_msgs.action import FollowWaypoints
from nav2_msgs.msg import BehaviorTreeLog, BehaviorTreeStatusChange, Particle, ParticleCloud
from nav_msgs.msg import OccupancyGrid as GridMsg
from nav_msgs.msg import Odometry, Path
from sensor_msgs.msg import Image, JointState, LaserScan
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_msg, header, path_msg, pose_msg, transform_msg
from arjuna_core.se2 import SE2
from bringup.viewing.browser.panel import ROUTES, Tool
from bringup.viewing.browser.server import open_server
from bringup.viewing.browser.viewer import Viewer
from bringup.viewing.displays.base import DisplaySpec
from bringup.viewing.displays.standard import STANDARD
from bringup.viewing.robot.joints import TOPIC
from bringup.viewing.robot.robot_side import RobotSide
from bringup.viewing.rviz_file import write_rviz
from tests.bringup.viewing.drives import URDF
from tests.bringup.viewing.test_rviz_file import NAV2
from tests.helpers.processes import wait_until
from tests.helpers.ros import RosBench

GRID = grid_msg(OccupancyGrid(GridFrame(0.5, 4, 2), np.zeros((2, 4), np.int8)), "map", 0.0)


class Shown:
    """A viewer of every layer, with a browser that only counts, beside a played robot."""

    def __init__(self, opened: ExitStack) -> None:
        self.ros = opened.enter_context(closing(RosBench(transport="dds")))
        side = opened.enter_context(closing(RobotSide(self.ros.process.context)))
        server = open_server("127.0.0.1", 0)
        opened.callback(server.stop)
        self.viewer = Viewer(server, side, [replace(spec, shown=True) for spec in STANDARD])
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
    odometry = Odometry(header=header("odom", 1.0))
    ros.publish(Odometry, "/odom", odometry, qos.DEFAULT)
    quality = LocalizationQuality(header=header("map", 1.0), quality=0.5)
    ros.publish(LocalizationQuality, "/amcl/localization_quality", quality, qos.LATCHED)
    change = BehaviorTreeStatusChange(node_name="FollowPath", current_status="RUNNING")
    log = BehaviorTreeLog(event_log=[change])
    ros.publish(BehaviorTreeLog, "/behavior_tree_log", log, qos.DEFAULT)
    for topic in ("/plan", "/local_plan"):
        ros.publish(Path, topic, path_msg(np.zeros((2, 3)), "map", 1.0), qos.DEFAULT)
    goal = PoseStamped(header=header("map", 1.0), pose=pose_msg(SE2()))
    ros.publish(PoseStamped, "/goal_pose", goal, qos.DEFAULT)
    image = Image(encoding="rgb8", height=1, width=1, step=3, data=b"abc")
    ros.publish(Image, "/camera/image_raw", image, qos.SENSOR_PUBLISHER)


def test_each_topic_is_drawn_by_its_display(shown: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = (
        *("robot_1/base_link", "map_2/|1", "laser_scan_3/|", "global_costmap_4/|"),
        *("local_costmap_5/|", "footprint_6/|", "particles_7/|", "amcl's_pose_8/|"),
        *("global_path_10/|", "local_path_11/|", "goal_14/|", "tf_16/axes"),
    )
    nodes = {f"/world/{name}" for name in expected}

    panel, names = shown.viewer._panel, list[str]()
    monkeypatch.setattr(shown.viewer._server.gui, "set_panel_label", names.append)

    def drawn() -> bool:
        visible = {name for name, handle in shown.handles.items() if handle.visible}
        beside = {key.rpartition("_")[0] for key in panel._shown_beside}
        return nodes <= visible and beside >= {
            *("camera", "plot_of_speed", "plot_of_localization_quality", "behavior_tree"),
        }

    shown.until(drawn, lambda: publish_everything(shown.ros))
    assert names[0] == "r"  # the robot's
    tree, _ = panel._shown_beside["behavior_tree_21"]
    assert "▶ FollowPath: running" in tree.content
    overlay = shown.handles["/world/local_costmap_5/|"]
    assert tuple(overlay.position) == pytest.approx((1.0, 0.5, 0.02))  # its middle
    scan = shown.handles["/world/laser_scan_3/|"]
    assert scan.position[2] == pytest.approx(0.02)  # on the floor
    camera, _ = panel._shown_beside["camera_17"]
    assert camera.image.shape[:2] == (1, 1)


def test_a_message_that_makes_no_sense_is_said_and_leaves_the_others(shown: Shown) -> None:
    broken = grid_msg(OccupancyGrid(GridFrame(0.5, 4, 2), np.zeros((2, 4), np.int8)), "map", 0.0)
    broken.info.width = 5
    shown.ros.publish(GridMsg, "/map", broken, qos.LATCHED)
    shown.until(lambda: shown.viewer._shown["map_2"].error)
    assert "8 cells for a grid of 5 x 2" in shown.viewer._shown["map_2"].error
    shown.viewer.step(0.01)


def test_a_display_is_added_changed_and_removed(shown: Shown) -> None:
    viewer = shown.viewer
    viewer._add_new("PointStamped", "/mine")
    key = next(key for key in viewer._shown if key.startswith("pointstamped"))
    assert viewer._panel.displays.chosen == key
    viewer._change(key, "radius", 0.5)
    viewer._rename(key, "/other")
    point = PointStamped(header=header("map", 0.0))

    def publish() -> None:
        publish_everything(shown.ros)
        shown.ros.publish(PointStamped, "/other", point, qos.DEFAULT)

    shown.until(lambda: viewer._shown[key].drawn, publish)
    ball: Any = shown.handles[f"/world/{key}/|"]
    assert ball.batched_scales[0] == pytest.approx([1.0, 1.0, 1.0])
    saved = write_rviz("map", viewer.specs())
    assert "/other" in saved
    viewer._remove(key)
    assert not [name for name in shown.handles if key in name]
    viewer._load(saved.encode())
    assert viewer.specs()[-1].make().config.radius == 0.5


def test_a_file_of_nav2_is_opened_and_what_it_lacks_here_is_said(shown: Shown) -> None:
    viewer = shown.viewer
    viewer._load(NAV2.encode())
    assert len(viewer.specs()) == len(viewer._scene._groups) - 1 == 10
    assert "panel Docking (nav2_rviz_plugins/Docking)" in viewer._panel._hint.content
    # its robot model is hidden, and the view follows the robot all the same
    shown.until(lambda: viewer._base, lambda: publish_everything(shown.ros))
    assert viewer._base == "base_link"


ORBIT = """Visualization Manager: {Displays: [], Global Options: {Fixed Frame: map}, Views: {
  Current: {Class: rviz_default_plugins/Orbit, Distance: 2, Yaw: 0, Pitch: 0, Target Frame: %s}}}"""


def test_the_view_is_a_file_s_and_a_button_ends_it(shown: Shown) -> None:
    viewer, camera = shown.viewer, shown.viewer._server.initial_camera
    viewer._load(ORBIT.replace("%s", "base_link").encode())
    shown.until(
        lambda: viewer._scene.offset[0] == pytest.approx(1.0),
        lambda: publish_everything(shown.ros),
    )
    assert tuple(camera.position) == pytest.approx((2.0, 0.0, 0.0))
    assert viewer._panel.follow.value
    viewer._load(ORBIT.replace("%s", "<Fixed Frame>").encode())
    assert viewer._scene.offset == (0.0, 0.0)
    assert tuple(camera.position) == pytest.approx((2.0, 0.0, 0.0))
    assert not viewer._panel.follow.value
    viewer._look("from above", False)
    assert camera.position[2] > 2.0


@pytest.mark.parametrize(("decay", "left"), [(0.0, [2]), (5.0, [1, 2])])
def test_points_stay_as_long_as_they_shall(shown: Shown, decay: float, left: list[int]) -> None:
    viewer, scene = shown.viewer, shown.viewer._scene
    key = viewer.add(DisplaySpec("LaserScan", "s", "/s", settings={"decay_time": decay}))
    each = viewer._shown[key]
    for now, ranges in ((0.0, [1.0] * 3), (4.0, [1.0]), (6.0, [1.0] * 2)):
        message = LaserScan(header=header("base_link", now), range_max=9.0, ranges=ranges)
        viewer._show(key, each, each.display.take(message) or {}, now)
    drawn: list[Any] = [part for (one, _), (part, _) in scene._drawn.items() if one == key]
    assert sorted(len(part.points) for part in drawn) == left


def test_the_view_follows_the_robot_and_clicks_with_it(shown: Shown) -> None:
    viewer = shown.viewer
    shown.until(lambda: viewer._base, lambda: publish_everything(shown.ros))
    viewer._look("", True)
    shown.until(lambda: viewer._scene.offset[0] == pytest.approx(1.0))
    points = shown.ros.collect(PointStamped, "/clicked_point")
    shown.until(lambda: viewer._robot.node.count_subscribers("/clicked_point"))
    viewer._take(Tool.POINT)
    viewer._point((0.5, 0.0), (0.5, 0.0))
    shown.until(lambda: points)
    assert points[0].point.x == pytest.approx(1.5)
    viewer._look("", False)
    assert viewer._scene.offset == (0.0, 0.0)
    viewer._look("from above", False)
    camera: Any = viewer._server.initial_camera
    assert camera.position[:2] == pytest.approx(camera.look_at[:2], abs=0.1)
    assert camera.position[2] > 2.0


def test_a_distance_is_measured(shown: Shown) -> None:
    shown.until(lambda: shown.viewer._robot.frames.fixed, lambda: publish_everything(shown.ros))
    shown.viewer._take(Tool.MEASURE)
    shown.viewer._point((1.0, 1.0), (4.0, 5.0))
    assert "5.000 m" in shown.viewer._panel._hint.content
    label: Any = shown.handles["/world/marks/length"]
    assert label.text == "5.00 m"


def test_a_click_that_is_not_taken_says_why_at_once(shown: Shown) -> None:
    shown.viewer._take(Tool.GOAL)
    shown.viewer._point((1.0, 1.0), (1.0, 2.0))
    assert "no frame is known yet" in shown.viewer._panel._hint.content
    walls = OccupancyGrid(GridFrame(0.1, 40, 20), np.zeros((20, 40), np.int8))
    walls.data[11, 12], walls.data[:, 30:] = 100, -1
    shown.ros.publish(GridMsg, "/map", grid_msg(walls, "map", 0.0), qos.LATCHED)
    moving = TFMessage(transforms=[transform_msg(SE2(1.0, 0.0, 0.0), "map", "base_link", 1.0)])
    shown.until(
        lambda: shown.viewer._map is not None and shown.viewer._robot.frames.fixed,
        lambda: shown.ros.publish(TFMessage, "/tf", moving),
    )
    assert "in or near a wall" in shown.viewer._obstacle(SE2(1.05, 1.05))
    assert shown.viewer._obstacle(SE2(1.05, 0.35)) == ""
    assert "the map knows nothing" in shown.viewer._obstacle(SE2(3.5, 1.0))
    assert "off the map" in shown.viewer._obstacle(SE2(9.0, 0.5))


def test_a_goal_is_sent_and_marked_and_the_tool_laid_down(shown: Shown) -> None:
    shown.until(lambda: shown.viewer._robot.frames.fixed, lambda: publish_everything(shown.ros))
    shown.viewer._take(Tool.GOAL)
    assert "press where the robot shall go" in shown.viewer._panel._hint.content.lower()
    assert "● 2D goal" in shown.viewer._panel._tools.options
    shown.viewer._point((1.0, 1.0), (1.0, 2.0))
    assert "no navigator is running" in shown.viewer._robot.navigation.state.error
    assert shown.viewer._tool is Tool.LOOK
    assert "no navigator is running" in shown.viewer._panel._hint.content
    assert "/world/marks/goal" in shown.handles


def test_waypoints_are_collected_and_driven_or_removed(shown: Shown) -> None:
    viewer, panel = shown.viewer, shown.viewer._panel
    shown.until(lambda: viewer._robot.frames.fixed, lambda: publish_everything(shown.ros))
    sent: list[Any] = []
    name, kind = "follow_waypoints", FollowWaypoints.Impl.SendGoalService

    def accept(request: Any, response: Any) -> Any:
        sent.append(request.goal)
        response.accepted = True
        return response

    shown.ros.node.create_service(kind, f"/{name}/_action/send_goal", accept)
    viewer._take(Tool.WAYPOINT)
    for y in (1.0, 2.0):
        viewer._point((1.0, y), (2.0, y))
    assert viewer._tool is Tool.WAYPOINT
    assert panel._route.visible
    viewer._drive_route(ROUTES["stop at each"])
    assert "2 waypoints are sent" in panel._hint.content
    shown.until(lambda: sent)
    assert [pose.pose.position.y for pose in sent[0].poses] == [1.0, 2.0]
    assert not panel._route.visible
    viewer._take(Tool.WAYPOINT)
    viewer._point((1.0, 1.0), (2.0, 1.0))
    viewer._drive_route(ROUTES["clear"])
    assert "1 waypoints are removed" in panel._hint.content
    assert "/world/marks/route" not in shown.handles


def test_joints_have_sliders_while_a_publisher_waits_for_them(shown: Shown) -> None:
    panel = shown.viewer._panel
    heard = shown.ros.collect(JointState, f"/{TOPIC}")
    shown.until(lambda: panel._shown_joints, lambda: publish_everything(shown.ros))
    handles: Any = panel._gui._gui_input_handle_from_uuid
    (slider,) = [each for each in handles.values() if each.label == "j"]
    assert (slider.min, slider.max) == pytest.approx((-math.pi, math.pi))
    slider.value = 1.0
    shown.until(lambda: heard)
    assert list(heard[-1].name) == ["j"]
    assert list(heard[-1].position) == pytest.approx([1.0])
    panel.show_joints({})
    assert panel._joints is None


def test_what_the_panel_calls_is_done_by_the_next_step(shown: Shown) -> None:
    twists = shown.ros.collect(Twist, "/cmd_vel")
    panel, robot = shown.viewer._panel, shown.viewer._robot
    shown.until(lambda: robot.node.count_subscribers("/cmd_vel"))
    handles: Any = panel._gui._gui_input_handle_from_uuid
    inputs = {each.label: each for each in handles.values()}
    inputs["Speed [m/s]"].value = 0.25
    (drive,) = inputs["▼ back"]._impl.hold_cbs_from_freq[10.0]
    shown.until(lambda: twists, lambda: asyncio.run(drive(None)))
    assert (twists[0].linear.x, twists[0].angular.z) == (-0.25, 0.0)
    box = panel.displays._boxes["laser_scan_3"]
    box.value = False
    shown.until(lambda: not shown.handles["/world/laser_scan_3"].visible)
