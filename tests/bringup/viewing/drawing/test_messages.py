"""Claims: scans, poses, paths and beliefs become the points and lines they mean."""

from __future__ import annotations

import math
import struct
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bringup.viewing.drawing.messages import DRAWN, particles_from_cdr
from bringup.viewing.drawing.values import Arrows, Grid, Line, Points
from tests.bringup.viewing.drives import grid, header, make, path_of, pose, scan


def cloud(frame: str, poses: list[tuple[float, float, float]]) -> bytes:
    """Serialize a particle cloud as DDS does."""
    text = frame.encode() + b"\0"
    data = struct.pack("<iII", 3, 4, len(text)) + text
    data += b"\0" * (-len(data) % 4) + struct.pack("<I", len(poses))
    data += b"\0" * (-len(data) % 8)
    for x, y, yaw in poses:
        data += struct.pack("<8d", x, y, 0, 0, 0, math.sin(yaw / 2), math.cos(yaw / 2), 0.5)
    return b"\x00\x01\x00\x00" + data


def line_of(kind: str, message: Any, topic: str = "/plan") -> Line:
    drawing = DRAWN[kind](topic, message)
    assert isinstance(drawing, Line)
    return drawing


def test_only_beams_that_hit_are_points() -> None:
    message = scan(0.5)
    message.ranges = np.array([1.0, math.inf, math.nan, 2.0, 0.01], dtype=np.float32)
    drawing = DRAWN["sensor_msgs/msg/LaserScan"]("/scan", message)
    assert isinstance(drawing, Points)
    assert (drawing.frame, drawing.stamp) == ("base_link", 0.0)
    assert drawing.points == pytest.approx(np.array([[1, 0, 0], [0, -2, 0]]), abs=1e-6)


def test_a_path_is_a_line_with_a_segment_between_neighbours() -> None:
    line = line_of("nav_msgs/msg/Path", path_of(0.0, 1.0, 3.0))
    assert line.points[:, 0].tolist() == [0, 1, 3]
    assert line.segments[:, :, 0].tolist() == [[0, 1], [1, 3]]


@pytest.mark.parametrize("count", [0, 1])
def test_a_path_without_a_second_pose_has_no_segments(count: int) -> None:
    assert line_of("nav_msgs/msg/Path", path_of(*range(count))).segments.shape == (0, 2, 3)


def test_a_path_that_is_not_finite_is_refused() -> None:
    with pytest.raises(ValueError, match="a position is not finite"):
        line_of("nav_msgs/msg/Path", path_of(0.0, math.nan))


def test_markers_are_the_points_of_all_of_them() -> None:
    def marker(*points: tuple[float, float]) -> Any:
        at = [make("geometry_msgs/msg/Point", x=x, y=y, z=0.0) for x, y in points]
        return SimpleNamespace(header=header("odom"), points=at)

    message = SimpleNamespace(markers=[marker((1.0, 2.0), (3.0, 4.0)), marker((5.0, 6.0))])
    drawing = DRAWN["visualization_msgs/msg/MarkerArray"]("/marker", message)
    assert isinstance(drawing, Points)
    assert (drawing.frame, drawing.points[:, 1].tolist()) == ("odom", [2, 4, 6])
    with pytest.raises(ValueError, match="no marker"):
        DRAWN["visualization_msgs/msg/MarkerArray"]("/marker", SimpleNamespace(markers=[]))


def test_a_footprint_returns_to_its_start() -> None:
    corners = [make("geometry_msgs/msg/Point32", x=x, y=y, z=0.0) for x, y in ((0, 0), (1, 0))]
    polygon = make("geometry_msgs/msg/Polygon", points=corners)
    message = make("geometry_msgs/msg/PolygonStamped", header=header("map"), polygon=polygon)
    line = line_of("geometry_msgs/msg/PolygonStamped", message)
    assert line.points[:, 0].tolist() == [0, 1, 0]


def test_an_arrow_points_where_its_pose_does() -> None:
    goal = make(
        "geometry_msgs/msg/PoseStamped", header=header("map"), pose=pose(1.0, 2.0, math.pi / 2)
    )
    drawing = DRAWN["geometry_msgs/msg/PoseStamped"]("/goal_pose", goal)
    assert isinstance(drawing, Arrows)
    tail, tip = drawing.segments[0]
    assert tail[:2] == pytest.approx(np.array([1.0, 2.0]))
    assert tip - tail == pytest.approx(np.array([0.0, 0.5, 0.0]), abs=1e-6)


def test_a_belief_leads_from_the_mean_along_the_heading_to_an_ellipse_of_two_sigmas() -> None:
    covariance = np.zeros((6, 6))
    covariance[0, 0], covariance[1, 1] = 0.25, 0.01
    belief = make(
        "geometry_msgs/msg/PoseWithCovariance",
        pose=pose(3.0, 0.0, math.pi / 2),
        covariance=covariance.ravel(),
    )
    kind = "geometry_msgs/msg/PoseWithCovarianceStamped"
    points = line_of(kind, make(kind, header=header("map"), pose=belief)).points
    assert points[0, :2] == pytest.approx(np.array([3.0, 0.0]))
    assert points[1, :2] == pytest.approx(np.array([3.0, 0.2]), abs=1e-6)
    assert points[-1] == pytest.approx(points[1], abs=1e-6)
    assert np.abs(points[:, 0] - 3.0).max() == pytest.approx(1.0, rel=1e-2)


def test_costs_are_see_through_and_above_the_map() -> None:
    kind = "nav_msgs/msg/OccupancyGrid"
    a_map, costs = (DRAWN[kind](topic, grid()) for topic in ("/map", "/local_costmap/costmap"))
    assert isinstance(a_map, Grid)
    assert isinstance(costs, Grid)
    assert (a_map.opacity, costs.opacity) == (None, 0.65)
    assert a_map.size == pytest.approx((3.1, 2.0))
    assert a_map.pose.position == pytest.approx((-1.05, -1.0, 0.0))
    assert costs.pose.position[2] > 0.0


@pytest.mark.parametrize("frame", ["map", "maps", "robot1/map"])
def test_particles_are_read_whatever_the_length_of_their_frame(frame: str) -> None:
    poses = [(1.0, 2.0, 0.5), (-3.0, 0.0, -3.0)]
    found, rows = particles_from_cdr(cloud(frame, poses))
    assert found == frame
    assert rows == pytest.approx(np.array(poses))


def test_particles_in_another_encoding_are_refused() -> None:
    with pytest.raises(ValueError, match="not CDR little-endian"):
        particles_from_cdr(b"\x00\x00" + cloud("map", [])[2:])


def test_particles_cut_short_are_refused() -> None:
    whole = cloud("map", [(0.0, 0.0, 0.0)])
    for length in (10, 18, len(whole) - 1):
        with pytest.raises(ValueError, match=r"too short|buffer"):
            particles_from_cdr(whole[:length])
