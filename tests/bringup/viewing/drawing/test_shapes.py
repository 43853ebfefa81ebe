"""Claims: scans, poses, paths and beliefs become the points and lines they mean."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from bringup.viewing.drawing import shapes


def cloud(frame: str, poses: list[tuple[float, float, float]]) -> bytes:
    """Serialize a particle cloud as DDS does."""
    text = frame.encode() + b"\0"
    data = struct.pack("<iII", 3, 4, len(text)) + text
    data += b"\0" * (-len(data) % 4) + struct.pack("<I", len(poses))
    data += b"\0" * (-len(data) % 8)
    for x, y, yaw in poses:
        data += struct.pack("<8d", x, y, 0, 0, 0, math.sin(yaw / 2), math.cos(yaw / 2), 0.5)
    return b"\x00\x01\x00\x00" + data


def test_only_beams_that_hit_are_points() -> None:
    ranges = np.array([1.0, math.inf, math.nan, 2.0, 0.01])
    points = shapes.scan_points(Scan(ranges, 0.0, math.pi / 2, 0.1, 5.0))
    assert points.shape == (2, 3)
    assert points == pytest.approx(np.array([[1, 0, 0], [0, -2, 0]]), abs=1e-6)


def test_a_polyline_has_a_segment_between_neighbours() -> None:
    line = shapes.polyline(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), 0.5)
    assert line.tolist() == [[[0, 0, 0.5], [1, 0, 0.5]], [[1, 0, 0.5], [1, 1, 0.5]]]


def test_a_closed_polyline_returns_to_its_start() -> None:
    line = shapes.polyline(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), 0.0, closed=True)
    assert line.shape == (3, 2, 3)
    assert line[-1, 1].tolist() == [0, 0, 0]


@pytest.mark.parametrize("count", [0, 1])
def test_a_path_without_a_second_pose_has_no_segments(count: int) -> None:
    assert shapes.polyline(np.zeros((count, 3)), 0.0).shape == (0, 2, 3)


def test_an_arrow_points_where_its_pose_does() -> None:
    tail, tip = shapes.arrow(SE2(1.0, 2.0, math.pi / 2), 0.5, 0.1)[0]
    assert tail == pytest.approx(np.array([1.0, 2.0, 0.1]))
    assert tip == pytest.approx(np.array([1.0, 2.5, 0.1]))


def test_an_ellipse_reaches_two_sigmas_along_its_axes() -> None:
    covariance = np.diag([0.25, 0.01, 1.0])
    outline = shapes.ellipse(covariance, 0.0)[:, 0]
    assert np.abs(outline[:, 0]).max() == pytest.approx(1.0, rel=1e-3)
    assert np.abs(outline[:, 1]).max() == pytest.approx(0.2, rel=1e-3)


@pytest.mark.parametrize("frame", ["map", "maps", "robot1/map"])
def test_particles_are_read_whatever_the_length_of_their_frame(frame: str) -> None:
    poses = [(1.0, 2.0, 0.5), (-3.0, 0.0, -3.0)]
    found, rows = shapes.particles_from_cdr(cloud(frame, poses))
    assert found == frame
    assert rows == pytest.approx(np.array(poses))


def test_particles_in_another_encoding_are_refused() -> None:
    with pytest.raises(ValueError, match="not CDR little-endian"):
        shapes.particles_from_cdr(b"\x00\x00" + cloud("map", [])[2:])


def test_particles_cut_short_are_refused() -> None:
    whole = cloud("map", [(0.0, 0.0, 0.0)])
    for length in (10, 18, len(whole) - 1):
        with pytest.raises(ValueError, match=r"too short|buffer"):
            shapes.particles_from_cdr(whole[:length])
