"""Process: what is due runs behind the messages that were queued before it."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import threading
from pathlib import Path
from queue import SimpleQueue
from types import SimpleNamespace
from typing import Any

import pytest
import rclpy
from defusedxml import ElementTree
from nav2_msgs.action import Wait
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from arjuna_core.errors import ArjunaError, ConfigError
from arjuna_core.ros import context, qos
from arjuna_core.ros.context import class_of, discovery, new_context
from arjuna_core.ros.convert import time_msg, transform_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.process import Process, Transport
from arjuna_core.ros.tf import TransformPublisher, transforms_msg
from arjuna_core.ros.worker import Worker
from arjuna_core.se2 import SE2
from bringup.stack import (
    COLLISION_MONITOR,
    CONTROLLER_SERVER,
    LOCAL_COSTMAP,
    VELOCITY_SMOOTHER,
    NodeSpec,
)
from tests.helpers.ros import TICK, RosBench

STALL = 25  # ticks, 0.5 s


def test_a_worker_hands_over_in_the_executor_what_its_thread_computed() -> None:
    later: SimpleQueue[Any] = SimpleQueue()
    process: Any = SimpleNamespace(isolated=False, later=later.put)
    worker, results = Worker(process), list[str]()
    worker.run(lambda: threading.current_thread().name, lambda take: results.append(take()))
    call = later.get(timeout=10.0)
    assert results == []
    call()
    worker.destroy()
    assert results != [threading.current_thread().name]


class WatchNode(ManagedNode):
    """Notes the time and the age of the newest transform, each period."""

    DEFAULT_NAME = "watch"

    def configure(self) -> None:
        self.ages: list[tuple[float, float]] = []
        self.every(0.1, self._look)

    def _look(self) -> None:
        newest = self.transforms.latest_common("odom", "base_link")
        self.ages.append((self.now, self.now - newest))


def stalled(bench: RosBench) -> None:
    """Let half a second of clock and transforms queue up, then run it all."""
    clock = bench.node.create_publisher(Clock, "/clock", qos.LATEST)
    transforms = bench.node.create_publisher(TFMessage, "/tf", qos.TF)
    bench.process.drain()
    for tick in range(2, STALL + 2):
        now = tick * TICK
        clock.publish(Clock(clock=time_msg(now)))
        pose = transform_msg(SE2(now, 0.0), "odom", "base_link", now)
        transforms.publish(TFMessage(transforms=[pose]))
    bench.process.drain()


def test_after_a_stall_what_is_due_sees_the_newest_transform(bench: RosBench) -> None:
    node = WatchNode(bench.process)
    node.trigger_configure()
    bench.advance()
    bench.publish(TFMessage, "/tf", TFMessage(transforms=[_start()]))
    node.trigger_activate()
    stalled(bench)
    assert node.ages[-1][0] == pytest.approx((STALL + 1) * TICK)
    assert max(age for _, age in node.ages) < TICK / 2


def test_what_is_due_has_run_when_the_process_is_drained(bench: RosBench) -> None:
    node = WatchNode(bench.process)
    node.trigger_configure()
    bench.publish(TFMessage, "/tf", TFMessage(transforms=[_start()]))
    node.trigger_activate()
    bench.advance(0.5)
    assert [now for now, _ in node.ages] == pytest.approx([0.02, 0.1, 0.2, 0.3, 0.4, 0.5])


def _start() -> object:
    return transform_msg(SE2(), "odom", "base_link", 0.0)


def test_of_transforms_in_one_message_the_impossible_are_refused(bench: RosBench) -> None:
    good = transform_msg(SE2(1.0, 0.0), "odom", "base_link", 0.0)
    bad = transform_msg(SE2(), "odom", "odom", 0.0)
    bench.publish(TFMessage, "/tf", TFMessage(transforms=[bad, good]))
    assert bench.process.transforms.lookup("odom", "base_link") == SE2(1.0, 0.0)
    (tally,) = bench.process.guard.tallies.values()
    assert tally.count == 1


def test_what_waits_is_run_without_waiting_for_what_it_queues(bench: RosBench) -> None:
    """Else a process in which work comes faster than it is done could not end."""
    runs: list[int] = []

    def again() -> None:
        runs.append(len(runs))
        bench.process.executor.create_task(again)

    bench.process.executor.create_task(again)
    bench.process.run_waiting()
    assert runs == [0]


def test_words_that_ros_cannot_read_are_named() -> None:
    with pytest.raises(ArjunaError, match=r"__node:=a\.b"):
        new_context(words=["--ros-args", "-r", "__node:=a.b"])


def test_an_absolute_name_is_below_the_robots_namespace() -> None:
    process = Process("host", isolated=True, namespace="/robot1/")
    try:
        node = WatchNode(process, name="watch", namespace="costmap")
        assert process.absolute("/tf") == "/robot1/tf"
        assert process.absolute("scan") == "scan"
        assert process.absolute("/robot1/scan") == process.absolute("robot1/scan") == "/robot1/scan"
        assert process.absolute("/robot10/scan") == "/robot1/robot10/scan"
        assert process.find("costmap/watch") is node
        assert node.publisher(Clock, "/time", qos.LATEST).topic_name == "/robot1/time"
        assert node.publisher(Clock, "time", qos.LATEST).topic_name == "/robot1/costmap/time"
    finally:
        process.close()


def test_what_is_shared_is_listened_to_outside_the_namespace_too() -> None:
    process = Process("host", isolated=True, namespace="/robot1")
    try:
        node = WatchNode(process, name="watch")
        for topic, shared in ("/map", True), ("/mask", False), ("grid", True):
            node.subscribe(Clock, topic, print, qos.LATEST, shared=shared)
        named = dict(node.get_topic_names_and_types())
        there = {f"{n}/{t}" for n in ("", "/robot1") for t in ("map", "mask", "grid")}
        assert there & named.keys() == {"/map", "/robot1/map", "/robot1/mask", "/robot1/grid"}
    finally:
        process.close()


def test_frames_of_a_robot_s_own_name_are_all_robots_transforms() -> None:
    process = Process("host", isolated=True, namespace="/r1")
    try:
        node = WatchNode(process, name="watch")
        process.set_time(1_000_000_000)
        out = node.create_publisher(TFMessage, "/tf", qos.TF)
        for parent, child in (("map", "r1/odom"), ("map", "r1_odom"), ("map", "odom")):
            out.publish(transforms_msg(transform_msg(SE2(), parent, child, 1.0)))
        process.run_waiting()
        known = [
            c for c in ("r1/odom", "r1_odom", "odom") if process.transforms.try_lookup("map", c)
        ]
        assert known == ["r1/odom", "r1_odom"]
        heard: list[str] = []
        for topic in ("/tf", "/r1/tf"):
            heard_on = lambda m, t=topic: heard.append(f"{t} {m.transforms[0].child_frame_id}")  # noqa: E731
            node.create_subscription(TFMessage, topic, heard_on, qos.TF)
        shared = TransformPublisher(node, "/tf", qos.TF)
        for child in ("base", "r1/base"):
            shared.publish(transforms_msg(transform_msg(SE2(), "odom", child, 1.0)))
        process.run_waiting()
        assert sorted(heard) == ["/r1/tf base", "/r1/tf r1/base", "/tf r1/base"]
    finally:
        process.close()


@pytest.mark.parametrize("transport", ["dds", "local"])
def test_only_a_process_on_the_middleware_publishes_its_log(transport: Transport) -> None:
    bench = RosBench(transport=transport)
    logs = bench.process.node.get_publishers_info_by_topic("/rosout")
    bench.close()
    assert ("bench" in {end.node_name for end in logs}) == (transport == "dds")


@pytest.mark.parametrize("spec", [VELOCITY_SMOOTHER, COLLISION_MONITOR, CONTROLLER_SERVER])
@pytest.mark.parametrize("wanted", [True, False])
def test_a_node_asks_for_priority_where_its_parameter_says_so(
    monkeypatch: pytest.MonkeyPatch, spec: NodeSpec, wanted: bool
) -> None:
    asked: list[tuple[Any, ...]] = []
    monkeypatch.setattr(os, "sched_setscheduler", lambda *values: asked.append(values))
    process = Process("test", isolated=True)
    LOCAL_COSTMAP.make(process, {}).trigger_configure()  # the controller server needs one
    node = spec.make(process, {"use_realtime_priority": wanted})
    node.trigger_configure()
    assert [values[:2] for values in asked] == [(0, os.SCHED_FIFO)] * wanted
    assert all(values[2].sched_priority == 49 for values in asked)
    process.close()


def test_a_priority_that_is_not_allowed_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*values: Any) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    process = Process("test", isolated=True)
    with pytest.raises(ConfigError, match="'use_realtime_priority' is true: Operation not permit"):
        process.use_realtime_priority()
    process.close()


PROFILES = [Path(context.__file__).with_name(name) for name in ("fastdds.xml", "fastdds_open.xml")]
_FAST_DDS = "{http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles}"
_SEGMENT = 4 << 20  # [bytes] what the profile asks for
_PORTS = """
import os
from rclpy.node import Node
from arjuna_core.ros.context import new_context

context = new_context(7)
node = Node("one", context=context)
sockets = [f"/proc/self/fd/{fd}" for fd in os.listdir("/proc/self/fd")]
sockets = {os.readlink(path) for path in sockets if os.path.lexists(path)}
for line in open("/proc/net/udp").read().splitlines()[1:]:
    address, port = line.split()[1].split(":")
    if f"socket:[{line.split()[9]}]" in sockets and 9150 <= int(port, 16) < 9400:
        print(address)
node.destroy_node()
context.shutdown()
"""
"""The addresses at which a participant of domain 7 is reached: DDS gives it 250 ports."""
_NODE = """
import os

os.umask(0)
from rclpy.node import Node
from arjuna_core.ros.context import class_of, discovery, new_context

context = new_context()
node = Node("one", context=context)
mine = [line.split()[-1] for line in open("/proc/self/maps") if "/dev/shm/fastrtps_" in line]
print(max(os.path.getsize(path) for path in mine), sum(os.stat(p).st_mode & 0o022 for p in mine))
node.destroy_node()
context.shutdown()
"""


def test_shared_memory_holds_pictures_and_nobody_else_writes_it() -> None:
    size, writable = map(int, run_alone(_NODE).split())
    assert size >= _SEGMENT
    assert writable == 0


def run_alone(code: str, **variables: str) -> str:
    """Return what a process of its own prints that has these variables of the middleware."""
    kept = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("FASTRTPS", "ROS_AUTOMATIC", "ROS_STATIC"))
    }
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=kept | variables,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.stderr == ""
    return done.stdout


@pytest.mark.parametrize(
    ("variables", "opens"),
    [
        ({}, False),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_STATIC_PEERS": ""}, False),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, True),
        ({"ROS_STATIC_PEERS": "192.0.2.9"}, True),
    ],
)
def test_only_wider_ranges_or_peers_open_sockets(variables: dict[str, str], opens: bool) -> None:
    addresses = set(run_alone(_PORTS, **variables).split())
    assert addresses
    assert (addresses == {"0100007F"}) != opens  # 127.0.0.1


def test_the_open_profile_is_the_closed_one_without_its_white_list() -> None:
    closed, open_ = (ElementTree.fromstring(path.read_bytes()) for path in PROFILES)
    transport = closed.find(f".//{_FAST_DDS}interfaceWhiteList/..")
    assert transport is not None
    (listed,) = (child for child in transport if child.tag.endswith("interfaceWhiteList"))
    assert [address.text for address in listed] == ["127.0.0.1"]
    transport.remove(listed)
    assert [(e.tag, (e.text or "").strip()) for e in closed.iter()] == [
        (e.tag, (e.text or "").strip()) for e in open_.iter()
    ]


@pytest.mark.parametrize("own", [None, "mine.xml"])
def test_environment_comes_first(
    own: str | None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    name = "FASTRTPS_DEFAULT_PROFILES_FILE"
    monkeypatch.delenv(name, raising=False)
    if own is not None:
        monkeypatch.setenv(name, str(tmp_path / own))
    new_context().shutdown()
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "OFF"
    assert Path(os.environ[name]).name == (own or "fastdds.xml")


@pytest.mark.parametrize(
    ("words", "remapped"),
    [(["slam", "/a:=/b"], False), (["--ros-args", "-r", "/a:=/b"], True), (["slam"], False)],
)
def test_a_program_s_own_arguments_are_no_remappings(
    words: list[str],
    remapped: bool,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(sys, "argv", ["arjuna", *words])
    with discovery(isolated=True):
        context = new_context()
        node = rclpy.create_node("asked", context=context)
        assert node.resolve_topic_name("/a") == ("/b" if remapped else "/a")
        context.shutdown()
    assert "deprecated" not in capfd.readouterr().err


@pytest.mark.parametrize(
    ("before", "isolated", "within"),
    [(None, False, "LOCALHOST"), ("SUBNET", False, "SUBNET"), ("SUBNET", True, "OFF")],
)
def test_discovery_range_holds_for_what_is_made_within(
    before: str | None, isolated: bool, within: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = "ROS_AUTOMATIC_DISCOVERY_RANGE"
    monkeypatch.delenv(name, raising=False)
    if before:
        monkeypatch.setenv(name, before)
    with discovery(isolated):
        assert os.environ[name] == within
    assert os.environ.get(name) == before


def test_an_isolated_process_holds_no_port_of_the_domain(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "99")
    process = Process("alone", isolated=True)
    try:
        assert process.context.get_domain_id() != 99
        assert os.environ["ROS_DOMAIN_ID"] == "99"
    finally:
        process.close()


def test_a_collection_of_garbage_is_rare_and_still_comes() -> None:
    context = new_context(231)
    context.shutdown()
    assert gc.isenabled()
    assert gc.get_threshold()[0] >= 10_000


def test_interfaces_are_found_by_name() -> None:
    assert class_of("nav2_msgs/action/Wait") is Wait
    assert class_of("nav2_msgs/action/Wait_FeedbackMessage") is Wait.Impl.FeedbackMessage
    with pytest.raises(LookupError, match="is no type; valid: package/msg/Name"):
        class_of("nav2_msgs")
    with pytest.raises(LookupError, match="is not installed"):
        class_of("nav2_msgs/msg/None_")
