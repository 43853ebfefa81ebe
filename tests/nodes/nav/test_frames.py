"""The robot's pose and what sensors in any mount see; an error of a transform has its remedy."""

from __future__ import annotations

import array
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import LaserScan, Range
from tf2_msgs.msg import TFMessage

from arjuna_core.pose3 import Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, pose_stamped, seconds, transform_msg
from arjuna_core.se2 import SE2
from arjuna_core.transforms import TransformBuffer, TransformError
from arjuna_nav.nodes.costmap.sensors import (
    SensorFrames,
    WatchFrames,
    read_cloud,
    read_range,
    read_scan,
)
from arjuna_nav.nodes.frames import pose_in, robot_pose
from bringup.stack import further_nodes
from tests.helpers.nav.monitored import cloud
from tests.helpers.ros import RosBench


def _node(now: float, *edges: tuple[str, str]) -> Any:
    """Return what `robot_pose` needs of a node, with transforms of 10 s."""
    tree = TransformBuffer()
    for parent, child in edges:
        tree.insert(parent, child, 10.0, SE2(1.0, 0.0))
    return SimpleNamespace(transforms=tree, now=now)


CHAIN = (("map", "odom"), ("odom", "robot_footprint"))


@pytest.mark.parametrize(
    ("now", "edges", "base", "said"),
    [
        (10.1, CHAIN, "base_link", "'map' carries 'robot_footprint'; set robot_base_frame: robot_"),
        (10.1, CHAIN[1:], "base_link", "'odom' carries 'robot_footprint'; set robot_base_frame"),
        (10.1, (), "base_link", "is odometry's transform on /tf"),
        (10.1, CHAIN[1:], "robot_footprint", "no transform connects 'map' and 'robot_footprint'"),
        (12.0, CHAIN, "robot_footprint", "2.00 s old, over the tolerance of 0.3 s"),
        (1.8e9, CHAIN, "robot_footprint", "start this node with use_sim_time:=true"),
    ],
)
def test_a_pose_that_is_not_known_names_the_remedy(
    now: float, edges: tuple[tuple[str, str], ...], base: str, said: str
) -> None:
    with pytest.raises(TransformError, match=said):
        robot_pose(_node(now, *edges), "map", base, 0.3)


def test_a_pose_that_is_known_is_returned() -> None:
    assert robot_pose(_node(10.1, *CHAIN), "map", "robot_footprint", 0.3) == SE2(2.0, 0.0)


@pytest.mark.parametrize("now", [1.8e9, 1.8e9 + 5.0])
def test_a_server_without_a_costmap_of_its_own_takes_poses_of_another_clock(now: float) -> None:
    node, said = _node(now, *CHAIN), []
    node.get_logger = lambda: SimpleNamespace(warning=lambda text, once: said.append((text, once)))
    pose = robot_pose(node, "map", "robot_footprint", 0.3, any_clock=True)
    assert pose == SE2(2.0, 0.0)
    ((text, once),) = said
    assert once
    assert "start this node with use_sim_time:=true" in text
    with pytest.raises(TransformError, match="over the tolerance"):
        robot_pose(_node(12.0, *CHAIN), "map", "robot_footprint", 0.3, any_clock=True)


def test_a_pose_without_a_frame_is_refused() -> None:
    with pytest.raises(TransformError, match=r"frame_id is empty; valid: 'map'"):
        pose_in(_node(10.0), "map", pose_stamped(SE2(1.0, 0.0), "", 10.0))


@pytest.mark.parametrize(
    ("values", "frames"),
    [
        ({}, ("base_link", "base_footprint")),
        ({"base_link_frame": "imu", "base_footprint_frame": "ground"}, ("imu", "ground")),
    ],
)
def test_tilt_and_height_are_removed(values: dict[str, str], frames: tuple[str, str]) -> None:
    bench = RosBench()
    (spec,) = further_nodes({"base_footprint_publisher": {}})
    node = spec.make(bench.process, values)
    node.trigger_configure()
    node.trigger_activate()
    bench.advance(0.1)
    seen = bench.collect(TFMessage, "/tf")
    tilted = transform_msg(SE2(1.0, 2.0, 0.7), "odom", frames[0], 0.06)
    tilted.transform.translation.z = 0.4
    tilted.transform.rotation.x += 0.1
    other = transform_msg(SE2(), "odom", "wheel", 0.06)
    bench.publish(TFMessage, "/tf", TFMessage(transforms=[other, tilted]), qos.TF)
    (level,) = [each for m in seen for each in m.transforms if each.child_frame_id == frames[1]]
    assert level.header.frame_id == "odom"
    assert seconds(level.header.stamp) == pytest.approx(0.06)
    moved, turn = level.transform.translation, level.transform.rotation
    assert (moved.x, moved.y, moved.z, turn.x, turn.y) == (1.0, 2.0, 0.0, 0.0, 0.0)
    bench.close()


BASE_HEIGHT = 0.1
ANGLES = np.linspace(-2.0, 2.0, 9)


def scan_of(ranges: list[float]) -> Any:
    step = float(ANGLES[1] - ANGLES[0])
    return LaserScan(header=header("lidar_link", 1.0), angle_min=float(ANGLES[0]),
        angle_max=float(ANGLES[-1]), angle_increment=step, range_min=0.05, range_max=10.0,
        ranges=array.array("f", ranges))  # fmt: skip


class Mounted:
    """A sensor in a frame of the base, which stands above the ground of odom."""

    def __init__(self, xyz: tuple[float, float, float], rpy: tuple[float, float, float]) -> None:
        self.turn, self.at = Rotation.from_euler("xyz", rpy), np.array(xyz)
        self.buffer = TransformBuffer()
        self.odom = SE2(0.4, -0.2, 1.0)
        base, sensor = Pose3.from_se2(self.odom, BASE_HEIGHT), Pose3.from_rpy(xyz, rpy)
        x_axis = self.turn.apply([1.0, 0.0, 0.0])
        planar = SE2(xyz[0], xyz[1], math.atan2(x_axis[1], x_axis[0]))
        self.buffer.insert("odom", "base", 1.0, self.odom, mount=base)
        self.buffer.insert("base", "lidar_link", 0.0, planar, static=True, mount=sensor)
        node: Any = SimpleNamespace(transforms=self.buffer)
        self.node = node
        self.ground = SensorFrames(node, "odom", "base")
        self.base = WatchFrames(node, "odom", "base", correction=True, tolerance=0.1)

    def seen(self, points: Any) -> Any:
        """Return points of the sensor's frame in the base's, `(N, 3)` [m]."""
        return self.turn.apply(points) + self.at


TURNS = [(0.0, 0.0, 0.0), (0.0, 0.0, 2.0), (math.pi, 0.0, 0.5), (0.0, 0.4, -1.0), (2.8, 0.3, 0.7)]


@pytest.mark.parametrize("rpy", TURNS)
@pytest.mark.parametrize("seed", range(3))
def test_beams_end_where_the_mount_says(rpy: tuple[float, float, float], seed: int) -> None:
    rng = np.random.default_rng(seed)
    mounted = Mounted((0.2, -0.1, 0.3), rpy)
    ranges = np.round(rng.uniform(0.2, 5.0, 9), 2)
    flat = ranges * np.array([np.cos(ANGLES), np.sin(ANGLES), np.zeros(9)])
    expected = mounted.seen(flat.T)
    message, above_base = scan_of(ranges.tolist()), np.array([0.0, 0.0, BASE_HEIGHT])
    np.testing.assert_allclose(read_scan(mounted.base, message).ends(), expected, atol=1e-6)
    above = read_scan(mounted.ground, message, mounted.odom)
    np.testing.assert_allclose(above.ends(), expected + above_base, atol=1e-6)
    assert above.T_global_base == mounted.odom
    assert above.is_planar == (abs(rpy[1]) + abs(math.sin(rpy[0])) < 1e-9)


def test_only_beams_that_hit_have_ends() -> None:
    message = scan_of([1.0, math.inf, math.nan, 0.01, 11.0, 2.0, 10.0, 3.0, 4.0])
    ends = read_scan(Mounted((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)).base, message).ends()
    assert np.hypot(*ends[:, :2].T) == pytest.approx([1.0, 2.0, 3.0, 4.0])


def test_clouds_and_ranges_take_the_same_frames() -> None:
    mounted = Mounted((0.2, -0.1, 0.3), (0.0, 0.0, 1.0))
    points = [(1.0, 2.0, 0.1), (-1.0, 0.5, 0.2)]
    seen = read_cloud(mounted.base, cloud(points, 1.0)).reading
    np.testing.assert_allclose(seen.points, mounted.seen(points), atol=1e-6)
    above = read_cloud(mounted.ground, cloud(points, 1.0), start="base").reading
    assert above.points[:, 2] == pytest.approx(seen.points[:, 2] + BASE_HEIGHT)
    assert above.sensor == pytest.approx((0.0, 0.0, BASE_HEIGHT))
    message = Range(header=header("lidar_link", 1.0), field_of_view=0.5, min_range=0.1,
        max_range=4.0, range=1.5)  # fmt: skip
    reading = read_range(mounted.base, message).reading
    assert (reading.distance, reading.fixed) == (1.5, False)
    assert reading.T_base_sensor.distance(SE2(0.2, -0.1, 1.0)) == pytest.approx(0.0)


def test_a_pose_may_be_hardly_older_than_what_was_seen() -> None:
    frames = Mounted((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)).base
    assert frames.pose(1.05) == SE2(0.4, -0.2, 1.0)
    assert frames.since(1.05).distance(SE2()) == pytest.approx(0.0)
    with pytest.raises(TransformError, match=r"behind what was seen by 0\.20 s, over"):
        frames.pose(1.2)
