"""Claims: particles are read of the bytes of their message."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest

from bringup.viewing.drawing.messages import particles_from_cdr


def cloud(frame: str, poses: list[tuple[float, float, float]]) -> bytes:
    """Serialize a particle cloud as DDS does."""
    text = frame.encode() + b"\0"
    data = struct.pack("<iII", 3, 4, len(text)) + text
    data += b"\0" * (-len(data) % 4) + struct.pack("<I", len(poses))
    data += b"\0" * (-len(data) % 8)
    for x, y, yaw in poses:
        data += struct.pack("<8d", x, y, 0, 0, 0, math.sin(yaw / 2), math.cos(yaw / 2), 0.5)
    return b"\x00\x01\x00\x00" + data


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
