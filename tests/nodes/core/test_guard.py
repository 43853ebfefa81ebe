"""Claims: what a callback raises ends there: logged, counted, answered; the node keeps running."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from lifecycle_msgs.srv import ChangeState, GetState
from nav2_msgs.action import Wait
from rcl_interfaces.msg import Parameter as ParameterMsg
from rcl_interfaces.srv import SetParameters
from simulation_interfaces.srv import ResetSimulation
from std_msgs.msg import Float64
from std_srvs.srv import SetBool

from arjuna_core.config import param
from arjuna_core.ros import qos
from arjuna_core.ros.goal_client import GoalClient, GoalOutcome
from arjuna_core.ros.goal_server import GoalNode, GoalServer
from tests.helpers.ros import RosBench

CLIENT_SENDS = (0, 2, 9, 42, 255)  # transitions that are unknown, or not allowed now


@dataclass(frozen=True)
class FragileConfig:
    """Parameters of the node under test."""

    limit: float = param(10.0, "Greatest value that it takes.", minimum=0.0, maximum=100.0)


class FragileNode(GoalNode):
    """Raises wherever it is asked to."""

    Config = FragileConfig
    DEFAULT_NAME = "fragile"
    broken = ""  # where it raises

    def _break(self, step: str) -> None:
        if self.broken == step:
            raise ZeroDivisionError(f"in {step}")

    def configure(self) -> None:
        self._break("configure")
        self.received: list[float] = []
        self.ticks = 0
        self.subscribe(Float64, "in", self._on_value, qos.DEFAULT)
        self.every(0.1, self._tick)
        self.serve(SetBool, "set", self._on_set)
        self.serve(ResetSimulation, "reset", self._on_set)
        self.server = self.keep(
            GoalServer(
                self,
                Wait,
                "wait",
                lambda: self._break("on_goal"),
                lambda goal: self._break("admit"),
                lambda: self._break("on_cancel"),
            )
        )

    def activate(self) -> None:
        self._break("activate")

    def on_config(self, config: Any) -> None:
        self._break("on_config")

    def on_time_jump(self) -> None:
        self._break("on_time_jump")

    def _on_value(self, message: Any) -> None:
        self.received.append(1.0 / message.data)

    def _on_set(self, request: Any, response: Any) -> Any:
        self._break("set")
        if isinstance(response, SetBool.Response):
            response.success = True
        return response

    def _tick(self) -> None:
        self.ticks += 1
        self._break("tick")


BENCH = {"strict": False}


NODE = FragileNode


def counts(bench: RosBench) -> dict[str, int]:
    """Return how often each source went wrong."""
    return {source: tally.count for (_, source), tally in bench.process.guard.tallies.items()}


def test_a_message_that_breaks_a_callback_is_dropped(bench: RosBench, node: FragileNode) -> None:
    for value in (0.0, 0.0, 2.0):
        bench.publish(Float64, "in", Float64(data=value))
    assert node.received == [0.5]
    assert counts(bench) == {"in": 2}


def test_ctrl_c_that_a_kernel_turns_into_another_error_is_ctrl_c(
    bench: RosBench, node: FragileNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The demo went on, its Ctrl-C counted as a failed callback."""

    def interrupted(step: str) -> None:
        raise SystemError("returned a result with an exception set") from KeyboardInterrupt()

    monkeypatch.setattr(node, "_break", interrupted)
    with pytest.raises(KeyboardInterrupt, match=r"^$"):
        bench.advance(0.2)
    assert counts(bench) == {}


def test_a_broken_service_answers_that_it_failed(bench: RosBench, node: FragileNode) -> None:
    node.broken = "set"
    answer = bench.call(SetBool, "set", SetBool.Request())
    assert not answer.success
    assert answer.message == "ZeroDivisionError: in set"
    reset = bench.call(ResetSimulation, "reset", ResetSimulation.Request()).result
    assert (reset.result, reset.error_message) == (4, "ZeroDivisionError: in set")
    node.broken = ""
    assert bench.call(SetBool, "set", SetBool.Request()).success


@pytest.mark.parametrize("transition", CLIENT_SENDS)
def test_forbidden_transitions_fail(bench: RosBench, node: FragileNode, transition: int) -> None:
    request = ChangeState.Request()
    request.transition.id = transition
    assert not bench.call(ChangeState, "fragile/change_state", request).success
    assert bench.call(GetState, "fragile/get_state", GetState.Request()).current_state.id == 3


@pytest.mark.parametrize("label", ["", "configure", "activate"])
@pytest.mark.parametrize("transition", [1, 3])  # as of a client that brings it up
def test_a_transition_to_where_it_is_succeeds(
    bench: RosBench, node: FragileNode, transition: int, label: str
) -> None:
    request = ChangeState.Request()
    request.transition.id, request.transition.label = transition, label
    assert bench.call(ChangeState, "fragile/change_state", request).success
    assert not bench.process.guard.tallies


def test_a_refused_value_keeps_the_one_before(bench: RosBench, node: FragileNode) -> None:
    node.broken = "on_config"
    request = SetParameters.Request(parameters=[ParameterMsg(name="limit")])
    request.parameters[0].value.type = 3
    request.parameters[0].value.double_value = 5.0
    answer = bench.call(SetParameters, "fragile/set_parameters", request)
    assert not answer.results[0].successful
    assert node.config.limit == node.get_parameter("limit").value == 10.0


def test_a_task_that_raises_ends_goals_and_reruns(bench: RosBench, node: FragileNode) -> None:
    outcomes = sent(bench, node)
    node.broken = "tick"
    bench.advance(0.3)
    assert outcomes[0].status == GoalStatus.STATUS_ABORTED
    assert "ZeroDivisionError: in tick" in str(outcomes[0].result)
    before, node.broken = node.ticks, ""
    bench.advance(0.3)
    assert node.ticks == before + 3
    assert node.state_label == "active"


def sent(bench: RosBench, node: FragileNode) -> list[GoalOutcome]:
    """Send a goal and return where its outcome comes."""
    outcomes: list[GoalOutcome] = []
    client = GoalClient(node, Wait, "wait")
    bench.process.drain()
    client.send(Wait.Goal(), outcomes.append)
    bench.process.drain()
    if node.broken == "on_cancel":
        client.cancel()
        bench.process.drain()
    return outcomes


@pytest.mark.parametrize("step", ["admit", "on_goal", "on_cancel"])
def test_a_goal_that_breaks_its_server_ends(bench: RosBench, node: FragileNode, step: str) -> None:
    node.broken = step
    (outcome,) = sent(bench, node)
    assert not outcome.succeeded
    node.broken = ""
    assert sent(bench, node) == []
    assert node.server.goal is not None


@pytest.mark.parametrize(("step", "state"), [("configure", 1), ("activate", 1)])
def test_a_raising_transition_unconfigures(bench: RosBench, step: str, state: int) -> None:
    node = FragileNode(bench.process)
    node.broken = step
    node.trigger_configure()
    node.trigger_activate() if step == "activate" else None
    assert node.state_label == "unconfigured"
    assert counts(bench) == {step: 1}
    node.broken = ""
    node.trigger_configure()
    node.trigger_activate()
    assert node.active


def test_a_clock_set_back_reaches_every_node(bench: RosBench, node: FragileNode) -> None:
    other = FragileNode(bench.process, name="other")
    bench.advance(1.0)
    node.broken = "on_time_jump"
    bench.set_back()
    assert bench.process.now == pytest.approx(0.02)
    assert other.get_clock().now().nanoseconds == 20_000_000


def test_a_task_of_rclpy_that_raises_is_counted(bench: RosBench) -> None:
    bench.process.executor.create_task(lambda: 1 / 0)
    bench.process.drain()
    assert counts(bench) == {"executor": 1}


def test_what_goes_wrong_again_is_logged_once_a_minute(
    bench: RosBench, node: FragileNode, capfd: pytest.CaptureFixture[str]
) -> None:
    node.broken = "tick"
    bench.advance(90.0)
    logged = [line for line in capfd.readouterr().err.splitlines() if "tick failed" in line]
    assert len(logged) == 2
    assert counts(bench)["tick"] > 800


def test_tests_see_what_a_callback_raises() -> None:
    bench = RosBench()
    try:
        bench.process.executor.create_task(lambda: 1 / 0)
        with pytest.raises(ZeroDivisionError, match="division"):
            bench.process.drain()
    finally:
        bench.close()
