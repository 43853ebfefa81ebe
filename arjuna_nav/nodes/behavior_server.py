"""Node behavior_server: spin, backup, drive_on_heading, assisted_teleop, wait."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

from nav2_msgs.action import AssistedTeleop, BackUp, DriveOnHeading, Spin, Wait
from std_msgs.msg import Empty

from arjuna_core.config import param
from arjuna_core.ros import qos
from arjuna_core.ros.actions import GoalServer
from arjuna_core.ros.convert import duration_msg, seconds
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import IDENTITY
from arjuna_nav.behaviors import behaviors
from arjuna_nav.behaviors.behaviors import (
    Behavior,
    BehaviorConfig,
    BehaviorResult,
    BehaviorStatus,
)
from arjuna_nav.controllers.base import Velocity
from arjuna_nav.nodes.costmap.node import CostmapNode
from arjuna_nav.nodes.velocity.input import subscribe_velocity
from arjuna_nav.nodes.velocity.output import VelocityOutput

_FEEDBACK = {
    "spin": "angular_distance_traveled",
    "backup": "distance_traveled",
    "drive_on_heading": "distance_traveled",
}
_ACTIONS = {
    "spin": Spin,
    "backup": BackUp,
    "drive_on_heading": DriveOnHeading,
    "assisted_teleop": AssistedTeleop,
    "wait": Wait,
}


@dataclass(frozen=True)
class BehaviorServerConfig(BehaviorConfig):
    """Parameters of behavior_server."""

    behavior_plugins: tuple[str, ...] = param(
        tuple(_ACTIONS), "behaviours", choices=tuple(_ACTIONS), read_only=True
    )
    cycle_frequency: float = param(
        10.0, "commands a second", unit="Hz", minimum=1.0, read_only=True
    )
    costmap_update_timeout: float = param(1.0, "how old the costmap may be", unit="s", minimum=0.0)
    cmd_vel_topic: str = param("cmd_vel", "topic of what to drive", read_only=True)
    cmd_vel_teleop_topic: str = param(
        "cmd_vel_teleop", "topic of what assisted_teleop is to drive", read_only=True
    )
    enable_stamped_cmd_vel: bool = param(False, "whether cmd_vel is TwistStamped", read_only=True)


class BehaviorServerNode(ManagedNode):
    """Runs one behaviour at a time; a new goal ends the running one."""

    Config = BehaviorServerConfig
    DEFAULT_NAME = "behavior_server"

    def configure(self) -> None:
        """Create the actions."""
        config = self.config
        self._costmap: CostmapNode = self.process.find("local_costmap/local_costmap")
        self._running: tuple[str, Behavior, float] | None = None
        self._output = VelocityOutput(
            self, config.enable_stamped_cmd_vel, topic=config.cmd_vel_topic
        )
        self._servers: dict[str, GoalServer] = {
            kind: self.keep(
                GoalServer(
                    self,
                    _ACTIONS[kind],
                    kind,
                    partial(self._start, kind),
                    on_cancel=self._check_cancelled,
                    unknown=behaviors.error_code(kind, BehaviorStatus.UNKNOWN),
                )
            )
            for kind in config.behavior_plugins
        }
        teleop, stamped = config.cmd_vel_teleop_topic, config.enable_stamped_cmd_vel
        subscribe_velocity(self, teleop, stamped, self._on_teleop)
        self.subscribe(Empty, "preempt_teleop", self._on_preempt_teleop, qos.DEFAULT)
        self.every(1.0 / config.cycle_frequency, self._cycle)

    def deactivate(self) -> None:
        """Stop the robot and abort."""
        self._abort("the node was deactivated")

    def on_time_jump(self) -> None:
        """Stop the robot and abort: what was asked for belongs to another time."""
        if self.active:
            self._abort("time was set back")

    def _abort(self, reason: str) -> None:
        if self._running is not None:
            self._output.stop()
        self._running = None
        for server in self._servers.values():
            server.abort_all(reason)

    def _on_teleop(self, velocity: Velocity) -> None:
        if self._running is not None and isinstance(self._running[1], behaviors.AssistedTeleop):
            self._running[1].take(velocity, self.now)

    def _on_preempt_teleop(self, message: Any) -> None:
        if self._running is not None and isinstance(self._running[1], behaviors.AssistedTeleop):
            self._running[1].finish()

    def _start(self, kind: str) -> None:
        """Begin a behaviour; whichever ran before is aborted."""
        if self._running is not None and self._running[0] != kind:
            message = f"ended by a new {kind} at {self.now:.2f} s"
            self._end(BehaviorResult(BehaviorStatus.UNKNOWN, message=message))
        server = self._servers[kind]
        goal = server.accept_pending() if server.preempt_requested else server.goal
        problem = self._problem(kind, goal)
        if problem is None:
            self._running = (kind, self._make(kind, goal), self.now)
        else:
            self._conclude(kind, problem, self.now)

    def _problem(self, kind: str, goal: Any) -> BehaviorResult | None:
        """Say why a goal is not begun, or return None."""
        if kind != "wait" and not self._costmap.active:
            message = self._costmap.why_not_current()
            return BehaviorResult(BehaviorStatus.UNKNOWN, message=message)
        if kind in ("backup", "drive_on_heading") and (goal.target.y or goal.target.z):
            message = (
                f"target ({goal.target.x:g}, {goal.target.y:g}, {goal.target.z:g}) is not on x"
            )
            return BehaviorResult(BehaviorStatus.INVALID_INPUT, message=message)
        return None

    def _make(self, kind: str, goal: Any) -> Behavior:
        """Return the behaviour that a goal asks for."""
        if kind == "wait":
            return behaviors.Wait(seconds(goal.time))
        footprint = self._costmap.layered.footprint
        rest = (self.config, footprint, seconds(goal.time_allowance))
        if kind == "assisted_teleop":
            return behaviors.AssistedTeleop(*rest)
        if kind == "spin":
            return behaviors.Spin(goal.target_yaw, *rest)
        make = behaviors.back_up if kind == "backup" else behaviors.DriveOnHeading
        return make(goal.target.x, goal.speed, *rest)

    def _cycle(self) -> None:
        self._check_cancelled()
        if self._running is None:
            return
        kind, behavior, _ = self._running
        result = self._tick(kind, behavior)
        if result.status is not BehaviorStatus.RUNNING:
            self._end(result)
            return
        if kind != "wait":
            self._output.publish(Velocity(result.v, result.w))
        self._servers[kind].feedback(_feedback(kind, result.progress))

    def _check_cancelled(self) -> None:
        """Stop the robot at once where the goal that runs was cancelled."""
        if self._running is None or not self._servers[self._running[0]].cancel_requested:
            return
        kind, _, started = self._running
        self._running = None
        self._output.stop()
        elapsed = duration_msg(self.now - started)
        self._servers[kind].cancel(_ACTIONS[kind].Result(total_elapsed_time=elapsed))

    def _tick(self, kind: str, behavior: Behavior) -> BehaviorResult:
        if kind == "wait":  # stands still: it needs to know nothing
            return behavior.tick(IDENTITY, None, self.now)
        try:
            pose = self._costmap.robot_pose()
        except TransformError as error:
            message = f"the robot's pose is not known: {error}"
            return BehaviorResult(BehaviorStatus.TF_ERROR, message=message)
        costmap = self._costmap.current(self.config.costmap_update_timeout)
        if costmap is None:
            message = self._costmap.why_not_current()
            return BehaviorResult(BehaviorStatus.UNKNOWN, message=message)
        return behavior.tick(pose, costmap, self.now)

    def _end(self, result: BehaviorResult) -> None:
        assert self._running is not None
        kind, _, started = self._running
        self._running = None
        if kind != "wait":
            self._output.stop()
        self._conclude(kind, result, started)

    def _conclude(self, kind: str, result: BehaviorResult, started: float) -> None:
        """Tell the client how its goal ended."""
        answer = _ACTIONS[kind].Result(
            total_elapsed_time=duration_msg(self.now - started),
            error_code=behaviors.error_code(kind, result.status),
            error_msg=result.message,
        )
        if result.status is BehaviorStatus.SUCCEEDED:
            self._servers[kind].succeed(answer)
            return
        self.get_logger().warning(f"{kind} failed: {result.status.name}: {result.message}")
        self._servers[kind].abort(answer)


def _feedback(kind: str, progress: float) -> Any:
    if kind == "wait":
        return Wait.Feedback(time_left=duration_msg(progress))
    if kind == "assisted_teleop":
        return AssistedTeleop.Feedback(current_teleop_duration=duration_msg(progress))
    return _ACTIONS[kind].Feedback(**{_FEEDBACK[kind]: float(progress)})
