"""Claims: the viewer hears what is shown and nothing else, and says what a person asks for."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import closing
from functools import partial
from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser", reason="no viewer here")

from geometry_msgs.msg import (
    PointStamped,
    PoseStamped,
    PoseWithCovarianceStamped,
    Twist,
    TwistStamped,
)
from nav2_msgs.srv import ClearEntireCostmap, ManageLifecycleNodes
from nav_msgs.msg import Path
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import QoSProfile
from sensor_msgs.msg import CompressedImage, LaserScan
from slam_toolbox.srv import SaveMap, SerializePoseGraph
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_msg, header, path_msg, transform_msg
from arjuna_core.se2 import SE2
from bringup.viewing.displays.base import DisplaySpec
from bringup.viewing.robot.managed import ManagedNodes
from bringup.viewing.robot.robot_side import RobotSide
from tests.helpers.processes import wait_until
from tests.helpers.ros import RosBench

MAP, SCAN = DisplaySpec("Map", "map"), DisplaySpec("LaserScan", "scan", anywhere=True)
CAMERA = DisplaySpec("Image", "camera")


class Bench:
    """A viewer's ROS side beside a node that plays the robot."""

    def __init__(self, **options: Any) -> None:
        self.ros = RosBench(transport="dds")
        self.viewer = RobotSide(self.ros.process.context, **options)

    def listen(self, *specs: DisplaySpec) -> None:
        """Listen to displays, each by its name."""
        self.viewer.listen({spec.name: spec.make() for spec in specs})

    def until(self, done: Callable[[], Any]) -> None:
        wait_until(done, self._step, "the viewer")

    def _step(self) -> None:
        self.ros.process.drain()
        self.viewer.spin(time.monotonic() + 0.02)
        self.viewer.tick(time.monotonic())

    def heard(self, key: str, publish: Callable[[], None]) -> Any:
        """Return the newest message of a display."""
        found: dict[str, Any] = {}

        def done() -> bool:
            publish()
            found.update(self.viewer.feed.take())
            return key in found

        self.until(done)
        return found[key]

    def close(self) -> None:
        self.viewer.close()
        self.ros.close()


@pytest.fixture
def bench() -> Iterator[Bench]:
    with closing(Bench()) as made:
        yield made


def scan_at(stamp: float) -> LaserScan:
    return LaserScan(
        header=header("lidar", stamp), angle_increment=0.1, range_max=9.0, ranges=[1.0, 2.0]
    )


def test_a_map_that_was_published_before_is_drawn(bench: Bench) -> None:
    grid = OccupancyGrid(GridFrame(0.5, 4, 2, SE2(-1.0, -2.0, 0.0)), np.zeros((2, 4), np.int8))
    bench.ros.publish(
        type(grid_msg(grid, "map", 0.0)), "/map", grid_msg(grid, "map", 0.0), qos.LATCHED
    )
    bench.listen(MAP)
    message = bench.heard("map", lambda: None)
    assert (message.info.width, message.header.frame_id) == (4, "map")


def test_a_scan_by_another_name_is_found(bench: Bench) -> None:
    bench.ros.publish(LaserScan, "/front/laser", scan_at(1.0))
    bench.until(lambda: bench.viewer.node.count_publishers("/front/laser"))
    bench.listen(SCAN)
    publish = lambda: bench.ros.publish(LaserScan, "/front/laser", scan_at(2.0))  # noqa: E731
    assert len(bench.heard("scan", publish).ranges) == 2


def test_a_display_listens_to_its_own_topic_and_no_other(bench: Bench) -> None:
    bench.listen(DisplaySpec("Path", "plan", "my_plan"))
    message = path_msg(np.zeros((2, 3)), "map", 0.0)
    plan = bench.heard("plan", lambda: bench.ros.publish(Path, "/my_plan", message))
    assert len(plan.poses) == 2
    assert bench.ros.node.count_subscribers("/plan") == 0


def test_no_message_is_missed_where_each_changes_the_picture(bench: Bench) -> None:
    bench.listen(DisplaySpec("Marker", "markers", "marks"))
    publish = lambda: bench.ros.publish(Marker, "/marks", Marker(id=9), QoSProfile(depth=10))  # noqa: E731
    assert bench.heard("markers", publish).id == 9
    for number in range(5):
        bench.ros.publish(Marker, "/marks", Marker(id=number), QoSProfile(depth=10))
    numbers: list[int] = []

    def done() -> bool:
        numbers.extend(message.id for _, message in bench.viewer.feed.take() if message.id < 9)
        return len(numbers) == 5

    bench.until(done)
    assert numbers == [0, 1, 2, 3, 4]


def test_a_compressed_image_is_received_by_its_topic_s_type(bench: Bench) -> None:
    image = CompressedImage(format="jpeg")
    bench.ros.publish(CompressedImage, "/eye", image)
    bench.until(lambda: bench.viewer.node.count_publishers("/eye"))
    bench.listen(DisplaySpec("Image", "camera", "eye"))
    publish = lambda: bench.ros.publish(CompressedImage, "/eye", image)  # noqa: E731
    assert bench.heard("camera", publish).format == "jpeg"


def test_a_goal_is_published_too_where_another_node_listens(bench: Bench) -> None:
    got = bench.ros.collect(PoseStamped, "/goal_pose")
    bench.until(lambda: bench.viewer.node.count_subscribers("/goal_pose"))
    bench.viewer.send_goal(SE2(1.0, 2.0, 0.0))
    bench.until(lambda: got)
    assert (got[0].header.frame_id, got[0].pose.position.y) == ("map", 2.0)
    assert "on /goal_pose" in bench.viewer.navigation.state.state


def test_tools_publish_on_the_topics_of_a_file(bench: Bench) -> None:
    side, node = bench.viewer, bench.viewer.node
    goals = bench.ros.collect(PoseStamped, "/tb1/goal_pose")
    points = bench.ros.collect(PointStamped, "/marks")
    topics = {"SetGoal": "/tb1/goal_pose", "PublishPoint": "marks", "SetInitialPose": "/my pose"}
    side.command_on(topics)
    bench.until(
        lambda: node.count_subscribers("/tb1/goal_pose") and node.count_subscribers("marks")
    )
    side.send_goal(SE2(1.0, 2.0, 0.0))
    side.publish_point(SE2(3.0, 0.0))
    bench.until(lambda: goals and points)
    assert (goals[0].pose.position.x, points[0].point.x) == (1.0, 3.0)
    assert "on /tb1/goal_pose" in side.navigation.state.state
    assert {out.topic_name for out in side._outs.values()} == {
        "/initialpose",  # the other is no name
        "/tb1/goal_pose",
        "/marks",
    }
    side.command_on({"SetGoal": "/goal_pose"})
    assert {out.topic_name for out in side._outs.values()} == {
        *("/initialpose", "/goal_pose", "/clicked_point"),
    }


def test_a_topic_that_none_can_be_called_is_left_out(bench: Bench) -> None:
    path = DisplaySpec("Path", "plan", "/plan")
    for topic in ("/my scan", "/a//b", "scan/"):
        bench.listen(DisplaySpec("LaserScan", "scan", topic), path)
        assert bench.viewer.node.resolve_topic_name("plan") in {
            source.topic for source, _ in bench.viewer.feed._open.values()
        }
        assert len(bench.viewer.feed._open) == 1


def test_nothing_is_subscribed_to_unless_it_is_shown(bench: Bench) -> None:
    count = bench.ros.node.count_subscribers
    base = count("/tf")
    bench.listen(SCAN, CAMERA)
    bench.until(lambda: count("/scan") and count("/camera/image_raw") and count("/tf") > base)
    assert not count("/map")
    bench.listen(SCAN)
    bench.until(lambda: not count("/camera/image_raw"))
    bench.viewer.listen(None)
    assert not any(count(topic) for topic in ("/scan", "/navigate_to_pose/_action/feedback"))
    assert count("/tf") == base


def test_transforms_build_the_tree_of_frames(bench: Bench) -> None:
    bench.listen()
    moving = TFMessage(transforms=[transform_msg(SE2(1.0, 2.0, 0.0), "map", "base", 1.0)])

    def known() -> bool:
        bench.ros.publish(TFMessage, "/tf", moving)
        return bench.viewer.frames.pose("base") is not None

    bench.until(known)
    pose = bench.viewer.frames.pose("base")
    assert pose is not None
    assert pose.position == (1.0, 2.0, 0.0)


def test_a_pose_estimate_says_how_sure_a_person_is(bench: Bench) -> None:
    got = bench.ros.collect(PoseWithCovarianceStamped, "/initialpose")
    bench.until(lambda: bench.viewer.node.count_subscribers("/initialpose"))
    bench.viewer.estimate(SE2(1.0, 2.0, 3.0))
    bench.until(lambda: got)
    assert got[0].header.frame_id == "map"
    assert (got[0].pose.pose.position.x, got[0].pose.covariance[0]) == (1.0, 0.25)


def test_a_point_is_published(bench: Bench) -> None:
    got = bench.ros.collect(PointStamped, "/clicked_point")
    bench.until(lambda: bench.viewer.node.count_subscribers("/clicked_point"))
    bench.viewer.publish_point(SE2(1.0, -2.0))
    bench.until(lambda: got)
    assert (got[0].point.x, got[0].point.y) == (1.0, -2.0)


def test_driving_ends_when_the_button_is_released(bench: Bench) -> None:
    got = bench.ros.collect(Twist, "/cmd_vel")
    bench.until(lambda: bench.viewer.node.count_subscribers("/cmd_vel"))
    bench.viewer.drive(0.3, 0.1)
    bench.until(lambda: len(got) > 3 and got[-1].linear.x == 0.0)
    assert (got[0].linear.x, got[0].angular.z) == (0.3, 0.1)
    bench.until(lambda: len([twist for twist in got if twist.linear.x == 0.0]) == 5)


def test_the_last_viewer_leaving_stops_the_robot(bench: Bench) -> None:
    got = bench.ros.collect(Twist, "/cmd_vel")
    bench.listen()
    bench.until(lambda: bench.viewer.node.count_subscribers("/cmd_vel"))
    bench.viewer._hand.drive(0.3, 0.0, time.monotonic() + 60.0)  # not released in this test
    bench.until(lambda: got)
    bench.viewer.listen(None)
    bench.until(lambda: got[-1].linear.x == 0.0)


def test_a_robot_that_takes_stamped_velocities_gets_them(bench: Bench) -> None:
    got = bench.ros.collect(TwistStamped, "/cmd_vel")
    bench.until(lambda: bench.viewer.node.count_subscribers("/cmd_vel"))
    bench.viewer.drive(0.2, 0.0)
    bench.until(lambda: got)
    assert got[0].twist.linear.x == 0.2


def test_a_goal_without_a_navigator_says_what_to_start(bench: Bench) -> None:
    bench.viewer.send_goal(SE2())
    assert "python -m bringup nav" in bench.viewer.navigation.state.error


def test_costmaps_and_managers_are_found_by_their_types(bench: Bench) -> None:
    asked: list[Any] = []

    def answer(request: Any, response: Any) -> Any:
        asked.append(request)
        if isinstance(request, ManageLifecycleNodes.Request):
            response.success = request.command == request.PAUSE
        return response

    node, managed = bench.ros.node, bench.viewer.managed
    node.create_service(ManageLifecycleNodes, "/lifecycle_manager_x/manage_nodes", answer)
    node.create_service(ClearEntireCostmap, "/local_costmap/clear_entirely", answer)
    bench.until(lambda: len(bench.viewer.node.get_service_names_and_types()) > 1)
    managed.command("pause")
    bench.until(lambda: managed.report == "pause done")
    managed.command("reset")
    bench.until(lambda: managed.report == "reset failed: lifecycle_manager_x")
    managed.clear_costmaps()
    bench.until(lambda: len(asked) == 3)
    assert managed.report == "costmaps cleared"


def _ends(managed: ManagedNodes, report: str) -> bool:
    return managed.report.endswith(report)


def test_maps_are_saved_by_slam_toolbox(bench: Bench) -> None:
    managed, node = bench.viewer.managed, bench.ros.node
    managed.save_map("map", "house")
    assert managed.report == "no slam_toolbox is running"

    def save(request: Any, response: Any) -> Any:
        response.result = 0 if request.name.data == "house" else 1
        return response

    def serialize(request: Any, response: Any) -> Any:
        response.result = 255 if request.filename == "house" else 0
        return response

    node.create_service(SaveMap, "/slam_toolbox/save_map", save)
    node.create_service(SerializePoseGraph, "/slam_toolbox/serialize_map", serialize)
    bench.until(lambda: len(bench.viewer.node.get_service_names_and_types()) > 1)
    for kind, report in (("map", "is saved"), ("graph", "is not saved: result 255")):
        managed.save_map(kind, "house")
        assert managed.report == f"saving the {kind} …"
        bench.until(partial(_ends, managed, report))


def test_the_state_of_managed_nodes_is_asked_for_one_by_one(bench: Bench) -> None:
    node = LifecycleNode("managed", context=bench.ros.process.context)
    bench.ros.process.executor.add_node(node)
    bench.until(lambda: bench.viewer.managed.states.get("managed") == "unconfigured")
    node.trigger_configure()
    bench.until(lambda: bench.viewer.managed.states.get("managed") == "inactive")
    node.destroy_node()
