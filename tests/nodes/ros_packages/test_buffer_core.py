"""tf2_py's BufferCore: trees of frames, interpolation, and tf2's own exceptions."""

from __future__ import annotations

import math

import pytest
from geometry_msgs.msg import TransformStamped
from rclpy.time import Time
from tf2_py import (
    BufferCore,
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
)


def transform(
    parent: str, child: str, stamp: float, x: float = 0.0, yaw: float = 0.0, y: float = 0.0
) -> TransformStamped:
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.header.stamp = Time(nanoseconds=round(stamp * 1e9)).to_msg()
    message.transform.translation.x, message.transform.translation.y = x, y
    message.transform.rotation.w = math.cos(yaw / 2.0)
    message.transform.rotation.z = math.sin(yaw / 2.0)
    return message


def at(stamp: float) -> Time:
    return Time(nanoseconds=round(stamp * 1e9))


@pytest.fixture
def core() -> BufferCore:
    """A robot that turned left as it drove, with a lidar 0.5 m ahead of its base."""
    core = BufferCore()
    core.set_transform(transform("odom", "base", 1.0, 0.0, 0.0))
    core.set_transform(transform("odom", "base", 2.0, 1.0, math.pi / 2.0))
    core.set_transform_static(transform("base", "lidar", 0.0, 0.5))
    return core


def test_a_chain_is_multiplied_out_at_the_latest_time(core: BufferCore) -> None:
    found = core.lookup_transform_core("odom", "lidar", Time())
    t = found.transform.translation
    assert (t.x, t.y) == pytest.approx((1.0, 0.5))
    assert (found.header.frame_id, found.child_frame_id) == ("odom", "lidar")
    assert found.header.stamp.sec == 2


def test_a_time_is_one_of_rclpy_or_the_stamp_of_a_message(core: BufferCore) -> None:
    for time in (at(1.5), at(1.5).to_msg()):
        assert core.can_transform_core("odom", "base", time) == (True, "")
        found = core.lookup_transform_core("odom", "base", time)
        assert found.header.stamp == at(1.5).to_msg()
        full = core.lookup_transform_full_core("odom", time, "base", time, "odom")
        assert full.transform == found.transform
    newest = core.lookup_transform_core("odom", "base", Time().to_msg())
    assert newest.header.stamp.sec == 2
    with pytest.raises(TypeError, match="time must have sec and nanosec, or nanoseconds"):
        core.lookup_transform_core("odom", "base", 1.5)


def test_its_frames_and_times_are_listed(core: BufferCore) -> None:
    assert core._getFrameStrings() == ["base", "lidar", "odom"]
    assert (core._frameExists("odom"), core._frameExists("map")) == (True, False)
    assert core.get_latest_common_time("odom", "lidar").nanoseconds == 2_000_000_000
    known, unknown = at(1.2), at(9.0)
    assert core.can_transform_full_core("base", known, "base", at(1.8), "odom") == (True, "")
    assert not core.can_transform_full_core("base", unknown, "base", known, "odom")[0]
    with pytest.raises(LookupException, match="does not exist"):
        core.get_latest_common_time("odom", "map")


def test_backwards_is_the_inverse(core: BufferCore) -> None:
    t = core.lookup_transform_core("lidar", "odom", at(2.0)).transform.translation
    assert (t.x, t.y) == pytest.approx((-0.5, 1.0))


def test_between_two_times_through_a_fixed_frame(core: BufferCore) -> None:
    found = core.lookup_transform_full_core("base", at(2.0), "base", at(1.0), "odom")
    t = found.transform.translation
    assert (t.x, t.y) == pytest.approx((0.0, 1.0))


@pytest.mark.parametrize(
    ("stamp", "message"),
    [
        (2.5, r"extrapolation into the future.  Requested time 2.5\d+ but the latest data is at"),
        (0.5, r"extrapolation into the past.*from frame \[lidar\] to frame \[odom\]"),
    ],
)
def test_extrapolation_fails_as_in_tf2(core: BufferCore, stamp: float, message: str) -> None:
    with pytest.raises(ExtrapolationException, match=message):
        core.lookup_transform_core("odom", "lidar", at(stamp))


def test_unknown_and_unconnected_frames_are_distinguished(core: BufferCore) -> None:
    core.set_transform(transform("there", "thing", 1.0))
    with pytest.raises(LookupException, match='"map" passed to lookupTransform argument target'):
        core.lookup_transform_core("map", "base", Time())
    with pytest.raises(ConnectivityException, match="not part of the same tree"):
        core.lookup_transform_core("there", "base", Time())
    assert core.can_transform_core("odom", "lidar", Time()) == (True, "")
    assert core.can_transform_core("odom", "nope", Time()) == (
        False,
        'Invalid frame ID "nope" passed to canTransform argument source_frame'
        " - frame does not exist",
    )


@pytest.mark.parametrize(
    "wrong", [transform("a", "a", 0.0), transform("", "b", 0.0), transform("a", "b", 0.0, math.nan)]
)
def test_what_is_no_transform_is_refused(wrong: TransformStamped) -> None:
    with pytest.raises(InvalidArgumentException, match=r"no (transform|rigid motion)"):
        BufferCore().set_transform(wrong)


def test_frames_as_yaml_name_parent_and_rate(core: BufferCore) -> None:
    text = core.all_frames_as_yaml()
    assert "base: \n  parent: 'odom'" in text
    assert "  rate: 1.000" in text
