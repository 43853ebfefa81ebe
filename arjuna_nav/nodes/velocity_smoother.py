"""Node velocity_smoother: cmd_vel_nav in, cmd_vel_smoothed out, as in Nav2's chain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nav_msgs.msg import Odometry

from arjuna_core.config import duration_param, fixed, param
from arjuna_core.ros import qos
from arjuna_core.ros.convert import seconds, velocity_from_twist
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.silence import Silence, subscribe_watched
from arjuna_core.ros.velocity import VelocityOutput, subscribe_velocity
from arjuna_core.twist import RecentVelocities, Velocity
from arjuna_nav.safety.velocity_smoother import SmoothingConfig, VelocitySmoother


@dataclass(frozen=True)
class VelocitySmootherConfig(SmoothingConfig):
    """Parameters of `velocity_smoother`, by Nav2's names; the topics are its remappings."""

    cmd_vel_in_topic: str = fixed("cmd_vel_nav", "Topic of the commands.")
    cmd_vel_out_topic: str = fixed("cmd_vel_smoothed", "Topic of what to drive.")
    odom_topic: str = fixed("odom", "Topic of the odometry.")
    odom_duration: float = duration_param(0.1, "Time over which the measured velocity is a mean.")
    stamp_smoothed_velocity_with_smoothing_time: bool = param(
        False, "Whether a TwistStamped has the time of smoothing, not the last command's."
    )
    enable_stamped_cmd_vel: bool = fixed(False, "Whether both are TwistStamped.")
    use_realtime_priority: bool = fixed(
        False, "Whether its process runs before all others of the machine."
    )


class VelocitySmootherNode(ManagedNode):
    """Publishes nothing until a command comes, and again once the robot stands.

    A command is passed on as it comes, so that the chain costs no time; between commands the last
    one is followed on.
    """

    Config = VelocitySmootherConfig
    DEFAULT_NAME = "velocity_smoother"

    def configure(self) -> None:
        config = self.config
        if config.use_realtime_priority:
            self.process.use_realtime_priority()
        self._smoother = VelocitySmoother(config)
        self._recent = RecentVelocities(config.odom_duration)
        self._stamp = 0.0
        stamped = config.enable_stamped_cmd_vel
        self._output = VelocityOutput(self, stamped, topic=config.cmd_vel_out_topic)
        subscribe_velocity(self, config.cmd_vel_in_topic, stamped, self._on_command, self._on_stamp)
        if config.feedback == "CLOSED_LOOP":
            profile, advice = qos.SENSOR_SUBSCRIPTION, "set odom_topic"
            of = Silence(Odometry, "odometry message", profile, advice, rare=True)
            subscribe_watched(self, config.odom_topic, of, self._on_odometry)
        self._smoothing = self.guarded("carry_on", self._smooth_if_due)
        self.every(1.0 / config.smoothing_frequency, self._carry_on)

    def activate(self) -> None:
        self._smoother = VelocitySmoother(self.config)

    def deactivate(self) -> None:
        self._output.stop()

    def on_time_jump(self) -> None:
        """Start from rest: the last command belongs to another time."""
        if self.active:
            self._output.stop()
            self.activate()

    def on_config(self, config: VelocitySmootherConfig) -> None:
        self._smoother = VelocitySmoother(config)
        self._recent = RecentVelocities(config.odom_duration)

    def _on_stamp(self, stamp: float) -> None:
        self._stamp = stamp

    def _on_command(self, velocity: Velocity) -> None:
        self._smoother.take(velocity, self.now)
        if self.config.smooth_at_once:
            self._smooth()

    def _on_odometry(self, message: Any) -> None:
        stamp = seconds(message.header.stamp)
        self._recent.add(velocity_from_twist(message.twist.twist), stamp)

    def _carry_on(self) -> None:
        """Continue the last command, unless one comes just now."""
        self.process.later(self._smoothing)

    def _smooth_if_due(self) -> None:
        if self.active and self._smoother.is_due(self.now):
            self._smooth()

    def _smooth(self) -> None:
        velocity = self._smoother.tick(self._recent.mean(), self.now)
        if velocity is None:
            return
        holds = self._smoother.has_command(self.now)
        own = self.config.stamp_smoothed_velocity_with_smoothing_time or not holds
        self._output.publish(velocity, self.now if own else self._stamp)
