"""A robot that tests play to the navigation nodes: transforms, odometry, scans, a map, wheels."""

from __future__ import annotations

import re
from typing import Any, ClassVar

import numpy as np
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Point, Twist
from nav2_msgs.action import AssistedTeleop, BackUp, DriveOnHeading, Spin, Wait
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from nav_msgs.msg import Odometry
from rclpy.lifecycle import TransitionCallbackReturn
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import duration_msg, grid_msg, scan_msg, time_msg, transform_msg
from arjuna_core.ros.local.actions import action_client
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import Velocity
from bringup.parameters.files import Parameters, for_node, merged, shipped_parameters
from bringup.stack import COLLISION_MONITOR, GLOBAL_COSTMAP, NodeSpec
from tests.helpers.ros import TICK, RosBench
from tests.nav.worlds import block, room, scan_from

SUCCEEDED = GoalStatus.STATUS_SUCCEEDED
CANCELED = GoalStatus.STATUS_CANCELED
ABORTED = GoalStatus.STATUS_ABORTED
_SCAN_TICKS = 5
_TO_THE_WHEELS: Parameters = {
    name: {"cmd_vel_topic": "cmd_vel"} for name in ("controller_server", "behavior_server")
}


class Goal:
    """A goal that a client sent.

    Attributes:
        accepted: Whether the server took it.
    """

    def __init__(self, bench: RosBench, client: Any, request: Any) -> None:
        self._bench = bench
        self.feedback: list[Any] = []
        sent = client.send_goal_async(
            request, feedback_callback=lambda message: self.feedback.append(message.feedback)
        )
        bench.process.drain()
        self._handle = sent.result()
        self.accepted = bool(self._handle.accepted)
        self._outcome = self._handle.get_result_async() if self.accepted else None
        bench.process.drain()

    @property
    def done(self) -> bool:
        """True once it has ended."""
        return self._outcome is not None and bool(self._outcome.done())

    @property
    def status(self) -> int:
        """Its final GoalStatus."""
        assert self._outcome is not None
        return int(self._outcome.result().status)

    @property
    def result(self) -> Any:
        """Its result message."""
        assert self._outcome is not None
        return self._outcome.result().result

    def cancel(self) -> None:
        """Ask for its cancellation; time stands still."""
        self._handle.cancel_goal_async()
        self._bench.process.drain()


def _listed_only(parameters: Parameters) -> Parameters:
    """Return parameters without those of layers that a costmap does not list."""
    return {
        node: {
            key: value
            for key, value in values.items()
            if not key.partition(".")[0].endswith("_layer")
            or key.partition(".")[0] in values.get("plugins", key)
        }
        for node, values in parameters.items()
    }


class PlayedRobot:
    """The rest of a robot: it drives as /cmd_vel says and sees a world through a lidar.

    Args:
        parameters: Parameters that differ from the shipped ones, by node.
        start: Where it starts, in map.
        shipped: Whether the shipped parameters lie below those given.

    Attributes:
        pose: Where the robot is, in map.
        command: The last velocity on /cmd_vel.
        commands: Every velocity since the last `forget`.
        localized: Whether map -> odom and odom -> base_footprint are published.
        sees: Whether scans come.
        scan_age: How old they are by their stamps when they come [s].
        grips: Whether the wheels move the robot.
        open: The robots that are not closed yet.
    """

    open: ClassVar[list[PlayedRobot]] = []

    def __init__(
        self,
        parameters: Parameters | None = None,
        start: SE2 = IDENTITY,
        shipped: bool = True,
    ) -> None:
        self.bench = RosBench()
        self.open.append(self)
        self.world = room()
        self.pose = start
        self.command = Velocity()
        self.commands: list[Velocity] = []
        self.localized = self.sees = self.grips = True
        self.scan_age = 0.0
        self.nodes: dict[str, Any] = {}
        self._parameters = _listed_only(
            merged(shipped_parameters() if shipped else {}, parameters or {})
        )
        self._clients: dict[str, Any] = {}
        self._ticks = 0
        self.bench.node.create_subscription(Twist, "cmd_vel", self._on_command, qos.DEFAULT)
        mounts = [("base_footprint", "base_link"), ("base_link", "lidar_link")]
        fixed = TFMessage(transforms=[transform_msg(IDENTITY, *mount, 0.0) for mount in mounts])
        self.bench.publish(TFMessage, "/tf_static", fixed, qos.TF_STATIC)

    @property
    def now(self) -> float:
        """Time [s]."""
        return self.bench.process.now

    def _on_command(self, message: Any) -> None:
        self.command = Velocity(message.linear.x, yaw_rate=message.angular.z)
        self.commands.append(self.command)

    def bring_up(self, *specs: NodeSpec) -> None:
        """Make nodes, configure all, then activate all; without the chain, servers drive."""
        if COLLISION_MONITOR not in specs:
            self._parameters = merged(_TO_THE_WHEELS, self._parameters)
        for spec in specs:
            self.nodes[spec.name] = spec.make(
                self.bench.process, for_node(self._parameters, spec.name)
            )
        for transition in ("configure", "activate"):
            for spec in specs:
                self.transition(spec.name, transition)

    def transition(self, name: str, transition: str) -> None:
        """Make one transition of a node."""
        result = getattr(self.nodes[name], f"trigger_{transition}")()
        self.bench.process.drain()
        assert result == TransitionCallbackReturn.SUCCESS, f"{name} did not {transition}"

    def send_map(self, grid: OccupancyGrid | None = None) -> None:
        """Publish a map, latched; the world itself if none is given.

        Whoever subscribes later gets it at no fixed time: first bring up, then send.
        """
        message = grid_msg(grid or self.world, "map", self.now)
        self.bench.publish(OccupancyGridMsg, "/map", message, qos.LATCHED)

    def run(self, duration: float) -> None:
        """Let time pass [s]."""
        for _ in range(round(duration / TICK)):
            self._tick()

    def run_until_done(self, goal: Goal, timeout: float) -> None:
        """Let time pass until a goal has ended; it must within a timeout [s]."""
        deadline = self.now + timeout
        while not goal.done:
            assert self.now < deadline, f"the goal has no result after {timeout:g} s"
            self._tick()

    def succeed(self, goal: Goal, timeout: float) -> None:
        """Let time pass until a goal has succeeded; it must within a timeout [s]."""
        self.run_until_done(goal, timeout)
        assert goal.status == SUCCEEDED, goal.result

    def fail(self, goal: Goal, timeout: float, code: int, says: str = "") -> None:
        """Let time pass until a goal is aborted, as `assert_failed` has it, within a time [s]."""
        self.run_until_done(goal, timeout)
        assert_failed(goal, code, says)

    def _tick(self) -> None:
        self.bench.advance()
        motion = self.command if self.grips else Velocity()
        self.pose = self.pose @ SE2.exp(np.array([motion.x, 0.0, motion.yaw_rate]) * TICK)
        self._ticks += 1
        if self.localized:
            self._publish_pose(motion)
        if self.sees and self._ticks % _SCAN_TICKS == 0:
            scan = scan_from(self.world, self.pose)
            message = scan_msg(scan, "lidar_link", _SCAN_TICKS * TICK)
            message.header.stamp = time_msg(self.now - self.scan_age)
            self.bench.publish(LaserScan, "/scan", message, qos.SENSOR_PUBLISHER)

    def _publish_pose(self, motion: Velocity) -> None:
        message = TFMessage(
            transforms=[
                transform_msg(IDENTITY, "map", "odom", self.now),
                transform_msg(self.pose, "odom", "base_footprint", self.now),
            ]
        )
        self.bench.publish(TFMessage, "/tf", message, qos.TF)
        odometry = Odometry()
        odometry.header.stamp = self._stamp()
        odometry.twist.twist.linear.x = motion.x
        odometry.twist.twist.angular.z = motion.yaw_rate
        self.bench.publish(Odometry, "/odom", odometry, qos.DEFAULT)

    def _stamp(self) -> Any:
        return transform_msg(IDENTITY, "", "", self.now).header.stamp

    def forget(self) -> None:
        """Forget the velocities so far."""
        self.commands.clear()

    def send(self, action_type: Any, name: str, request: Any) -> Goal:
        """Send a goal; time stands still."""
        if name not in self._clients:
            self._clients[name] = action_client(self.bench.node, action_type, name)
            self.bench.process.drain()
        return Goal(self.bench, self._clients[name], request)

    def close(self) -> None:
        """Leave the graph, at once and unnoticed as a process that is killed."""
        self.open.remove(self)
        for client in self._clients.values():
            client.destroy()
        self.bench.close()


def started(
    *specs: NodeSpec,
    start: SE2 = IDENTITY,
    world: OccupancyGrid | None = None,
    settle: float = 1.0,
    **parameters: Any,
) -> PlayedRobot:
    """Return a robot with nodes that run for some time [s] on its map, if they need one.

    Args:
        start: Where the robot is, in map.
        world: What it sees; the room if none is given.
        parameters: Parameters that differ from the shipped ones, by node.
    """
    robot = PlayedRobot(parameters, start)
    robot.world = world or robot.world
    robot.bring_up(*specs)
    if GLOBAL_COSTMAP in specs:
        robot.send_map()
    robot.run(settle)
    return robot


def assert_failed(goal: Goal, code: int, says: str = "") -> None:
    """Check that a goal was aborted with a code and a reason that names a number or a name.

    Args:
        says: What the reason says.
    """
    assert goal.done, "the goal has no result"
    assert (goal.status, goal.result.error_code) == (ABORTED, code), goal.result.error_msg
    assert re.search(r"\d|'|nan|inf", goal.result.error_msg), goal.result.error_msg
    assert says in goal.result.error_msg


COSTMAP = "local_costmap/local_costmap"
KINDS = ("spin", "backup", "drive_on_heading", "assisted_teleop", "wait")
MOVING = KINDS[:4]
UNKNOWN = {"spin": 700, "backup": 710, "drive_on_heading": 720, "assisted_teleop": 730, "wait": 740}


def spin(robot: PlayedRobot, angle: float, allowance: float = 10.0) -> Goal:
    request = Spin.Goal(target_yaw=angle, time_allowance=duration_msg(allowance))
    return robot.send(Spin, "spin", request)


def backup(
    robot: PlayedRobot, x: float, speed: float, allowance: float = 10.0, y: float = 0.0
) -> Goal:
    request = BackUp.Goal(
        target=Point(x=x, y=y), speed=speed, time_allowance=duration_msg(allowance)
    )
    return robot.send(BackUp, "backup", request)


def drive(
    robot: PlayedRobot, x: float, speed: float, allowance: float = 10.0, y: float = 0.0
) -> Goal:
    request = DriveOnHeading.Goal(
        target=Point(x=x, y=y), speed=speed, time_allowance=duration_msg(allowance)
    )
    return robot.send(DriveOnHeading, "drive_on_heading", request)


def wait(robot: PlayedRobot, time: float) -> Goal:
    return robot.send(Wait, "wait", Wait.Goal(time=duration_msg(time)))


def teleop(robot: PlayedRobot, allowance: float = 10.0) -> Goal:
    request = AssistedTeleop.Goal(time_allowance=duration_msg(allowance))
    return robot.send(AssistedTeleop, "assisted_teleop", request)


def command(robot: PlayedRobot, v: float, w: float = 0.0) -> None:
    """Command a velocity as a person at a joystick does."""
    message = Twist()
    message.linear.x, message.angular.z = v, w
    robot.bench.publish(Twist, "/cmd_vel_teleop", message)


def start(robot: PlayedRobot, kind: str, allowance: float = 10.0) -> Goal:
    if kind == "wait":
        return wait(robot, 3.0)
    if kind == "spin":
        return spin(robot, 3.0, allowance)
    if kind == "assisted_teleop":
        goal = teleop(robot, allowance)
        command(robot, 0.2)
        return goal
    return (backup if kind == "backup" else drive)(robot, 1.0, 0.2, allowance)


def wall_ahead(robot: PlayedRobot, x: float) -> None:
    """Put a wall across the robot's path at a distance [m] from the origin."""
    block(robot.world, 5.5 + x, 4.5, 0.1, 2.0)
