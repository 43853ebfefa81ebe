"""Each kind of source alone: what only it sees stops the robot; silent, it holds it."""

from __future__ import annotations

import array
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from geometry_msgs.msg import (
    Point32,
    Polygon,
    PolygonInstance,
    PolygonInstanceStamped,
    PolygonStamped,
)
from nav2_msgs.msg import CollisionDetectorState
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from sensor_msgs.msg import LaserScan, PointCloud2, PointField, Range
from std_msgs.msg import Float32
from visualization_msgs.msg import Marker, MarkerArray

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from arjuna_nav.nodes.safety.detector import CollisionDetectorNode
from bringup.parameters.files import shipped_parameters
from bringup.stack import COLLISION_MONITOR, LOCAL_COSTMAP
from tests.helpers.nav.navigation import PlayedRobot
from tests.nodes.nav.test_collision_monitor import drive

pytestmark = pytest.mark.ros
KINDS = {"scan": LaserScan, "pointcloud": PointCloud2, "range": Range,
         "polygon": PolygonInstanceStamped}  # fmt: skip
BODY, RADIUS, ZONE = 0.25, 0.1, 0.55  # of the robot, the obstacle and the zone [m]
SCENES = 20
STOP = {"type": "circle", "action_type": "stop", "radius": ZONE, "min_points": 1}
FOV = 1.2  # of the range sensor [rad]


def cloud(points: list[tuple[float, float, float]], stamp: float) -> PointCloud2:
    """Return a cloud of points in the lidar's frame."""
    names = enumerate("xyz")
    fields = [PointField(name=n, offset=4 * k, datatype=7, count=1) for k, n in names]
    data = np.array(points, dtype=np.float32).reshape(-1, 3)
    return PointCloud2(header=header("lidar_link", stamp), height=1, width=len(data),
        fields=fields, point_step=12, row_step=12 * len(data), is_dense=True,
        data=array.array("B", data.tobytes()))  # fmt: skip


def message(kind: str, at: tuple[float, float] | None, stamp: float) -> Any:
    """Return what a source says of a round obstacle, seen from the robot; None for none."""
    distance = math.inf if at is None else math.hypot(*at) - RADIUS
    bearing = 0.0 if at is None else math.atan2(at[1], at[0])
    if kind == "scan":
        angles = np.arange(-180, 180) * math.pi / 180.0
        width = math.asin(min(RADIUS / max(distance + RADIUS, RADIUS), 1.0))
        ranges = np.where(np.abs(angles - bearing) <= max(width, 0.02), distance, np.inf)
        return LaserScan(header=header("lidar_link", stamp), angle_min=-math.pi,
            angle_max=math.pi, angle_increment=math.pi / 180.0, range_min=0.05, range_max=12.0,
            ranges=array.array("f", ranges.astype(np.float32).tobytes()))  # fmt: skip
    if kind == "pointcloud":
        above = [(0.35, 0.0, 0.9), (0.35, 0.1, 0.01)]  # a table's top and the floor
        seen = (
            []
            if at is None
            else [(distance * math.cos(bearing), distance * math.sin(bearing), 0.3)]
        )
        return cloud(above + seen, stamp)
    if kind == "range":
        return Range(header=header("lidar_link", stamp), field_of_view=FOV, min_range=0.02,
            max_range=4.0, range=float(distance))  # fmt: skip
    turns = np.arange(8) * math.pi / 4.0
    middle = (9.0, 9.0) if at is None else at
    corners = [Point32(x=middle[0] + RADIUS * math.cos(t), y=middle[1] + RADIUS * math.sin(t))
               for t in turns]  # fmt: skip
    instance = PolygonInstance(id=3, polygon=Polygon(points=corners))
    return PolygonInstanceStamped(header=header("lidar_link", stamp), polygon=instance)


class Scene:
    """A robot that sees by one source alone."""

    def __init__(self, kind: str, **values: Any) -> None:
        own = {"type": kind, "topic": "/it"}
        monitor = {"observation_sources": ["it"], "it": own, "polygons": ["Stop"], "Stop": STOP,
                   "source_timeout": 0.5}  # fmt: skip
        self.kind = kind
        ours = {**shipped_parameters(), "collision_monitor": {**monitor, **values}}
        self.robot = PlayedRobot(ours, shipped=False)
        self.robot.bring_up(LOCAL_COSTMAP, COLLISION_MONITOR)
        self.obstacle: tuple[float, float] | None = None

    def say(self) -> None:
        """Publish what the source sees from where the robot is."""
        robot = self.robot
        at = None
        if self.obstacle is not None:
            x, y = robot.pose.inverse().apply(np.array([self.obstacle]))[0]
            at = float(x), float(y)
        robot.bench.publish(KINDS[self.kind], "/it", message(self.kind, at, robot.now), qos.DEFAULT)

    def drive(self, v: float, duration: float) -> None:
        for _ in range(round(duration / 0.1)):
            self.say()
            drive(self.robot, v, 0.1)


@pytest.fixture(params=KINDS)
def scene(request: pytest.FixtureRequest) -> Iterator[Scene]:
    scene = Scene(request.param)
    yield scene
    scene.robot.close()


def test_what_it_alone_sees_stops_the_robot(scene: Scene) -> None:
    robot = scene.robot
    for seed in range(SCENES):
        rng = np.random.default_rng(seed)
        robot.pose = SE2.from_array(rng.uniform(-3.0, 3.0, 3))
        scene.obstacle = None
        scene.drive(0.3, 0.4)
        assert robot.command.x == pytest.approx(0.3), "it stands before nothing"
        bearing, distance = rng.uniform(-0.3, 0.3), rng.uniform(0.8, 1.4)
        at = robot.pose @ SE2(distance * math.cos(bearing), distance * math.sin(bearing))
        scene.obstacle = at.x, at.y
        scene.drive(0.3, 5.0)
        assert robot.command == STILL, f"scene {seed}"
        gap = math.hypot(robot.pose.x - at.x, robot.pose.y - at.y) - RADIUS - BODY
        assert 0.0 < gap < 0.5, f"scene {seed}"


def test_silent_it_holds_the_robot_until_it_speaks(scene: Scene) -> None:
    drive(scene.robot, 0.2, 0.2)
    assert scene.robot.command == STILL, "it has said nothing yet"
    scene.drive(0.2, 0.3)
    assert scene.robot.command.x == pytest.approx(0.2)
    drive(scene.robot, 0.2, 0.4)
    assert scene.robot.command.x == pytest.approx(0.2)
    drive(scene.robot, 0.2, 0.3)
    assert scene.robot.command == STILL
    assert "/it" in scene.robot.nodes["collision_monitor"].trouble()


@pytest.mark.parametrize("values", [{"source_timeout": 0.0}, {"it.source_timeout": 0.0},
                                    {"it.enabled": False}])  # fmt: skip
def test_of_any_age_or_switched_off_it_holds_nobody(values: dict[str, Any]) -> None:
    scene = Scene("scan", **values)
    drive(scene.robot, 0.2, 1.0)
    assert scene.robot.command.x == pytest.approx(0.2)
    scene.robot.close()


def test_all_of_several_sources_count() -> None:
    both = {"observation_sources": ["it", "low"], "low": {"type": "pointcloud", "topic": "/low"}}
    scene = Scene("scan", **both)
    scene.drive(0.2, 0.3)
    assert scene.robot.command == STILL, "one of them is silent"
    shown = scene.robot.bench.collect(MarkerArray, "/collision_monitor/collision_points_marker")
    for points, v in (([(2.0, 0.0, 0.2)], 0.2), ([(0.4, 0.0, 0.2)], 0.0), ([(0.4, 0.0, 0.6)], 0.2)):
        scene.robot.bench.publish(PointCloud2, "/low", cloud(points, scene.robot.now), qos.DEFAULT)
        scene.drive(0.2, 0.2)
        assert scene.robot.command.x == pytest.approx(v)
        high, low = shown[-1].markers
        assert (high.ns, low.ns) == ("collision_points_it", "collision_points_low")
        assert (low.header.frame_id, low.type) == ("base_link", Marker.POINTS)
        near = [] if points[0][2] > 0.5 else [pytest.approx(points[0][:2], abs=0.05)]
        assert [(p.x, p.y) for p in low.points] == near
        assert not high.points
    scene.robot.close()


@pytest.mark.parametrize(("correction", "stops"), [(True, True), (False, False)])
def test_what_was_seen_is_moved_with_the_robot_if_that_is_asked(
    correction: bool, stops: bool
) -> None:
    scene = Scene("scan", base_shift_correction=correction, source_timeout=5.0)
    scene.obstacle = (0.8, 0.0)
    scene.drive(0.01, 0.2)
    assert scene.robot.command.x == pytest.approx(0.01)
    drive(scene.robot, 0.3, 1.0)  # it is not seen again, and 0.3 m nearer in the end
    assert (scene.robot.command == STILL) is stops
    scene.robot.close()


@pytest.mark.parametrize("parameter", ["Stop.enabled", "it.enabled"])
def test_zones_and_sources_are_switched_while_it_runs(parameter: str) -> None:
    scene = Scene("scan")
    scene.obstacle = (0.5, 0.0)
    for on, v in ((True, 0.0), (False, 0.1), (True, 0.0)):
        switch = Parameter(parameter, value=on).to_parameter_msg()
        request = SetParameters.Request(parameters=[switch])
        name = "/collision_monitor/set_parameters"
        assert scene.robot.bench.call(SetParameters, name, request).results[0].successful
        scene.say()
        drive(scene.robot, 0.1, 0.04)
        assert scene.robot.command.x == pytest.approx(v)
    scene.robot.close()


def test_a_transform_that_is_too_old_blinds_it() -> None:
    scene = Scene("scan", transform_tolerance=0.3, source_timeout=5.0)
    scene.drive(0.1, 0.2)
    scene.robot.localized = False
    for seconds_old, v in ((0.1, 0.1), (0.5, 0.0)):
        scene.robot.run(seconds_old)
        scene.say()
        drive(scene.robot, 0.1, 0.04)
        assert scene.robot.command.x == pytest.approx(v)
    scene.robot.close()


@pytest.mark.parametrize("frame", ["base_link", "odom"])
def test_a_zones_shape_may_come_by_a_topic(frame: str) -> None:
    zone = {
        "type": "polygon",
        "action_type": "stop",
        "min_points": 1,
        "polygon_sub_topic": "/shape",
    }
    scene = Scene("scan", Stop=zone)
    robot = scene.robot
    scene.obstacle = (0.7, 0.0)
    scene.drive(0.01, 0.2)
    assert robot.command.x == pytest.approx(0.01), "no shape has come"
    corners = [Point32(x=x, y=y) for x, y in ((1.0, 1.0), (1.0, -1.0), (-0.3, -1.0), (-0.3, 1.0))]
    shape = PolygonStamped(header=header(frame, robot.now), polygon=Polygon(points=corners))
    robot.bench.publish(PolygonStamped, "/shape", shape, qos.DEFAULT)
    scene.drive(0.01, 0.2)
    assert robot.command == STILL
    robot.close()


def test_a_circles_radius_may_come_by_a_topic_and_outlines_are_shown() -> None:
    zone = {"type": "circle", "action_type": "stop", "min_points": 1, "polygon_sub_topic": "/r",
            "visualize": True, "polygon_pub_topic": "/shown"}  # fmt: skip
    scene = Scene("scan", Stop=zone)
    shown = scene.robot.bench.collect(PolygonStamped, "/shown")
    scene.obstacle = (0.7, 0.0)
    for radius, v in ((0.5, 0.01), (0.8, 0.0)):
        scene.robot.bench.publish(Float32, "/r", Float32(data=radius), qos.DEFAULT)
        scene.drive(0.01, 0.2)
        assert scene.robot.command.x == pytest.approx(v)
        assert shown[-1].header.frame_id == "base_link"
        assert max(p.x for p in shown[-1].polygon.points) == pytest.approx(radius)
    scene.robot.close()


def test_the_published_footprint_is_what_approaches() -> None:
    zone = {"type": "polygon", "action_type": "approach", "min_points": 1}
    scene = Scene("scan", Stop=zone)
    scene.robot.pose = SE2(1.0, -1.0, 2.0)
    scene.obstacle = None
    scene.drive(0.2, 1.0)
    ahead = scene.robot.pose @ SE2(0.28 + RADIUS + 0.1, 0.0)
    scene.obstacle = ahead.x, ahead.y
    scene.say()
    drive(scene.robot, 0.2, 0.04)
    # the outline of 0.25 m and its padding of 0.03 m: 0.1 m at 0.02 m a step
    assert 0.2 * 0.35 / 2.0 <= scene.robot.command.x <= 0.2 * 0.55 / 2.0
    scene.robot.close()


def test_the_detector_says_in_which_zones_something_is() -> None:
    scene = Scene("scan")
    robot = scene.robot
    circle = {"type": "circle", "action_type": "none", "min_points": 1}
    values = {"observation_sources": ["it"], "it": {"topic": "/it"}, "polygons": ["near", "far"],
              "near": {**circle, "radius": 0.4}, "far": {**circle, "radius": 1.0}}  # fmt: skip
    node = CollisionDetectorNode(robot.bench.process, values)
    node.trigger_configure()
    node.trigger_activate()
    states = robot.bench.collect(CollisionDetectorState, "/collision_detector_state")
    for x, expected in ((2.0, [False, False]), (0.9, [False, True]), (0.4, [True, True])):
        scene.obstacle = x, 0.0
        scene.drive(0.0, 0.4)
        assert list(states[-1].polygons) == ["near", "far"]
        assert list(states[-1].detections) == expected
    robot.close()
