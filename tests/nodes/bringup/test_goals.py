"""Goals sent to a robot, and what is reported meanwhile."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import numba
import pytest
from nav2_msgs.action import NavigateToPose
from std_msgs.msg import String

from arjuna_core.ros import qos
from arjuna_core.ros.goal_server import GoalNode, GoalServer
from arjuna_core.se2 import SE2
from bringup.client.goals import Goals, chosen
from bringup.client.session import POLL, ClientError, Session
from bringup.processes.health import PATIENCE
from bringup.processes.output import read_event
from bringup.processes.reporter import Reporter
from tests.helpers.ros import RosBench


class Server(GoalNode):
    """Takes goals: `forgets` of them are lost, the next is reached after `takes` [s]."""

    DEFAULT_NAME = "server"
    forgets, takes, restarts_after, admits = 0, 0.0, 5.0, True

    def configure(self) -> None:
        self.taken, self._due, self._is_old = 0, 0.0, False
        self._serve()
        self.every(0.5, self._work)

    def _serve(self) -> None:
        self.server = self.keep(
            GoalServer(
                self,
                NavigateToPose,
                "navigate_to_pose",
                self._on_goal,
                admit=lambda goal: None if self.admits else "it is busy",
            )
        )

    def _on_goal(self) -> None:
        self.taken += 1
        self._due, self._is_old = self.now + self.takes, self.taken <= self.forgets
        self._due += self.restarts_after if self._is_old else 0.0

    def _work(self) -> None:
        if self.now < self._due:
            return
        if self._is_old:  # as a process that is started again: nobody knows the goal any more
            self._is_old = False
            self.server._server._goal_handles.clear()
            self.server._current = None
        elif self.server.goal is not None:
            self.server.succeed(NavigateToPose.Result())


class BenchSession(Session):
    """A session whose time the bench makes."""

    def __init__(self, bench: RosBench) -> None:
        self._bench = bench
        self.client = bench.node
        self.at: dict[float, Callable[[], Any]] = {}  # what happens at a time [s]

    @property
    def now(self) -> float:
        return self._bench.process.now

    def spin_once(self, timeout: float = POLL) -> None:
        self._bench.advance(0.1)
        for due in [due for due in self.at if due <= self.now]:
            self.at.pop(due)()


def _server(bench: RosBench, active: bool = True, **settings: Any) -> Server:
    node = Server(bench.process)
    for name, value in settings.items():
        setattr(node, name, value)
    node.trigger_configure()
    if active:
        node.trigger_activate()
    bench.process.drain()
    return node


@pytest.mark.parametrize(("timeout", "succeeds"), [(60.0, True), (15.0, False)])
def test_a_goal_that_is_lost_is_sent_again(bench: RosBench, timeout: float, succeeds: bool) -> None:
    node = _server(bench, forgets=2)
    end = Goals(BenchSession(bench)).navigate(SE2(1.0, 0.0), timeout)
    assert end.succeeded is succeeds
    assert node.taken == (3 if succeeds else 2)


def test_unanswered_goals_are_sent_once(bench: RosBench, capfd: pytest.CaptureFixture[str]) -> None:
    node = _server(bench, takes=45.0)
    end = Goals(BenchSession(bench)).navigate(SE2(1.0, 0.0), 90.0)
    assert (end.succeeded, node.taken) == (True, 1)
    assert capfd.readouterr().err.count("nothing is heard of it yet") == 1


def test_inactive_servers_are_awaited(bench: RosBench, capfd: pytest.CaptureFixture[str]) -> None:
    node = _server(bench, active=False)
    session = BenchSession(bench)
    session.at = {5.0: node.trigger_activate}
    end = Goals(session).navigate(SE2(1.0, 0.0), 90.0)
    assert (end.succeeded, node.taken) == (True, 1)
    assert 5.0 <= session.now < 8.0
    said = "'navigate_to_pose' is inactive: waiting until navigation is active"
    assert capfd.readouterr().err.count(said) == 1


def test_a_server_that_is_never_active_is_named(bench: RosBench) -> None:
    _server(bench, active=False)
    with pytest.raises(ClientError, match="'navigate_to_pose' is still inactive; 'doctor' says"):
        Goals(BenchSession(bench)).navigate(SE2(1.0, 0.0), 600.0)


def test_a_goal_that_an_active_server_refuses_has_failed(bench: RosBench) -> None:
    node = _server(bench, admits=False)
    end = Goals(BenchSession(bench)).navigate(SE2(1.0, 0.0), 60.0)
    assert (end.succeeded, end.refused, node.taken) == (False, True, 0)
    assert "refuses the goal: another goal runs" in end.reason


def test_a_controller_is_chosen_for_one_goal_alone(bench: RosBench) -> None:
    heard: list[str] = []
    bench.node.create_subscription(
        String, "controller_selector", lambda message: heard.append(message.data), qos.LATCHED
    )
    session = BenchSession(bench)
    with chosen(session, "controller", None):
        pass
    assert heard == []
    with suppress(KeyboardInterrupt), chosen(session, "controller", "Crawl"):
        assert heard == ["Crawl"]
        raise KeyboardInterrupt
    assert heard == ["Crawl", ""]


def test_a_controller_that_nobody_takes_is_not_waited_for_without_end(bench: RosBench) -> None:
    with (
        pytest.raises(ClientError, match="somebody who listens on 'controller_selector' did not"),
        chosen(BenchSession(bench), "controller", "Crawl", timeout=2.0),
    ):
        pass


@pytest.fixture
def lines() -> list[str]:
    return []


@pytest.fixture
def reporter(lines: list[str]) -> Iterator[Reporter]:
    bench = RosBench()
    yield Reporter(bench.process, [], lines.append)
    bench.close()


def patience(lines: list[str]) -> list[float]:
    """Return within what times the next signs of life were announced [s]."""
    events = [read_event(line) or {} for line in lines]
    return [event["alive"] for event in events if "alive" in event]


def compile_again() -> None:
    """Let Numba compile a function that it has not seen."""
    compiled: Any = numba.njit(lambda: 0)
    compiled()


def test_a_compilation_is_announced_and_ended(reporter: Reporter, lines: list[str]) -> None:
    reporter.update(1.0)
    compile_again()
    assert max(patience(lines)) == 90.0
    reporter.update(1.2)
    assert patience(lines)[-1] == PATIENCE == 6.0  # as SECURITY.md promises
    reporter.close()


def test_nothing_is_said_after_the_end(reporter: Reporter, lines: list[str]) -> None:
    reporter.close()
    compile_again()
    assert not lines
