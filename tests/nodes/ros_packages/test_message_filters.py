"""message_filters: sets of messages of several topics, and the last ones of one."""

from __future__ import annotations

from typing import Any

import pytest
from message_filters import (
    ApproximateTimeSynchronizer,
    Cache,
    SimpleFilter,
    Subscriber,
    TimeSynchronizer,
)
from rclpy.clock import ClockType
from rclpy.time import Time
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import String

from arjuna_core.ros.convert import header
from tests.helpers.ros import RosBench


def _image(stamp: float) -> Image:
    return Image(header=header("camera", stamp))


def _time(seconds: float) -> Time:
    return Time(nanoseconds=round(seconds * 1e9), clock_type=ClockType.ROS_TIME)


def _stamps(sets: list[Any]) -> list[tuple[float, ...]]:
    return [tuple(m.header.stamp.sec + m.header.stamp.nanosec / 1e9 for m in one) for one in sets]


def test_messages_of_one_time_come_together(bench: RosBench) -> None:
    found: list[Any] = []
    images = Subscriber(bench.node, Image, "image")
    cameras = Subscriber(bench.node, CameraInfo, "camera_info", qos_profile=5)
    together = TimeSynchronizer([images, cameras], 2)
    together.registerCallback(lambda *messages: found.append(messages[:2]), "mine")
    for stamp in (1.0, 2.0, 3.0):
        bench.publish(Image, "image", _image(stamp))
    bench.publish(CameraInfo, "camera_info", CameraInfo(header=header("camera", 2.0)))
    bench.publish(CameraInfo, "camera_info", CameraInfo(header=header("camera", 1.0)))
    assert _stamps(found) == [(2.0, 2.0)]  # the queue has forgotten 1.0
    assert images.getTopic() == "image"
    images.unregister()
    bench.publish(Image, "image", _image(1.0))
    assert len(found) == 1


def test_messages_of_nearly_one_time_come_together_once() -> None:
    one, two, found = SimpleFilter(), SimpleFilter(), list[Any]()
    together = ApproximateTimeSynchronizer([one, two], 10, slop=0.1)
    together.registerCallback(lambda *messages: found.append(messages))
    for stamp in (1.0, 1.08):
        one.signalMessage(_image(stamp))
    two.signalMessage(_image(1.06))
    two.signalMessage(_image(1.05))
    two.signalMessage(_image(1.5))
    assert _stamps(found) == [(1.08, 1.06), (1.0, 1.05)]


@pytest.mark.parametrize("allowed", [False, True])
def test_messages_without_a_header_are_refused_unless_allowed(allowed: bool) -> None:
    one, two, found = SimpleFilter(), SimpleFilter(), list[Any]()
    together = ApproximateTimeSynchronizer([one, two], 10, 60.0, allow_headerless=allowed)
    together.registerCallback(lambda *messages: found.append(messages))
    one.signalMessage(String(data="a"))
    two.signalMessage(String(data="b"))
    assert bool(found) == allowed


@pytest.fixture
def cache() -> Cache:
    source = SimpleFilter()
    made = Cache(source, cache_size=3)
    for stamp in (1.0, 3.0, 2.0, 4.0):
        source.signalMessage(_image(stamp))
    return made


def test_a_cache_knows_the_last_messages_by_their_times(cache: Cache) -> None:
    between = cache.getInterval(_time(1.5), _time(3.5))
    assert _stamps([between]) == [(2.0, 3.0)]
    after, before = cache.getElemAfterTime(_time(2.5)), cache.getElemBeforeTime(_time(2.5))
    assert _stamps([(after, before, cache.getLast())]) == [(3.0, 2.0, 4.0)]
    assert cache.getElemBeforeTime(_time(0.5)) is None
    oldest, newest = cache.getOldestTime(), cache.getLastestTime()
    assert oldest is not None
    assert newest is not None
    assert (oldest.nanoseconds, newest.nanoseconds) == (2_000_000_000, 4_000_000_000)
