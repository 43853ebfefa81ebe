"""Messages, services and actions of every package go through the real middleware."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

pytestmark = pytest.mark.ros

LIMIT = 60.0  # [s] for one round trip


class Bench:
    """A node under an EventsExecutor that is spun until something holds."""

    def __init__(self) -> None:
        from rclpy.context import Context
        from rclpy.experimental.events_executor import EventsExecutor
        from rclpy.node import Node

        self.context = Context()
        self.context.init(domain_id=int(os.environ.get("ROS_DOMAIN_ID", "77")))
        self.node = Node("interfaces", context=self.context, start_parameter_services=False)
        self.executor = EventsExecutor(context=self.context)
        self.executor.add_node(self.node)

    def spin_until(self, holds: Callable[[], Any], what: str) -> None:
        """Spin until a condition holds.

        Raises:
            TimeoutError: it does not hold within LIMIT.
        """
        deadline = time.monotonic() + LIMIT
        while not holds():
            if time.monotonic() > deadline:
                raise TimeoutError(f"no {what} within {LIMIT} s")
            self.executor.spin_once(timeout_sec=0.05)

    def result(self, future: Any, what: str) -> Any:
        """Spin until a future is done and return its result."""
        self.spin_until(future.done, what)
        return future.result()

    def close(self) -> None:
        """Destroy the node and its context."""
        self.node.destroy_node()
        self.executor.shutdown()
        self.context.shutdown()


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    bench = Bench()
    yield bench
    bench.close()


def messages() -> list[Any]:
    """Return one filled message a package that has messages."""
    from arjuna_interfaces.msg import LocalizationQuality
    from bond.msg import Status
    from geographic_msgs.msg import GeoPath, GeoPoint, GeoPose, GeoPoseStamped
    from geometry_msgs.msg import Point, Pose, Transform, TransformStamped, Vector3
    from map_msgs.msg import OccupancyGridUpdate
    from nav2_msgs.msg import Particle, ParticleCloud
    from simulation_interfaces.msg import SimulatorFeatures
    from tf2_msgs.msg import TFMessage

    point = GeoPoseStamped(pose=GeoPose(position=GeoPoint(latitude=48.1, longitude=11.6)))
    transform = TransformStamped(
        child_frame_id="odom", transform=Transform(translation=Vector3(x=1.5))
    )
    return [
        LocalizationQuality(quality=0.5, reason="scan disagrees"),
        Status(id="bond", instance_id="a", active=True, heartbeat_timeout=4.0),
        GeoPath(poses=[point, point]),
        OccupancyGridUpdate(x=3, y=4, width=2, height=1, data=[100, -1]),
        ParticleCloud(particles=[Particle(pose=Pose(position=Point(x=2.0)), weight=0.25)] * 3),
        SimulatorFeatures(
            features=[SimulatorFeatures.SPAWNING, SimulatorFeatures.SIMULATION_RESET],
            spawn_formats=["urdf"],
        ),
        TFMessage(transforms=[transform]),
    ]


def requests() -> list[tuple[Any, Any, Any]]:
    """Return one service with request and response a package that has services."""
    from geographic_msgs.srv import GetGeoPath
    from map_msgs.srv import GetMapROI
    from nav2_msgs.srv import ManageLifecycleNodes
    from simulation_interfaces.msg import Result
    from simulation_interfaces.srv import SpawnEntity
    from slam_toolbox.srv import SerializePoseGraph
    from tf2_msgs.srv import FrameGraph

    startup = ManageLifecycleNodes.Request(command=ManageLifecycleNodes.Request.STARTUP)
    spawned = SpawnEntity.Response(result=Result(result=Result.RESULT_OK), entity_name="box_1")
    return [
        (GetGeoPath, GetGeoPath.Request(), GetGeoPath.Response(success=True, distance=12.5)),
        (GetMapROI, GetMapROI.Request(l_x=2.0), GetMapROI.Response()),
        (ManageLifecycleNodes, startup, ManageLifecycleNodes.Response(success=True)),
        (SpawnEntity, SpawnEntity.Request(name="box", allow_renaming=True), spawned),
        (
            SerializePoseGraph,
            SerializePoseGraph.Request(filename="office"),
            SerializePoseGraph.Response(result=255),
        ),
        (FrameGraph, FrameGraph.Request(), FrameGraph.Response(frame_yaml="odom: {}")),
    ]


def goals() -> list[tuple[Any, Any, Any, Any]]:
    """Return one action with goal, feedback and result a package that has actions."""
    from nav2_msgs.action import NavigateToPose
    from simulation_interfaces.action import SimulateSteps
    from simulation_interfaces.msg import Result
    from tf2_msgs.action import LookupTransform
    from tf2_msgs.msg import TF2Error

    error = TF2Error(error=TF2Error.LOOKUP_ERROR, error_string="no such frame")
    return [
        (
            NavigateToPose,
            NavigateToPose.Goal(behavior_tree="tree.xml"),
            NavigateToPose.Feedback(distance_remaining=1.5, number_of_recoveries=2),
            NavigateToPose.Result(error_code=204, error_msg="outside the map"),
        ),
        (
            SimulateSteps,
            SimulateSteps.Goal(steps=7),
            SimulateSteps.Feedback(completed_steps=3, remaining_steps=4),
            SimulateSteps.Result(result=Result(result=Result.RESULT_OK)),
        ),
        (
            LookupTransform,
            LookupTransform.Goal(target_frame="map"),
            LookupTransform.Feedback(),
            LookupTransform.Result(error=error),
        ),
    ]


def test_message_of_every_package_arrives_as_it_was_sent(bench: Bench) -> None:
    for number, message in enumerate(messages()):
        received: list[Any] = []
        topic = f"topic_{number}"
        publisher = bench.node.create_publisher(type(message), topic, 10)
        bench.node.create_subscription(type(message), topic, received.append, 10)
        bench.spin_until(publisher.get_subscription_count, f"match on {type(message)}")
        publisher.publish(message)
        bench.spin_until(lambda: received, f"{type(message)}")  # noqa: B023 - spun here
        assert received == [message]


def test_service_of_every_package_answers(bench: Bench) -> None:
    for number, (service, request, response) in enumerate(requests()):
        asked: list[Any] = []

        def answer(request: Any, _: Any, asked: list[Any] = asked, response: Any = response) -> Any:
            asked.append(request)
            return response

        name = f"service_{number}"
        bench.node.create_service(service, name, answer)
        client = bench.node.create_client(service, name)
        bench.spin_until(client.service_is_ready, f"server of {service}")
        assert bench.result(client.call_async(request), f"answer of {service}") == response
        assert asked == [request]


def test_action_of_every_package_runs_to_its_result(bench: Bench) -> None:
    from action_msgs.msg import GoalStatus
    from rclpy.action import ActionClient, ActionServer

    for number, (action, goal, feedback, result) in enumerate(goals()):
        asked: list[Any] = []

        def execute(
            handle: Any, asked: list[Any] = asked, feedback: Any = feedback, result: Any = result
        ) -> Any:
            asked.append(handle.request)
            handle.publish_feedback(feedback)
            handle.succeed()
            return result

        received: list[Any] = []
        name = f"action_{number}"
        server = ActionServer(bench.node, action, name, execute)
        client = ActionClient(bench.node, action, name)
        bench.spin_until(client.server_is_ready, f"server of {action}")
        handle = bench.result(
            client.send_goal_async(goal, feedback_callback=received.append),
            f"acceptance by {action}",
        )
        assert handle.accepted
        answer = bench.result(handle.get_result_async(), f"result of {action}")
        assert answer.status == GoalStatus.STATUS_SUCCEEDED
        assert answer.result == result
        assert asked == [goal]
        bench.spin_until(lambda: received, f"feedback of {action}")  # noqa: B023 - spun here
        assert received[0].feedback == feedback
        client.destroy()
        server.destroy()
