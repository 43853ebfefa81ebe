"""Claims: frames chain up to the one that is drawn in, and a stamp finds the pose of its time."""

from __future__ import annotations

import math

import pytest

from arjuna_core.pose3 import Pose3
from bringup.viewing.drawing.frames import Frames


def at(x: float, yaw: float = 0.0) -> Pose3:
    return Pose3.from_rpy((x, 0.0, 0.0), (0.0, 0.0, yaw))


@pytest.fixture
def frames() -> Frames:
    tree = Frames("map")
    tree.insert("map", "odom", 1.0, at(10.0), static=False)
    for tick in range(5):
        tree.insert("odom", "base", 1.0 + tick, at(float(tick)), static=False)
    tree.insert("base", "lidar", 0.0, at(0.5), static=True)
    tree.insert("map", "odom", 9.0, at(10.0), static=False)
    return tree


def x_of(pose: Pose3 | None) -> float:
    assert pose is not None
    return pose.position[0]


@pytest.mark.parametrize(
    ("frame", "stamp", "x"),
    [
        ("lidar", None, 14.5),  # the newest
        ("base", 2.9, 11.9),
        ("base", 0.1, 10.0),  # before all history: the oldest
    ],
)
def test_a_stamp_finds_the_pose_of_its_time(
    frame: str, stamp: float | None, x: float, frames: Frames
) -> None:
    assert x_of(frames.pose(frame, stamp)) == pytest.approx(x)


def test_an_unconnected_frame_has_no_pose(frames: Frames) -> None:
    assert frames.pose("elsewhere") is None


def test_without_the_wanted_frame_the_root_of_most_frames_is_drawn_in() -> None:
    tree = Frames("map")
    assert tree.fixed is None
    tree.insert("world", "moon", 0.0, at(1.0), static=True)
    tree.insert("odom", "base", 0.0, at(1.0), static=False)
    tree.insert("base", "lidar", 0.0, at(1.0), static=True)
    assert tree.fixed == "odom"
    tree.insert("map", "odom", 0.0, at(1.0), static=False)
    assert tree.fixed == "map"


def test_poses_are_given_in_the_wanted_frame_though_it_is_no_root() -> None:
    tree = Frames("map")
    tree.insert("earth", "map", 0.0, at(100.0, math.pi / 2), static=True)
    tree.insert("map", "base", 0.0, at(2.0), static=False)
    pose = tree.pose("base")
    assert pose is not None
    assert pose.position == pytest.approx((2.0, 0.0, 0.0))


def test_time_set_back_forgets_what_moves(frames: Frames) -> None:
    frames.insert("odom", "base", 0.0, at(7.0), static=False)
    assert frames.parents == {"base": "odom", "lidar": "base"}
    assert x_of(frames.pose("lidar")) >= 7.0


def test_a_stamp_that_the_transforms_have_not_reached_has_no_pose_yet(frames: Frames) -> None:
    assert frames.pose("base", 5.04) is not None
    assert frames.pose("base", 5.1) is None
    frames.insert("odom", "base", 5.1, at(5.1), static=False)
    assert frames.pose("base", 5.1) is not None
