"""Node collision_monitor: cmd_vel_smoothed in, cmd_vel out, as in Nav2's chain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from nav2_msgs.msg import CollisionMonitorState
from nav2_msgs.srv import Toggle

from arjuna_core.config import duration_param, fixed, param
from arjuna_core.ros import qos
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.silence import Silence, SilenceWatch
from arjuna_core.ros.velocity import VelocityOutput, subscribe_velocity
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.nodes.safety.watch import Watch, WatchConfig
from arjuna_nav.safety.collision_monitor import Verdict
from arjuna_nav.safety.zones import Action

_BLIND = "invalid source"


@dataclass(frozen=True)
class CollisionMonitorConfig(WatchConfig):
    """Parameters of the node `collision_monitor`, by Nav2's names."""

    cmd_vel_in_topic: str = fixed("cmd_vel_smoothed", "Topic of the commands.")
    cmd_vel_out_topic: str = fixed("cmd_vel", "Topic of what to drive.")
    state_topic: str = fixed("", "Topic of what is done; empty: none.")
    stop_pub_timeout: float = duration_param(1.0, "How long zero is repeated.")
    enabled: bool = param(True, "Whether it looks at all; else commands pass.")
    enable_stamped_cmd_vel: bool = fixed(False, "Whether both are TwistStamped.")
    use_realtime_priority: bool = fixed(
        False, "Whether its process runs before all others of the machine."
    )


class CollisionMonitorNode(ManagedNode):
    """Passes each command on, as far as what is seen allows; without sight the robot stands."""

    Config = CollisionMonitorConfig
    DEFAULT_NAME = "collision_monitor"

    def configure(self) -> None:
        config = self.config
        if config.use_realtime_priority:
            self.process.use_realtime_priority()
        self._watch = Watch(self)
        self._enabled = config.enabled
        self._published = Verdict(STILL)
        self._moved_at = 0.0
        stamped = config.enable_stamped_cmd_vel
        self._output = VelocityOutput(self, stamped, self._watch.base, config.cmd_vel_out_topic)
        self._state: Any | None = None
        if config.state_topic:
            self._state = self.publisher(CollisionMonitorState, config.state_topic, qos.LATCHED)
        subscribe_velocity(self, config.cmd_vel_in_topic, stamped, self._on_command)
        kind, advice = TwistStamped if stamped else Twist, "set cmd_vel_in_topic"
        commands = Silence(kind, "command", qos.LATEST, advice, rare=True)
        SilenceWatch(self, config.cmd_vel_in_topic, commands)
        self._has_listener = False
        self.serve(Toggle, f"{self.get_name()}/toggle", self._on_toggle)

    def activate(self) -> None:
        self._watch.reset()
        self._moved_at = self.now

    def on_time_jump(self) -> None:
        if self.active:
            self.activate()

    def on_config(self, config: CollisionMonitorConfig) -> None:
        self._watch.reconfigure(config)
        self._enabled = config.enabled

    def _on_toggle(self, request: Any, response: Any) -> Any:
        self._enabled = request.enable
        response.success = True
        response.message = f"collision monitoring is {'on' if request.enable else 'off'}"
        return response

    def _on_command(self, velocity: Velocity) -> None:
        verdict = self._judge(velocity) if self._enabled else Verdict(velocity)
        self._publish_state(verdict)
        if velocity != STILL:
            self._look_for_base()
        if verdict.velocity != STILL:
            self._moved_at = self.now
        if self.now - self._moved_at <= self.config.stop_pub_timeout:
            self._output.publish(verdict.velocity)
        self._watch.publish(velocity)

    def _look_for_base(self) -> None:
        """Warn, once, where nobody takes what is to be driven."""
        if not self._has_listener and not self._output.has_listener():
            topic = self.config.cmd_vel_out_topic
            text = f"nobody takes the velocities on '{topic}': set cmd_vel_out_topic"
            text += f"; '{self.config.cmd_vel_in_topic}' must not be the robot's own"
            self.get_logger().warning(text)
        self._has_listener = True

    def _judge(self, velocity: Velocity) -> Verdict:
        seen = self._watch.look()
        if seen is None:
            return Verdict(STILL, Action.STOP, _BLIND)
        sight, trust = seen
        slowed = velocity.scaled(trust)
        verdict = self._watch.monitor.judge(slowed, sight, self._watch.footprint())
        if trust < 1.0 and verdict.action is Action.DO_NOTHING:
            return Verdict(slowed, Action.SLOWDOWN, _BLIND)
        return verdict

    def trouble(self) -> str:
        silent = self._watch.silent() if self.active and self._enabled else ""
        return f"the robot is held: {silent}" if silent else ""

    def _publish_state(self, verdict: Verdict) -> None:
        """Publish what is done, where it is not what was done before."""
        if (verdict.action, verdict.zone) == (self._published.action, self._published.zone):
            return
        self._published = verdict
        name = verdict.zone
        if self._state is not None:
            self._state.publish(
                CollisionMonitorState(action_type=int(verdict.action), polygon_name=name)
            )
        text = f"{verdict.action.name} {name}".rstrip()
        blind = verdict.action is Action.STOP and name == _BLIND
        if why := self._watch.why_silent() if blind else "":
            self.get_logger().warning(f"{text}: {why}")
        else:
            self.get_logger().info(text)
