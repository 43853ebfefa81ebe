"""Each kind of source alone: what only it sees stops the robot; silent, it holds it."""

from __future__ import annotations

import array
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Point32, Polygon, PolygonStamped, Twist
from nav2_msgs.msg import CollisionDetectorState, Costmap
from numpy.typing import NDArray
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from sensor_msgs.msg import LaserScan, PointCloud2, PointField
from std_msgs.msg import Float32
from visualization_msgs.msg import Marker, MarkerArray

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from arjuna_nav.nodes.safety.detector import CollisionDetectorNode
from tests.helpers.nav.monitored import KINDS, RADIUS, Monitored, cloud, costs, drive, message
from tests.helpers.nav.played import shipped_zones


@pytest.fixture(params=KINDS)
def scene(request: pytest.FixtureRequest) -> Monitored:
    return Monitored(request.param)


def test_what_it_alone_sees_stops_the_robot(scene: Monitored) -> None:
    for seed in range(3):  # `bench scenes` has more
        assert 0.0 < scene.gap_at_rest(seed) < 0.5


def test_silent_it_holds_the_robot_until_it_speaks(scene: Monitored) -> None:
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
    scene = Monitored("scan", **values)
    drive(scene.robot, 0.2, 1.0)
    assert scene.robot.command.x == pytest.approx(0.2)


def test_all_of_several_sources_count() -> None:
    both = {"observation_sources": ["it", "low"], "low": {"type": "pointcloud", "topic": "/low"}}
    scene = Monitored("scan", **both)
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


@pytest.mark.parametrize(("height", "stops"), [(0.2, True), (0.9, False), (None, True)])
def test_heights_may_come_in_a_field_of_the_cloud(height: float | None, stops: bool) -> None:
    values = {"it.use_global_height": True, "it.topic": "/own", "it.type": "pointcloud"}
    scene = Monitored("scan", **values)
    for _ in range(5):
        seen = np.array([[0.4, 0.0, 0.9, height or 0.0]], np.float32)  # its own z is too high
        message = cloud([(0.0, 0.0, 0.0)], scene.robot.now)
        if height is not None:
            field = PointField(name="height", offset=12, datatype=PointField.FLOAT32, count=1)
            message.fields = [*message.fields, field]
        message.point_step = message.row_step = 16
        message.data = array.array("B", seen.tobytes())
        scene.robot.bench.publish(PointCloud2, "/own", message, qos.DEFAULT)
        drive(scene.robot, 0.01, 0.1)
    assert (scene.robot.command == STILL) is stops, "without the field nothing is seen"


@pytest.mark.parametrize(
    ("values", "cost", "stops"),
    [({}, 252, False), ({}, 253, True), ({}, 255, True), ({"it.cost_threshold": 100}, 100, True),
     ({"it.treat_unknown_as_obstacle": False}, 255, False)],
)  # fmt: skip
def test_cells_of_a_costmap_count_by_their_cost(
    values: dict[str, Any], cost: int, stops: bool
) -> None:
    scene = Monitored("costmap", **values)
    for _ in range(3):
        seen = costs([(0.4, 0.0, cost)], scene.robot.now)
        scene.robot.bench.publish(Costmap, "/it", seen, qos.LATCHED)
        drive(scene.robot, 0.01, 0.1)
    assert (scene.robot.command == STILL) is stops


def test_the_robot_s_own_costmap_may_be_a_source() -> None:
    scene = Monitored("costmap", **{"it.topic": "local_costmap/costmap_raw"})
    drive(scene.robot, 0.2, 1.0)
    assert scene.robot.command.x == pytest.approx(0.2), "nothing changes in it, and it lives"


@pytest.mark.parametrize(("correction", "stops"), [(True, True), (False, False)])
def test_the_last_scan_is_moved_with_the_robot_where_asked(correction: bool, stops: bool) -> None:
    scene = Monitored("scan", base_shift_correction=correction, source_timeout=5.0)
    scene.obstacle = (0.8, 0.0)
    scene.drive(0.01, 0.2)
    assert scene.robot.command.x == pytest.approx(0.01)
    drive(scene.robot, 0.3, 1.0)  # it is not seen again, and 0.3 m nearer in the end
    assert (scene.robot.command == STILL) is stops


def test_who_came_while_nothing_was_commanded_is_known_to_walk() -> None:
    scene = Monitored("scan", Stop=shipped_zones()["FootprintApproach"])
    for y in np.arange(-1.2, 0.05, 0.08):
        scene.obstacle = (0.5, float(y))
        scene.say()
        scene.robot.run(0.1)
    drive(scene.robot, 0.2, 0.04)
    assert scene.robot.command == STILL


def test_who_stepped_over_the_lidar_is_waited_for() -> None:
    scene = Monitored("scan", Stop=shipped_zones()["FootprintApproach"])
    for x in np.arange(1.2, 0.2, -0.08):
        scene.obstacle = (float(x), 0.0)
        scene.drive(0.0, 0.1)
    skin = np.full(360, 0.12)  # from within
    show(scene, skin, 0.0, 1.2)  # longer than scans are kept
    show(scene, skin, 0.2, 0.5)
    assert scene.robot.command == STILL


def test_a_post_on_the_robot_does_not_hold_its_turns() -> None:
    scene = Monitored("scan", Stop=shipped_zones()["FootprintApproach"])
    ranges = np.full(360, np.inf)
    ranges[280:296] = 0.2  # at the left
    show(scene, ranges, 0.2, 1.0)
    turn = Twist()
    turn.angular.z = 0.5
    scene.robot.bench.publish(Twist, "/cmd_vel_smoothed", turn)
    scene.robot.run(0.04)
    assert scene.robot.command.yaw_rate == pytest.approx(0.5)


def show(scene: Monitored, ranges: NDArray[np.float64], v: float, duration: float) -> None:
    """Command a speed, and publish scans of these ranges."""
    for _ in range(round(duration / 0.1)):
        scan = message("scan", None, scene.robot.now)
        scan.ranges = array.array("f", ranges.astype(np.float32).tobytes())
        scene.robot.bench.publish(LaserScan, "/it", scan, qos.DEFAULT)
        drive(scene.robot, v, 0.1)


@pytest.mark.parametrize("parameter", ["Stop.enabled", "it.enabled"])
def test_zones_and_sources_are_switched_while_it_runs(parameter: str) -> None:
    scene = Monitored("scan")
    scene.obstacle = (0.5, 0.0)
    for on, v in ((True, 0.0), (False, 0.1), (True, 0.0)):
        switch = Parameter(parameter, value=on).to_parameter_msg()
        request = SetParameters.Request(parameters=[switch])
        name = "/collision_monitor/set_parameters"
        assert scene.robot.bench.call(SetParameters, name, request).results[0].successful
        scene.say()
        drive(scene.robot, 0.1, 0.04)
        assert scene.robot.command.x == pytest.approx(v)


def test_a_transform_that_is_too_old_blinds_it() -> None:
    scene = Monitored("scan", transform_tolerance=0.3, source_timeout=5.0)
    scene.drive(0.1, 0.2)
    scene.robot.localized = False
    for seconds_old, v in ((0.1, 0.1), (0.5, 0.0)):
        scene.robot.run(seconds_old)
        scene.say()
        drive(scene.robot, 0.1, 0.04)
        assert scene.robot.command.x == pytest.approx(v)


@pytest.mark.parametrize("frame", ["base_link", "odom"])
def test_a_zones_shape_may_come_by_a_topic(frame: str) -> None:
    zone = {
        "type": "polygon",
        "action_type": "stop",
        "min_points": 1,
        "polygon_sub_topic": "/shape",
    }
    scene = Monitored("scan", Stop=zone)
    robot = scene.robot
    scene.obstacle = (0.7, 0.0)
    scene.drive(0.01, 0.2)
    assert robot.command.x == pytest.approx(0.01), "no shape has come"
    corners = [Point32(x=x, y=y) for x, y in ((1.0, 1.0), (1.0, -1.0), (-0.3, -1.0), (-0.3, 1.0))]
    shape = PolygonStamped(header=header(frame, robot.now), polygon=Polygon(points=corners))
    robot.bench.publish(PolygonStamped, "/shape", shape, qos.DEFAULT)
    scene.drive(0.01, 0.2)
    assert robot.command == STILL


def test_a_circles_radius_may_come_by_a_topic_and_outlines_are_shown() -> None:
    zone = {"type": "circle", "action_type": "stop", "min_points": 1, "polygon_sub_topic": "/r",
            "visualize": True, "polygon_pub_topic": "/shown"}  # fmt: skip
    scene = Monitored("scan", Stop=zone)
    shown = scene.robot.bench.collect(PolygonStamped, "/shown")
    scene.obstacle = (0.7, 0.0)
    for radius, v in ((0.5, 0.01), (0.8, 0.0)):
        scene.robot.bench.publish(Float32, "/r", Float32(data=radius), qos.DEFAULT)
        scene.drive(0.01, 0.2)
        assert scene.robot.command.x == pytest.approx(v)
        assert shown[-1].header.frame_id == "base_link"
        assert max(p.x for p in shown[-1].polygon.points) == pytest.approx(radius)


def test_the_published_footprint_is_what_approaches() -> None:
    zone = {"type": "polygon", "action_type": "approach", "min_points": 1}
    scene = Monitored("scan", Stop=zone)
    scene.robot.pose = SE2(1.0, -1.0, 2.0)
    scene.obstacle = None
    scene.drive(0.2, 1.0)
    ahead = scene.robot.pose @ SE2(0.28 + RADIUS + 0.1, 0.0)
    scene.obstacle = ahead.x, ahead.y
    scene.say()
    drive(scene.robot, 0.2, 0.04)
    # the outline of 0.25 m and its padding of 0.03 m: 0.1 m at 0.02 m a step
    assert 0.2 * 0.35 / 2.0 <= scene.robot.command.x <= 0.2 * 0.55 / 2.0


def test_the_detector_says_in_which_zones_something_is() -> None:
    scene = Monitored("scan")
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
