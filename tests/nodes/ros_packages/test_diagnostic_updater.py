"""diagnostic_updater: what a driver reports of itself."""

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
from sensor_msgs.msg import Imu

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
