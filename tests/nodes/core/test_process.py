"""Process: what is due runs behind the messages that were queued before it."""

from __future__ import annotations

import os
from typing import Any

import pytest
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from arjuna_core.errors import ConfigError
from arjuna_core.ros import qos
from arjuna_core.ros.convert import time_msg, transform_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.process import Process, Transport
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


def test_an_absolute_name_is_below_the_robots_namespace() -> None:
    process = Process("host", isolated=True, namespace="/robot1/")
    try:
        node = WatchNode(process, name="watch", namespace="costmap")
        assert process.absolute("/tf") == "/robot1/tf"
        assert process.absolute("scan") == "scan"
        assert process.absolute("/robot1/scan") == "/robot1/scan"
        assert process.absolute("/robot10/scan") == "/robot1/robot10/scan"
        assert process.find("costmap/watch") is node
        assert node.publisher(Clock, "/time", qos.LATEST).topic_name == "/robot1/time"
        assert node.publisher(Clock, "time", qos.LATEST).topic_name == "/robot1/costmap/time"
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
