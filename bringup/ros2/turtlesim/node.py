"""`ros2 run turtlesim turtlesim_node`, `mimic`: what turtlesim offers to other nodes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Twist
from rcl_interfaces.msg import IntegerRange, ParameterDescriptor
from rclpy.action import CancelResponse
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Empty
from turtlesim.action import RotateAbsolute
from turtlesim.msg import Color, Pose
from turtlesim.srv import Kill, SetPen, Spawn, TeleportAbsolute, TeleportRelative

from arjuna_core.ros.actions import DeferredActionServer
from bringup.ros2.client import Client
from bringup.ros2.turtlesim.turtle import SIDE, Pen, Sheet, Turtle
from bringup.ros2.turtlesim.window import Window

_PERIOD = 0.016  # [s], as the original's
_BACKGROUND = {"background_r": 69, "background_g": 86, "background_b": 255}
_DEPTH, _RESULT_TIMEOUT = 10, 900.0  # [s], rcl's


class _TurtleOfNode:
    """A turtle with its topics, services and action."""

    def __init__(self, node: Node, name: str, turtle: Turtle, sheet: Sheet) -> None:
        self._node, self._sheet, self.turtle = node, sheet, turtle
        self._goal: Any = None
        self._start = 0.0
        self._pose = node.create_publisher(Pose, f"{name}/pose", _DEPTH)
        self._color = node.create_publisher(Color, f"{name}/color_sensor", _DEPTH)
        self._command = node.create_subscription(Twist, f"{name}/cmd_vel", self._commanded, _DEPTH)
        self._services = [
            node.create_service(kind, f"{name}/{service}", answer)
            for kind, service, answer in (
                (SetPen, "set_pen", self._set_pen),
                (TeleportAbsolute, "teleport_absolute", self._teleport),
                (TeleportRelative, "teleport_relative", self._teleport_ahead),
            )
        ]
        self._action = DeferredActionServer(
            node,
            RotateAbsolute,
            f"{name}/rotate_absolute",
            execute_callback=lambda handle: None,
            handle_accepted_callback=self._accepted,
            cancel_callback=lambda handle: CancelResponse.ACCEPT,
            result_timeout=_RESULT_TIMEOUT,
        )

    @property
    def _now(self) -> float:
        return float(self._node.get_clock().now().nanoseconds * 1e-9)

    def _commanded(self, twist: Twist) -> None:
        is_holonomic = self._node.get_parameter("holonomic").value
        left = twist.linear.y if is_holonomic else 0.0
        self.turtle.command(twist.linear.x, left, twist.angular.z, self._now)

    def _set_pen(self, request: Any, response: Any) -> Any:
        color = (request.r, request.g, request.b)
        self.turtle.pen = Pen(color, request.width or 1, not request.off)
        return response

    def _teleport(self, request: Any, response: Any) -> Any:
        self.turtle.teleport(request.x, request.y, request.theta, self._sheet)
        return response

    def _teleport_ahead(self, request: Any, response: Any) -> Any:
        self.turtle.teleport_ahead(request.linear, request.angular, self._sheet)
        return response

    def _accepted(self, handle: Any) -> None:
        if self._goal is not None:
            self._node.get_logger().warning(
                "Rotation goal received before a previous goal finished. Aborting previous goal"
            )
            self._finish(GoalStatus.STATUS_ABORTED)
        handle.execute()
        self._goal, self._start = handle, self.turtle.theta
        self.turtle.goal = handle.request.theta

    def _finish(self, status: int) -> None:
        self.turtle.goal = None
        delta = self.turtle.turned_back_to(self._start)
        handle, self._goal = self._goal, None
        self._action.finish(handle, status, RotateAbsolute.Result(delta=delta))

    def advance(self) -> None:
        """Move for a period, and say where it is."""
        turtle, log = self.turtle, self._node.get_logger()
        if self._goal is not None and self._goal.is_cancel_requested:
            log.info("Rotation goal canceled")
            turtle.command(0.0, 0.0, 0.0, self._now)
            self._finish(GoalStatus.STATUS_CANCELED)
        if turtle.advance(_PERIOD, self._now, self._sheet):
            log.warning(f"Oh no! I hit the wall! (Clamping from [x={turtle.x:f}, y={turtle.y:f}])")
        if self._goal is not None:
            feedback = RotateAbsolute.Feedback(remaining=turtle.remaining)
            self._goal.publish_feedback(feedback)
            if turtle.goal is None:
                log.info("Rotation goal completed successfully")
                self._finish(GoalStatus.STATUS_SUCCEEDED)
        self._publish()

    def _publish(self) -> None:
        turtle = self.turtle
        pose = Pose(x=turtle.x, y=turtle.y, theta=turtle.theta)
        pose.linear_velocity, _, pose.angular_velocity = turtle.velocity
        self._pose.publish(pose)
        red, green, blue = self._sheet.color_at(turtle.x, turtle.y)
        self._color.publish(Color(r=red, g=green, b=blue))

    def destroy(self) -> None:
        """Leave the graph."""
        self._action.destroy()
        for service in self._services:
            self._node.destroy_service(service)
        self._node.destroy_subscription(self._command)
        for publisher in (self._pose, self._color):
            self._node.destroy_publisher(publisher)


class Turtlesim:
    """The node: its sheet, and the turtles on it by their names."""

    def __init__(self, node: Node) -> None:
        self._node = node
        for name, usual in _BACKGROUND.items():
            limits = [IntegerRange(from_value=0, to_value=255, step=1)]
            what = f"{name.removeprefix('background_')} channel of the background color, 0 to 255"
            described = ParameterDescriptor(description=what, integer_range=limits)
            node.declare_parameter(name, usual, described)
        node.declare_parameter("holonomic", False)
        self.sheet = Sheet(self._background)
        self._shown: dict[str, _TurtleOfNode] = {}
        self._count = 0
        node.get_logger().info(
            f"Starting turtlesim with node name {node.get_fully_qualified_name()}"
        )
        self._spawn("", SIDE / 2.0, SIDE / 2.0, 0.0)
        services: tuple[tuple[Any, str, Callable[[Any, Any], Any]], ...] = (
            (Empty, "clear", self._clear),
            (Empty, "reset", self._reset),
            (Spawn, "spawn", self._on_spawn),
            (Kill, "kill", self._kill),
        )
        for kind, name, answer in services:
            node.create_service(kind, name, answer)
        node.create_timer(_PERIOD, self._advance)

    @property
    def turtles(self) -> dict[str, Turtle]:
        """The turtles by their names."""
        return {name: one.turtle for name, one in self._shown.items()}

    @property
    def _background(self) -> tuple[int, int, int]:
        red, green, blue = (int(self._node.get_parameter(name).value) for name in _BACKGROUND)
        return red, green, blue

    def _advance(self) -> None:
        for one in self._shown.values():
            one.advance()

    def _spawn(self, name: str, x: float, y: float, theta: float) -> str:
        """Add a turtle; return its name, "" where there is one of that name."""
        if name in self._shown:
            return ""
        while not name or name in self._shown:
            self._count += 1
            name = f"turtle{self._count}"
        turtle = Turtle(x, y, theta)
        self._shown[name] = _TurtleOfNode(self._node, name, turtle, self.sheet)
        self._node.get_logger().info(
            f"Spawning turtle [{name}] at x=[{x:f}], y=[{y:f}], theta=[{theta:f}]"
        )
        return name

    def _on_spawn(self, request: Any, response: Any) -> Any:
        response.name = self._spawn(request.name, request.x, request.y, request.theta)
        if not response.name:
            self._node.get_logger().error(f"A turtle named [{request.name}] already exists")
        return response

    def _kill(self, request: Any, response: Any) -> Any:
        if (found := self._shown.pop(request.name, None)) is not None:
            found.destroy()
        else:
            self._node.get_logger().error(
                f"Tried to kill turtle [{request.name}], which does not exist"
            )
        return response

    def _clear(self, request: Any, response: Any) -> Any:
        self._node.get_logger().info("Clearing turtlesim.")
        self.sheet.clear(self._background)
        return response

    def _reset(self, request: Any, response: Any) -> Any:
        self._node.get_logger().info("Resetting turtlesim.")
        for one in self._shown.values():
            one.destroy()
        self._shown.clear()
        self._count = 0
        self.sheet.clear(self._background)
        self._spawn("", SIDE / 2.0, SIDE / 2.0, 0.0)
        return response


def main(words: list[str]) -> None:
    """Show turtles until the window is closed; without a display they move all the same."""
    with Client(name="turtlesim", executor=SingleThreadedExecutor) as client:
        turtlesim = Turtlesim(client.node)
        window = Window.opened(client.node.get_logger().warning)
        if window is None:
            client.pause()
        while window is not None and window.show(turtlesim.sheet, turtlesim.turtles.values()):
            client.pause(window.PERIOD)


def mimic(words: list[str]) -> None:
    """Have what listens to `output/cmd_vel` move as the turtle of `input/pose`."""
    with Client(name="turtle_mimic") as client:
        commands = client.node.create_publisher(Twist, "output/cmd_vel", 1)

        def heard(pose: Pose) -> None:
            twist = Twist()
            twist.linear.x, twist.angular.z = pose.linear_velocity, pose.angular_velocity
            commands.publish(twist)

        client.node.create_subscription(Pose, "input/pose", heard, 1)
        client.pause()
