"""Messages of sensors in any mount, as observations from the base and from the ground."""

from __future__ import annotations

import array
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import LaserScan, Range

from arjuna_core.pose3 import Pose3
from arjuna_core.ros.convert import header
from arjuna_core.se2 import SE2
from arjuna_core.transforms import TransformBuffer, TransformError
from arjuna_nav.nodes.costmap.sensors import (
    SensorFrames,
    WatchFrames,
    read_cloud,
    read_range,
    read_scan,
)
from tests.helpers.nav.monitored import cloud

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
