"""The Python side of `ros2 node|param|service|topic`, as programs import it."""

from __future__ import annotations

import argparse
import os
import threading
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from rcl_interfaces.srv import GetParameters
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import ReliabilityPolicy
from ros2cli.node.direct import DirectNode
from ros2cli.node.strategy import NodeStrategy, add_arguments
from ros2node import api as nodes
from ros2param import api as parameters
from ros2service import api as services
from ros2topic import api as topics
from std_msgs.msg import String

pytestmark = pytest.mark.ros


@pytest.fixture
def graph(monkeypatch: pytest.MonkeyPatch) -> Iterator[DirectNode]:
    """A node that sees another one, which runs, in a domain where no test beside has a twin."""
    monkeypatch.setenv("ROS_DOMAIN_ID", str(10 + os.getpid() % 60))
    rclpy.init()
    other = Node("other", namespace="/ns")
    other.declare_parameter("speed", 0.5)
    other.create_publisher(String, "said", 1)
    executor = SingleThreadedExecutor()
    executor.add_node(other)
    stopped = threading.Event()

    def spin() -> None:
        while not stopped.is_set():
            try:
                executor.spin_once(0.05)
            except ExternalShutdownException:
                return

    thread = threading.Thread(target=spin)
    thread.start()
    try:
        with NodeStrategy(argparse.Namespace(spin_time=0.2)) as node:
            yield node
    finally:
        stopped.set()
        thread.join()
        other.destroy_node()
        rclpy.shutdown()


def test_nodes_and_what_they_offer(graph: DirectNode) -> None:
    names = nodes.get_node_names(node=graph)
    assert ("other", "/ns", "/ns/other") in names
    assert not any(name.name.startswith("_ros2cli") for name in names)
    hidden = nodes.get_node_names(node=graph, include_hidden_nodes=True)
    assert any(name.name.startswith("_ros2cli") for name in hidden)
    assert not nodes.has_duplicates(names)
    assert nodes.get_absolute_node_name("a") == "/a"
    of: dict[str, Any] = {"node": graph, "remote_node_name": "/ns/other"}
    assert ("/ns/said", ["std_msgs/msg/String"]) in nodes.get_publisher_info(**of)
    offered = [info.name for info in nodes.get_service_server_info(**of)]
    assert "/ns/other/get_parameters" in offered
    for ask in (nodes.get_action_server_info, nodes.get_action_client_info):
        assert ask(**of) == []


def test_topics_and_services_and_their_classes(graph: DirectNode) -> None:
    assert "/ns/said" in topics.get_topic_names(node=graph)
    assert topics.get_msg_class(graph, "/ns/said", blocking=True) is String
    assert topics.get_msg_class(graph, "/nobody") is None
    assert services.get_service_class(graph, "/ns/other/get_parameters") is GetParameters
    assert services.get_service_class(graph, "/nobody") is None
    assert "/ns/other/get_parameters" in services.get_service_names(node=graph)
    profile = topics.qos_profile_from_short_keys("default", reliability="best_effort", depth=3)
    assert (profile.reliability, profile.depth) == (ReliabilityPolicy.BEST_EFFORT, 3)


def test_parameters_of_another_node(graph: DirectNode) -> None:
    of: dict[str, Any] = {"node": graph, "node_name": "/ns/other"}
    value = parameters.get_parameter_value(string_value="0.7")
    one = Parameter("speed", value=parameters.get_value(parameter_value=value)).to_parameter_msg()
    answer = parameters.call_set_parameters(**of, parameters=[one])
    assert [result.successful for result in answer.results] == [True]
    answer = parameters.call_get_parameters(**of, parameter_names=["speed"])
    assert [parameters.get_value(parameter_value=each) for each in answer.values] == [0.7]
    assert "speed" in parameters.call_list_parameters(**of).result().result.names
    described = parameters.call_describe_parameters(**of, parameter_names=["speed"])
    assert [each.name for each in described.descriptors] == ["speed"]


def test_a_node_of_its_own_begins_and_ends_ros() -> None:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    with DirectNode(parser.parse_args(["--spin-time", "0.1"]), node_name="seen") as node:
        assert node.get_name() == "seen"
    assert not rclpy.ok()
