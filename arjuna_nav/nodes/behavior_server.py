"""Node behavior_server: spin, backup, drive_on_heading, wait."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from nav2_msgs.action import BackUp, DriveOnHeading, Spin, Wait

from arjuna_core.config import param
from arjuna_core.ros.actions import GoalServer
from arjuna_core.ros.convert import duration_msg, seconds
from arjuna_core.ros.node import ManagedNode
from arjuna_nav import behaviors
from arjuna_nav.behaviors import Behavior, BehaviorConfig, BehaviorResult, BehaviorStatus
from arjuna_nav.controllers.base import Velocity
from arjuna_nav.nodes.costmap import CostmapNode
from arjuna_nav.nodes.velocity_output import VelocityOutput

_FEEDBACK = {
    "spin": "angular_distance_traveled",
    "backup": "distance_traveled",
    "drive_on_heading": "distance_traveled",
}
_ACTIONS = {"spin": Spin, "backup": BackUp, "drive_on_heading": DriveOnHeading, "wait": Wait}


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
        self._output = VelocityOutput(self, config.enable_stamped_cmd_vel)
        self._servers: dict[str, GoalServer] = {
            kind: self.keep(GoalServer(self, _ACTIONS[kind], kind, self._starter(kind)))
            for kind in config.behavior_plugins
        }
        self.every(1.0 / config.cycle_frequency, self._cycle)

    def deactivate(self) -> None:
        """Stop the robot and abort."""
        if self._running is not None:
            self._output.stop()
        self._running = None
        for server in self._servers.values():
            server.abort_all()

    def _starter(self, kind: str) -> Callable[[], None]:
        return lambda: self._start(kind)

    def _start(self, kind: str) -> None:
        """Begin a behaviour; whichever ran before is aborted."""
        if self._running is not None and self._running[0] != kind:
            result = BehaviorResult(BehaviorStatus.UNKNOWN, message=f"ended by a new {kind}")
            self._end(result)
        server = self._servers[kind]
        goal = server.accept_pending() if server.preempt_requested else server.goal
        self._running = (kind, self._make(kind, goal), self.now)

    def _make(self, kind: str, goal: Any) -> Behavior:
        """Return the behaviour that a goal asks for."""
        if kind == "wait":
            return behaviors.Wait(seconds(goal.time))
        rest = (self.config, self._costmap.layered.footprint, seconds(goal.time_allowance))
        if kind == "spin":
            return behaviors.Spin(goal.target_yaw, *rest)
        make = behaviors.back_up if kind == "backup" else behaviors.DriveOnHeading
        return make(goal.target.x, goal.speed, *rest)

    def _cycle(self) -> None:
        if self._running is None:
            return
        kind = self._running[0]
        if self._servers[kind].cancel_requested:
            self._output.stop()
            self._running = None
            self._servers[kind].cancel(_ACTIONS[kind].Result())
            return
        result = self._tick()
        if result.status is not BehaviorStatus.RUNNING:
            self._end(result)
            return
        if kind != "wait":
            self._output.publish(Velocity(result.v, result.w))
        self._servers[kind].feedback(_feedback(kind, result.progress))

    def _tick(self) -> BehaviorResult:
        assert self._running is not None
        pose = self._costmap.robot_pose()
        if pose is None:
            message = "the robot's pose in the local costmap is not known"
            return BehaviorResult(BehaviorStatus.TF_ERROR, message=message)
        timeout = self.config.costmap_update_timeout
        costmap = self._costmap.current(timeout)
        if costmap is None:
            message = f"no local costmap for {timeout:g} s"
            return BehaviorResult(BehaviorStatus.UNKNOWN, message=message)
        return self._running[1].tick(pose, costmap, self.now)

    def _end(self, result: BehaviorResult) -> None:
        assert self._running is not None
        kind, _, started = self._running
        self._running = None
        if kind != "wait":
            self._output.stop()
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
    return _ACTIONS[kind].Feedback(**{_FEEDBACK[kind]: float(progress)})
