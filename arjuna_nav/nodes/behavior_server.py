"""Node behavior_server: spin, backup, drive_on_heading, assisted_teleop, wait."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

from std_msgs.msg import Empty

from arjuna_core.config import NoParameters, duration_param, fixed, plugin_names
from arjuna_core.ros import qos
from arjuna_core.ros.convert import duration_msg, seconds
from arjuna_core.ros.goal_server import GoalError, GoalNode, result_timeout
from arjuna_core.ros.tf import TransformError
from arjuna_core.ros.velocity import VelocityOutput, subscribe_velocity
from arjuna_core.se2 import IDENTITY
from arjuna_core.twist import Velocity
from arjuna_nav.behaviors.base import (
    Behavior,
    BehaviorConfig,
    BehaviorResult,
    BehaviorStatus,
    InvalidGoalError,
)
from arjuna_nav.behaviors.motions import AssistedTeleop
from arjuna_nav.nodes.behavior_actions import BEHAVIORS, DEFAULT_BEHAVIORS, BehaviorAction
from arjuna_nav.nodes.costmap.reader import CostmapReader
from arjuna_nav.nodes.frames import robot_pose


@dataclass(frozen=True)
class BehaviorServerConfig(BehaviorConfig):
    """Parameters of behavior_server."""

    behavior_plugins: tuple[str, ...] = plugin_names(
        DEFAULT_BEHAVIORS, "The behaviours; the names are those of their actions.", BEHAVIORS
    )
    cycle_frequency: float = fixed(10.0, "Commands a second.", unit="Hz", minimum=0.1)
    action_server_result_timeout: float = result_timeout(10.0)
    local_costmap_topic: str = fixed("local_costmap/costmap_raw", "Costs to move in.")
    local_footprint_topic: str = fixed(
        "local_costmap/published_footprint", "Outline to move there."
    )
    global_costmap_topic: str = fixed(
        "global_costmap/costmap_raw", "Costs of behaviours of one's own that move in the whole map."
    )
    global_footprint_topic: str = fixed(
        "global_costmap/published_footprint", "Outline to move there."
    )
    local_frame: str = fixed("", "Frame to move in; empty: the local costmap's.")
    global_frame: str = fixed("", "The same in the whole map.")
    robot_base_frame: str = fixed("", "Frame of the robot; empty: that too.")
    transform_tolerance: float = duration_param(0.1, "How old the robot's pose may be.")
    costmap_update_timeout: float = duration_param(1.0, "How old the costmap may be.")
    cmd_vel_topic: str = fixed("cmd_vel_nav", "Topic of the velocities; velocity_smoother listens.")
    cmd_vel_teleop_topic: str = fixed(
        "cmd_vel_teleop", "Topic of the commands for assisted_teleop."
    )
    enable_stamped_cmd_vel: bool = fixed(False, "Whether cmd_vel is TwistStamped.")


class _Run(NamedTuple):
    kind: str
    behavior: Behavior
    since: float


class BehaviorServerNode(GoalNode):
    """Runs one behaviour at a time; a new goal ends the running one."""

    Config = BehaviorServerConfig
    DEFAULT_NAME = "behavior_server"

    def configure(self) -> None:
        config = self.config
        self._running: _Run | None = None
        self._output = VelocityOutput(
            self, config.enable_stamped_cmd_vel, topic=config.cmd_vel_topic
        )
        self._actions: dict[str, BehaviorAction] = {
            kind: BEHAVIORS.resolve(getattr(config, kind).plugin)
            for kind in config.behavior_plugins
        }
        self._costmaps = self._read_costmaps(config)
        self._servers = {
            kind: self.offer(
                action.type,
                kind,
                partial(self._start, kind),
                on_cancel=self._check_cancelled,
                unknown=action.unknown,
            )
            for kind, action in self._actions.items()
        }
        teleop, stamped = config.cmd_vel_teleop_topic, config.enable_stamped_cmd_vel
        subscribe_velocity(self, teleop, stamped, self._on_teleop)
        self.subscribe(Empty, "preempt_teleop", self._on_preempt_teleop, qos.DEFAULT)
        self.every(1.0 / config.cycle_frequency, self._cycle)

    def _read_costmaps(self, config: BehaviorServerConfig) -> dict[str, CostmapReader]:
        needed = {action.area for action in self._actions.values() if action.moves}
        return {
            area: CostmapReader(
                self,
                getattr(config, f"{area}_costmap_topic"),
                getattr(config, f"{area}_footprint_topic"),
                config.robot_base_frame,
                config.transform_tolerance,
            )
            for area in sorted(needed)
        }

    def halt(self) -> None:
        if self._running is not None:
            self._output.stop()
        self._running = None

    def _teleop(self) -> AssistedTeleop | None:
        behavior = self._running.behavior if self._running is not None else None
        return behavior if isinstance(behavior, AssistedTeleop) else None

    def _on_teleop(self, velocity: Velocity) -> None:
        teleop = self._teleop()
        if teleop is not None:
            teleop.take(velocity, self.now)

    def _on_preempt_teleop(self, message: Any) -> None:
        teleop = self._teleop()
        if teleop is not None:
            teleop.finish()

    def _start(self, kind: str) -> None:
        if self._running is not None and self._running.kind != kind:
            message = f"ended by a new {kind} at {self.now:.2f} s"
            self._end(BehaviorResult(BehaviorStatus.UNKNOWN, message=message))
        server = self._servers[kind]
        goal = server.take_newest()
        refusal = self._begin(kind, goal)
        if refusal is not None:
            self.halt()
            self._conclude(kind, refusal, self.now)

    def _begin(self, kind: str, goal: Any) -> BehaviorResult | None:
        """Run the behaviour that a goal asks for, or return why it is not run."""
        action = self._actions[kind]
        if action.moves and not self._costmaps[action.area].active:
            message = self._costmaps[action.area].why_not_current()
            return BehaviorResult(BehaviorStatus.UNKNOWN, message=message)
        try:
            behavior = self._behavior(kind, goal)
        except TransformError as error:
            return BehaviorResult(BehaviorStatus.TF_ERROR, message=str(error))
        except InvalidGoalError as error:
            return BehaviorResult(BehaviorStatus.INVALID_INPUT, message=str(error))
        self._running = _Run(kind, behavior, self.now)
        return None

    def _behavior(self, kind: str, goal: Any) -> Behavior:
        action = self._actions[kind]
        if not action.moves:
            return action.make(goal)
        footprint = self._costmaps[action.area].footprint()
        own = () if action.Config is NoParameters else (getattr(self.config, kind),)
        return action.make(goal, self.config, footprint, seconds(goal.time_allowance), *own)

    def _cycle(self) -> None:
        self._check_cancelled()
        if self._running is None:
            return
        action = self._actions[self._running.kind]
        result = self._tick(action, self._running.behavior)
        if result.status is not BehaviorStatus.RUNNING:
            self._end(result)
            return
        if action.moves:
            self._output.publish(result.velocity)
        self._servers[self._running.kind].feedback(action.feedback(result.progress))

    def _check_cancelled(self) -> None:
        run = self._running
        if run is None or not self._servers[run.kind].cancel_requested:
            return
        self.halt()
        elapsed = duration_msg(self.now - run.since)
        result = self._actions[run.kind].type.Result(total_elapsed_time=elapsed)
        self._servers[run.kind].cancel(result)

    def _tick(self, action: BehaviorAction, behavior: Behavior) -> BehaviorResult:
        if not action.moves:  # stands still: it needs to know nothing
            return behavior.tick(IDENTITY, None, self.now)
        near, config = self._costmaps[action.area], self.config
        frame = getattr(config, f"{action.area}_frame") or near.frame
        try:
            tolerance = config.transform_tolerance
            pose = robot_pose(self, frame, near.base_frame, tolerance, any_clock=True)
            costmap = near.current(config.costmap_update_timeout, frame)
        except TransformError as error:
            message = f"the robot's pose is not known: {error}"
            return BehaviorResult(BehaviorStatus.TF_ERROR, message=message)
        if costmap is None:
            return BehaviorResult(BehaviorStatus.UNKNOWN, message=near.why_not_current())
        return behavior.tick(pose, costmap, self.now)

    def _end(self, result: BehaviorResult) -> None:
        assert self._running is not None
        kind, _, since = self._running
        self._running = None
        if self._actions[kind].moves:
            self._output.stop()
        self._conclude(kind, result, since)

    def _conclude(self, kind: str, result: BehaviorResult, since: float) -> None:
        elapsed = duration_msg(self.now - since)
        action, server = self._actions[kind], self._servers[kind]
        if result.status is BehaviorStatus.SUCCEEDED:
            server.succeed(action.type.Result(total_elapsed_time=elapsed))
        else:
            error = GoalError(action.error_code(result.status), result.message)
            server.fail(error, total_elapsed_time=elapsed)
