"""ManagedNode, Process, goal servers and clients, parameter binding, transforms."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Twist
from lifecycle_msgs.msg import TransitionEvent
from lifecycle_msgs.srv import GetState
from nav2_msgs.action import Wait
from rcl_interfaces.srv import SetParameters
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from arjuna_core.errors import ConfigError
from arjuna_core.ros import qos
from arjuna_core.ros.goal_client import GoalClient, GoalOutcome
from arjuna_core.ros.local.actions import action_client
from arjuna_core.ros.process import Process
from tests.helpers.echo import EchoNode
from tests.helpers.ros import RosBench


@pytest.fixture(params=["local", "dds"])
def bench(request: pytest.FixtureRequest) -> Iterator[RosBench]:
    bench = RosBench(transport=request.param)
    yield bench
    bench.close()


NODE = EchoNode


def speeds(messages: list[Any]) -> list[float]:
    return [message.linear.x for message in messages]


def twist(speed: float) -> Twist:
    message = Twist()
    message.linear.x = speed
    return message


def test_delivers_only_while_active(bench: RosBench, node: EchoNode) -> None:
    received = bench.collect(Twist, "out")
    bench.publish(Twist, "in", twist(1.0))
    node.trigger_deactivate()
    bench.publish(Twist, "in", twist(2.0))
    node.trigger_activate()
    bench.publish(Twist, "in", twist(3.0))
    assert speeds(received) == [2.0, 6.0]


def test_periodic_tasks_follow_ros_time(bench: RosBench, node: EchoNode) -> None:
    bench.advance(0.5)
    assert node.ticks[-1] == pytest.approx(0.5)
    assert len(node.ticks) == 6  # the phase's first instant and one each 0.1 s
    assert node.get_clock().now().nanoseconds == 500_000_000


def test_lifecycle_can_be_run_through_twice(bench: RosBench, node: EchoNode) -> None:
    for step in ("deactivate", "cleanup", "configure", "activate"):
        getattr(node, f"trigger_{step}")()
        bench.process.drain()
    received = bench.collect(Twist, "out")
    bench.publish(Twist, "in", twist(1.0))
    assert speeds(received) == [2.0]
    state = bench.call(GetState, "echo/get_state", GetState.Request())
    assert state.current_state.label == "active"


def test_transitions_are_published(bench: RosBench, node: EchoNode) -> None:
    received = bench.collect(TransitionEvent, "echo/transition_event")
    node.trigger_deactivate()
    bench.process.drain()
    labels = [(each.start_state.label, each.goal_state.label) for each in received]
    assert labels == [("active", "deactivating"), ("deactivating", "inactive")]


def test_a_topic_s_name_that_is_none_is_named(
    bench: RosBench, capfd: pytest.CaptureFixture[str]
) -> None:
    class Loud(EchoNode):
        def configure(self) -> None:
            self.publisher(Twist, "3d-scan", qos.DEFAULT)

    node = Loud(bench.process, {}, name="loud")
    assert node.trigger_configure() == TransitionCallbackReturn.FAILURE
    assert "Invalid topic name" in (said := capfd.readouterr().err)
    assert "'3d-scan'" in said


def set_one(bench: RosBench, name: str, value: Any) -> Any:
    """Set one of the node's parameters; return the result."""
    request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
    return bench.call(SetParameters, "echo/set_parameters", request).results[0]


def test_parameters_change_at_run_time_within_bounds(bench: RosBench, node: EchoNode) -> None:
    assert set_one(bench, "gain", 5.0).successful
    assert node.config.gain == 5.0
    refused = set_one(bench, "gain", 50.0)
    assert not refused.successful
    assert node.config.gain == 5.0


def test_what_is_no_list_is_refused_for_a_list(bench: RosBench, node: EchoNode) -> None:
    assert set_one(bench, "others", ["x", "y"]).successful
    assert node.config.others == ("x", "y")
    for value in (1.5, True, "xyz"):
        assert "must be a list" in set_one(bench, "others", value).reason
    assert node.config.others == ("x", "y")


def test_whose_time_it_is_stays_as_it_was_at_the_start(bench: RosBench, node: EchoNode) -> None:
    same, other = (Parameter("use_sim_time", value=value) for value in (True, False))
    heard = len(list(node.subscriptions))
    (kept,), (refused,) = node.set_parameters([same]), node.set_parameters([other])
    assert (kept.successful, refused.successful) == (True, False)
    assert refused.reason.startswith("use_sim_time is true for all nodes of this process")
    node.set_parameters([same])
    assert len(list(node.subscriptions)) == heard
    bench.advance(0.5)
    assert node.get_clock().now().nanoseconds == 500_000_000


def test_unknown_parameter_names_the_nearest(bench: RosBench) -> None:
    with pytest.raises(ConfigError, match="unknown parameter 'gian'; did you mean 'gain'"):
        EchoNode(bench.process, {"gian": 1.0})


class Client:
    """Sends Wait goals from a node of its own and keeps what comes back."""

    def __init__(self, bench: RosBench, node: EchoNode) -> None:
        self.bench = bench
        self.client = GoalClient(node, Wait, "wait")
        bench.process.drain()
        self.outcomes: list[GoalOutcome] = []

    def send(self) -> None:
        self.client.send(Wait.Goal(), self.outcomes.append)
        self.bench.process.drain()


def test_a_goal_runs_until_the_node_ends_it(bench: RosBench, node: EchoNode) -> None:
    client = Client(bench, node)
    client.send()
    assert node.server.goal is not None
    assert client.outcomes == []
    node.server.succeed(Wait.Result())
    bench.process.drain()
    assert client.outcomes[0].succeeded


def test_cancel_reaches_the_server_and_ends_cancelled(bench: RosBench, node: EchoNode) -> None:
    client = Client(bench, node)
    client.send()
    client.client.cancel()
    bench.process.drain()
    assert node.server.cancel_requested
    node.server.cancel(Wait.Result())
    bench.process.drain()
    assert client.outcomes[0].status == GoalStatus.STATUS_CANCELED


def test_a_newer_goal_preempts(bench: RosBench, node: EchoNode) -> None:
    first, second = Client(bench, node), Client(bench, node)
    first.send()
    second.send()
    assert node.server.preempt_requested
    node.server.accept_pending()
    bench.process.drain()
    assert first.outcomes[0].status == GoalStatus.STATUS_ABORTED
    node.server.succeed(Wait.Result())
    bench.process.drain()
    assert second.outcomes[0].succeeded


def test_a_goal_that_waits_is_cancelled_alone(bench: RosBench, node: EchoNode) -> None:
    first, second = Client(bench, node), Client(bench, node)
    first.send()
    second.send()
    second.client.cancel()
    bench.process.drain()
    assert second.outcomes[0].status == GoalStatus.STATUS_CANCELED
    assert node.server.goal is not None
    assert not node.server.cancel_requested
    node.server.succeed(Wait.Result())
    bench.process.drain()
    assert first.outcomes[0].succeeded


def test_cancelling_ends_a_goal_that_was_not_replaced(bench: RosBench, node: EchoNode) -> None:
    client = Client(bench, node)
    client.send()
    client.send()
    node.server.abort_pending(Wait.Result())
    bench.process.drain()
    assert not node.server.cancel_requested
    client.client.cancel_replaced()
    bench.process.drain()
    assert node.server.cancel_requested


def test_a_goal_that_yields_never_replaces_another(bench: RosBench, node: EchoNode) -> None:
    first, second = Client(bench, node), Client(bench, node)
    first.send()
    second.client.send(Wait.Goal(), second.outcomes.append, yields=True)
    bench.process.drain()
    assert second.outcomes[0].status == GoalStatus.STATUS_ABORTED
    assert not node.server.preempt_requested
    node.server.succeed(Wait.Result())
    bench.process.drain()
    assert first.outcomes[0].succeeded


def test_of_many_goals_at_once_each_gets_a_result(bench: RosBench, node: EchoNode) -> None:
    deep = {f"{k}_service_qos_profile": qos.SERVICES for k in ("goal", "result", "cancel")}
    client = action_client(bench.node, Wait, "wait", **deep)
    bench.process.drain()
    sent = [client.send_goal_async(Wait.Goal()) for _ in range(100)]
    bench.process.drain()
    results = [each.result().get_result_async() for each in sent]
    bench.process.drain()
    node.server.abort_all()
    bench.process.drain()
    assert [each.result().status for each in results] == [GoalStatus.STATUS_ABORTED] * 100


def test_old_results_are_forgotten_where_time_stands_still(bench: RosBench, node: EchoNode) -> None:
    client = Client(bench, node)
    for _ in range(30):
        client.send()
        node.server.succeed(Wait.Result())
        bench.advance(1.0)
    assert len(client.outcomes) == 30
    assert len(node.server._server._goal_handles) < 25


def test_an_inactive_node_rejects_goals(bench: RosBench, node: EchoNode) -> None:
    client = Client(bench, node)
    node.trigger_deactivate()
    client.send()
    assert not client.outcomes[0].accepted


def test_a_goal_s_result_outlives_its_node(bench: RosBench, node: EchoNode) -> None:
    other = EchoNode(bench.process, name="other")
    client = Client(bench, other)
    client.send()
    node.server.abort_all("the end")
    node.trigger_shutdown()
    bench.process.drain()
    assert client.outcomes[0].status == GoalStatus.STATUS_ABORTED
    result: Any = client.outcomes[0].result
    assert result.error_msg == "the end at 0.00 s"


def test_a_node_that_a_client_has_shut_down_can_be_ended(bench: RosBench, node: EchoNode) -> None:
    for _ in range(2):
        assert node.trigger_shutdown() == TransitionCallbackReturn.SUCCESS
        assert node.state_label == "finalized"


def test_a_client_may_go_while_answers_are_coming(bench: RosBench, node: EchoNode) -> None:
    for step in ("nothing", "cancel", "succeed"):
        client = Client(bench, EchoNode(bench.process, name=step))
        client.send()
        if step == "cancel":
            client.client.cancel()
        if step == "succeed":
            node.server.succeed(Wait.Result())
        client.client.destroy()
        bench.process.drain()
        assert client.outcomes == []
        node.server.abort_all()
        bench.process.drain()


def test_a_waiting_request_is_answered_by_a_leaving_node(bench: RosBench, node: EchoNode) -> None:
    node.serve(Trigger, "ask", lambda request, response: Trigger.Response(message="yes"))
    client = bench.node.create_client(Trigger, "ask")
    bench.process.drain()
    future = client.call_async(Trigger.Request())
    node.trigger_shutdown()
    bench.process.drain()
    assert future.result().message == "yes"
    assert not client.service_is_ready()


def test_a_process_s_own_node_answers_for_its_parameters(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    process = Process("some_host", use_sim_time=False)
    names = [service.srv_name for service in process.node.services]
    process.close()
    assert "some_host/list_parameters" in names
