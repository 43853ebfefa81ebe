"""The client's goals: one whose server died without a word is sent again."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from nav2_msgs.action import NavigateToPose

from arjuna_core.ros.goal_node import GoalNode
from arjuna_core.ros.goal_server import GoalServer
from arjuna_core.se2 import SE2
from bringup.client.goals import Goals
from tests.helpers.ros import RosBench

pytestmark = pytest.mark.ros


@dataclass(frozen=True)
class NoConfig:
    """No parameters."""


class Forgetful(GoalNode):
    """Takes goals, says nothing of the first `forgets` ones, and refuses some after that."""

    Config = NoConfig
    DEFAULT_NAME = "forgetful"
    forgets = 2

    def configure(self) -> None:
        self.taken = 0
        self.server = self.keep(GoalServer(self, NavigateToPose, "navigate_to_pose", self._on_goal))

    def _on_goal(self) -> None:
        self.taken += 1
        if self.server.preempt_requested:
            self.server.accept_pending()
        if self.taken > self.forgets:
            self.server.succeed(NavigateToPose.Result())


class BenchSession:
    """A session whose time the bench makes."""

    def __init__(self, bench: RosBench) -> None:
        self._bench = bench
        self.client = bench.node

    @property
    def now(self) -> float:
        return self._bench.process.now

    def run_until(
        self, done: Callable[[], bool], timeout: float, what: str = "", required: bool = True
    ) -> bool:
        deadline = self.now + timeout
        while not done():
            if self.now >= deadline:
                return False
            self._bench.advance(0.1)
        return True

    def call(self, service_type: Any, name: str, request: Any, timeout: float = 5.0) -> Any:
        return self._bench.call(service_type, name, request)


@pytest.fixture
def bench() -> Iterator[RosBench]:
    bench = RosBench()
    yield bench
    bench.close()


@pytest.mark.parametrize(("timeout", "succeeds"), [(60.0, True), (15.0, False)])
def test_a_goal_of_which_nothing_is_heard_is_sent_again(
    bench: RosBench, timeout: float, succeeds: bool
) -> None:
    node = Forgetful(bench.process)
    node.trigger_configure()
    node.trigger_activate()
    bench.process.drain()
    end = Goals(BenchSession(bench)).navigate(SE2(1.0, 0.0), timeout)
    assert end.succeeded is succeeds
    assert node.taken == (3 if succeeds else 2)
