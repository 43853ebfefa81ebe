"""Claims: turtlesim's topics, services and action do what programs of the tutorials ask of them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import closing
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Twist
from rclpy.action import ActionClient
from rclpy.parameter import Parameter
from std_srvs.srv import Empty
from turtlesim.action import RotateAbsolute
from turtlesim.msg import Color, Pose
from turtlesim.srv import Kill, SetPen, Spawn, TeleportAbsolute, TeleportRelative

from arjuna_core.ros import qos
from bringup.ros2.turtlesim.node import Turtlesim
from bringup.ros2.turtlesim.turtle import SIDE
from tests.helpers.ros import TICK, RosBench


@pytest.fixture
def ros() -> Iterator[RosBench]:
    with closing(RosBench(transport="dds")) as bench:
        node = bench.process.make_node("turtlesim")
        node.set_parameters([Parameter("use_sim_time", value=True)])
        bench.advance()
        Turtlesim(node)
        bench.advance(0.1)
        yield bench


def turned(ros: RosBench, theta: float) -> Any:
    """Return the handle of a goal of turtle1."""
    client = ActionClient(ros.node, RotateAbsolute, "turtle1/rotate_absolute")
    ros.until(client.server_is_ready, "a server of rotate_absolute")
    future = client.send_goal_async(RotateAbsolute.Goal(theta=theta))
    ros.until(future.done, "an answer to the goal")
    return future.result()


def ended(ros: RosBench, handle: Any) -> tuple[int, float]:
    """Return the status and the result of a goal that has ended."""
    future = handle.get_result_async()
    ros.until(future.done, "a result")
    return future.result().status, future.result().result.delta


def test_a_turtle_in_the_middle_drives_by_commands(ros: RosBench) -> None:
    poses = ros.collect(Pose, "turtle1/pose", qos.TF)
    ros.advance(0.1)
    assert (poses[-1].x, poses[-1].y, poses[-1].theta) == pytest.approx((SIDE / 2, SIDE / 2, 0.0))
    twist = Twist()
    twist.linear.x, twist.linear.y = 2.0, 2.0  # it is not holonomic unless it is told to be
    ros.publish(Twist, "turtle1/cmd_vel", twist)
    ros.advance(0.5)
    assert poses[-1].linear_velocity == 2.0
    ros.advance(1.5)
    driven = 2.0 * 0.016 / TICK  # for a second, a period at each tick of this clock
    assert (poses[-1].x, poses[-1].y) == pytest.approx((SIDE / 2 + driven, SIDE / 2), abs=0.1)
    assert poses[-1].linear_velocity == 0.0


def test_turtles_come_and_go(ros: RosBench) -> None:
    names = [
        ros.call(Spawn, "spawn", Spawn.Request(x=1.0, y=2.0, theta=0.5, name=name)).name
        for name in ("", "bob", "bob", "turtle1", "")
    ]
    assert names == ["turtle2", "bob", "", "", "turtle3"]
    poses = ros.collect(Pose, "bob/pose", qos.TF)
    ros.advance(0.1)
    assert (poses[-1].x, poses[-1].y, poses[-1].theta) == (1.0, 2.0, 0.5)
    ros.call(Kill, "kill", Kill.Request(name="bob"))
    ros.call(Kill, "kill", Kill.Request(name="nobody"))
    ros.advance(0.1)
    assert not ros.node.get_publishers_info_by_topic("bob/pose")
    ros.call(Empty, "reset", Empty.Request())
    ros.advance(0.1)
    assert not ros.node.get_publishers_info_by_topic("turtle2/pose")
    assert ros.call(Spawn, "spawn", Spawn.Request(x=1.0, y=2.0)).name == "turtle2"


def test_a_turtle_draws_and_sees_the_color_below(ros: RosBench) -> None:
    colors = ros.collect(Color, "turtle1/color_sensor", qos.TF)
    ros.call(SetPen, "turtle1/set_pen", SetPen.Request(r=9, g=8, b=7, width=4))
    ahead = TeleportRelative.Request(linear=2.0, angular=math.pi / 2.0)
    ros.call(TeleportRelative, "turtle1/teleport_relative", ahead)
    ros.advance(0.1)
    assert (colors[-1].r, colors[-1].g, colors[-1].b) == (9, 8, 7)
    ros.call(SetPen, "turtle1/set_pen", SetPen.Request(off=1))
    there = TeleportAbsolute.Request(x=1.0, y=1.0)
    ros.call(TeleportAbsolute, "turtle1/teleport_absolute", there)
    ros.advance(0.1)
    assert (colors[-1].r, colors[-1].g, colors[-1].b) == (69, 86, 255)
    ros.call(
        TeleportAbsolute, "turtle1/teleport_absolute", TeleportAbsolute.Request(x=SIDE / 2, y=7.0)
    )
    ros.call(Empty, "clear", Empty.Request())
    ros.advance(0.1)
    assert (colors[-1].r, colors[-1].g, colors[-1].b) == (69, 86, 255)


def test_a_turtle_turns_to_a_heading(ros: RosBench) -> None:
    handle = turned(ros, 1.0)
    ros.advance(2.0)
    status, delta = ended(ros, handle)
    assert status == GoalStatus.STATUS_SUCCEEDED
    assert delta == pytest.approx(-1.0, abs=0.02)
    first = turned(ros, -2.0)
    ros.advance(0.5)
    second = turned(ros, 2.0)
    assert ended(ros, first)[0] == GoalStatus.STATUS_ABORTED
    cancelled = second.cancel_goal_async()
    ros.until(cancelled.done, "an answer to the cancellation")
    ros.advance(0.1)
    assert ended(ros, second)[0] == GoalStatus.STATUS_CANCELED
