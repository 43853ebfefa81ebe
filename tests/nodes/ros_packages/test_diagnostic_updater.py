"""diagnostic_updater and message_filters as scripts use them."""

from __future__ import annotations

from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from diagnostic_updater import (
    CompositeDiagnosticTask,
    DiagnosedPublisher,
    DiagnosticStatusWrapper,
    FrequencyStatus,
    FrequencyStatusParam,
    FunctionDiagnosticTask,
    Heartbeat,
    TimeStampStatusParam,
    Updater,
)
from message_filters import (
    ApproximateTimeSynchronizer,
    Cache,
    SimpleFilter,
    Subscriber,
    TimeSynchronizer,
)
from rclpy.clock import ClockType
from rclpy.time import Time
from sensor_msgs.msg import CameraInfo, Image, Imu
from std_msgs.msg import String

from arjuna_core.ros.convert import header
from tests.helpers.ros import RosBench

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


def _warm(stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
    stat.summary(WARN, "warm")
    stat.add("temperature", 61.5)
    return stat


def test_tasks_are_published_with_the_nodes_name(bench: RosBench) -> None:
    arrays = bench.collect(DiagnosticArray, "/diagnostics")
    updater = Updater(bench.node)
    updater.setHardwareID("none")
    updater.add("motor", _warm)
    bench.process.drain()
    assert arrays[-1].status[0].message == "Node starting up"
    updater.add(Heartbeat())
    updater.force_update()
    bench.process.drain()
    first, second = arrays[-1].status
    assert (first.name, first.level, first.hardware_id) == ("bench_client: motor", WARN, "none")
    assert (first.values[0].key, first.values[0].value) == ("temperature", "61.5")
    assert (second.level, second.message) == (OK, "Alive")
    updater.broadcast(ERROR, "stopping")
    bench.process.drain()
    assert {one.message for one in arrays[-1].status} == {"stopping"}
    assert updater.removeByName("motor")
    assert not updater.removeByName("motor")
    assert bench.node.get_parameter("diagnostic_updater.period").value == 1.0


def test_a_task_of_tasks_is_as_bad_as_the_worst() -> None:
    both = CompositeDiagnosticTask("both")
    both.addTask(FunctionDiagnosticTask("a", _warm))
    both.addTask(Heartbeat())
    stat = both.run(DiagnosticStatusWrapper(level=OK))
    assert (stat.level, stat.message) == (WARN, "warm")
    stat.mergeSummary(ERROR, "hot")
    assert (stat.level, stat.message) == (ERROR, "warm; hot")


@pytest.mark.parametrize(
    ("count", "bound", "level"),
    [
        (0, {"min": 1.0}, ERROR),
        (1, {"min": 1e9}, WARN),
        (1, {"min": 0.0, "max": 1e-9}, WARN),
        (1, {"min": 0.0, "max": 1e9}, OK),
    ],
)
def test_a_frequency_is_held_to_its_bounds(count: int, bound: Any, level: bytes) -> None:
    task = FrequencyStatus(FrequencyStatusParam(bound))
    for _ in range(count):
        task.tick()
    stat = task.run(DiagnosticStatusWrapper())
    assert stat.level == level
    assert "Actual frequency (Hz)" in {item.key for item in stat.values}


def test_a_publisher_reports_old_stamps(bench: RosBench) -> None:
    imus, arrays = bench.collect(Imu, "imu"), bench.collect(DiagnosticArray, "/diagnostics")
    bench.advance(20.0)
    updater = Updater(bench.node)
    bounds = FrequencyStatusParam({"min": 0.0}), TimeStampStatusParam()
    out = DiagnosedPublisher(bench.node.create_publisher(Imu, "imu", 5), updater, *bounds)
    out.publish(Imu(header=header("imu", 3.0)))
    updater.force_update()
    bench.process.drain()
    assert len(imus) == 1
    (status,) = arrays[-1].status
    assert status.level == ERROR
    assert status.message == "Timestamps too far in past seen."


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
