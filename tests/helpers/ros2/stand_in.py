"""A small robot for tests of the `ros2` command, in a process of its own: one of everything."""

from __future__ import annotations

import os
import sys
from typing import Any

from geometry_msgs.msg import PointStamped, TransformStamped, Twist
from nav2_msgs.action import Wait
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.action import ActionServer, GoalResponse
from rclpy.context import Context
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.lifecycle import LifecycleNode
from rclpy.parameter import Parameter
from service_msgs.msg import ServiceEventInfo
from std_msgs.msg import String
from std_srvs.srv import SetBool
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.context import new_context

REJECTED = 7  # a goal of so many seconds is rejected


class StandIn(LifecycleNode):
    """Publishes, listens, serves, acts and has parameters."""

    def __init__(self, context: Context) -> None:
        super().__init__("stand_in", context=context)
        self._chatter = self.create_publisher(String, "chatter", 10)
        self._point = self.create_publisher(PointStamped, "point", qos.SENSOR_SUBSCRIPTION)
        self._hidden = self.create_publisher(String, "_hidden", 10)
        self._latched = self.create_publisher(String, "latched", qos.LATCHED)
        self._latched.publish(String(data="kept"))
        self._tf = self.create_publisher(TFMessage, "/tf_static", qos.LATCHED)
        self._tf.publish(TFMessage(transforms=[_transform("map", "base", 1.0)]))
        self.create_subscription(Twist, "cmd_vel", lambda message: None, 10)
        self.create_service(SetBool, "toggle", _toggle)
        self._calls = self.create_publisher(SetBool.Event, "toggle/_service_event", 10)
        self._server = ActionServer(self, Wait, "wait", _wait, goal_callback=_admit)
        limits = FloatingPointRange(from_value=0.0, to_value=10.0)
        about = ParameterDescriptor(description="Factor.", floating_point_range=[limits])
        self.declare_parameter("gain", 2.5, about)
        self.declare_parameter("group.names", ["a", "b"])
        self.declare_parameter("size", 3, ParameterDescriptor(read_only=True))
        self.declare_parameter("unset", Parameter.Type.STRING)
        self.create_timer(0.05, self._tick)
        self._count = 0

    def _tick(self) -> None:
        self._count += 1
        self._chatter.publish(String(data=f"hello {self._count}"))
        message = PointStamped()
        message.header.stamp = self.get_clock().now().to_msg()
        message.header.frame_id = "map"
        self._point.publish(message)
        called = ServiceEventInfo(event_type=ServiceEventInfo.REQUEST_RECEIVED)
        self._calls.publish(SetBool.Event(info=called, request=[SetBool.Request(data=True)]))


def _transform(parent: str, child: str, x: float) -> TransformStamped:
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.transform.translation.x = x
    return message


def _toggle(request: Any, response: Any) -> Any:
    response.success = request.data
    response.message = "done"
    return response


def _admit(request: Any) -> GoalResponse:
    return GoalResponse.REJECT if request.time.sec == REJECTED else GoalResponse.ACCEPT


def _wait(handle: Any) -> Any:
    handle.publish_feedback(Wait.Feedback(time_left=handle.request.time))
    handle.succeed()
    return Wait.Result(total_elapsed_time=handle.request.time)


def main() -> None:
    """Run until the parent has gone."""
    context = new_context()  # announces itself as a robot does
    executor = EventsExecutor(context=context)
    executor.add_node(StandIn(context))
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    parent = os.getppid()
    while os.getppid() == parent:
        executor.spin_once(timeout_sec=0.05)


if __name__ == "__main__":
    main()
