"""`record` and `play` as a person runs them: real processes, real time, a kill."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import closing
from itertools import pairwise
from pathlib import Path

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Int32

from arjuna_core.bags.reader import Bag
from tests.helpers.processes import Lines, wait_until

pytestmark = [pytest.mark.ros, pytest.mark.system]
DOMAIN = "92"


class Counter:
    """Publishes 1, 2, 3 ..., one each time it is asked to."""

    def __init__(self) -> None:
        self._context = Context()
        self._open = True
        rclpy.init(context=self._context, domain_id=int(DOMAIN))
        self._node = Node("counter", context=self._context)
        self._publisher = self._node.create_publisher(Int32, "/count", QoSProfile(depth=100))
        self.last = 0

    def publish(self) -> None:
        self.last += 1
        self._publisher.publish(Int32(data=self.last))

    @property
    def received(self) -> bool:
        return bool(self._publisher.get_subscription_count())

    def close(self) -> None:
        if self._open:
            self._open = False
            self._node.destroy_node()
            self._context.shutdown()


@pytest.fixture
def counter(monkeypatch: pytest.MonkeyPatch) -> Iterator[Counter]:
    monkeypatch.setenv("ROS_DOMAIN_ID", DOMAIN)
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    with closing(Counter()) as counter:
        yield counter


def numbers(path: Path) -> list[int]:
    return [message.data[4] for message in Bag(path).messages()]


def _until(done: Callable[[], bool], what: str) -> None:
    """Wait until something is so, asking often."""
    pause = threading.Event()
    wait_until(done, lambda: pause.wait(0.02), what)


ARJUNA, ROS2_BAG = ("bringup",), ("bringup.ros2.main", "bag")
FOUND = {ARJUNA: "listens to /count", ROS2_BAG: "Subscribed to topic '/count'"}


def _record(folder: Path, program: tuple[str, ...] = ARJUNA) -> Lines:
    return Lines("-m", *program, "record", "--topics", "/count", "-o", str(folder))


def test_a_killed_recorder_loses_only_its_last_second(tmp_path: Path, counter: Counter) -> None:
    folder = tmp_path / "bag"
    with _record(folder) as recorder:
        recorder.wait_for("listens to /count")
        _until(lambda: counter.received, "matching")
        for _ in range(50):
            counter.publish()
        file = folder / "bag_0.mcap"
        _until(lambda: len(numbers(file)) >= 50, "the flush")
        recorder.process.kill()
        recorder.process.wait()
    assert numbers(folder) == list(range(1, 51))
    with Lines("-m", "bringup", "info", str(folder), "--repair") as info:
        assert info.read_to_end() == 0
    assert info.matching("without its index")
    assert numbers(tmp_path / "bag_repaired") == list(range(1, 51))
    assert not Bag(tmp_path / "bag_repaired").problems
    with _record(folder) as again:
        assert again.read_to_end() == 2
    assert again.matching("exists already and is not overwritten")


@pytest.mark.parametrize("program", [ARJUNA, ROS2_BAG], ids=["arjuna", "ros2 bag"])
def test_what_is_recorded_is_played_and_recorded_again(
    tmp_path: Path, counter: Counter, program: tuple[str, ...]
) -> None:
    with _record(tmp_path / "first", program) as recorder:
        recorder.wait_for(FOUND[program])
        _until(lambda: counter.received, "matching")
        for _ in range(20):
            counter.publish()
            threading.Event().wait(0.01)  # so that a turn of the loop lasts
        recorder.process.send_signal(signal.SIGINT)
        assert recorder.read_to_end() == 0
    assert recorder.matching("20 messages of 1 topics, none lost")
    counter.close()
    with (
        _record(tmp_path / "second", program) as second,
        Lines("-m", *program, "play", str(tmp_path / "first"), "--loop") as player,
    ):
        second.wait_for(FOUND[program])
        _until(lambda: len(numbers(tmp_path / "second")) > 40, "two turns")
        player.process.send_signal(signal.SIGINT)
        assert player.read_to_end() == 0
        second.process.send_signal(signal.SIGINT)
        assert second.read_to_end() == 0
    assert numbers(tmp_path / "first") == list(range(1, 21))
    played = numbers(tmp_path / "second")
    assert all(after == before % 20 + 1 for before, after in pairwise(played))
