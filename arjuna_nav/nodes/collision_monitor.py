"""Node collision_monitor: cmd_vel_smoothed in, cmd_vel out, as in Nav2's chain."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
from nav2_msgs.msg import CollisionMonitorState
from nav2_msgs.srv import Toggle
from numpy.typing import NDArray
from sensor_msgs.msg import LaserScan

from arjuna_core.config import param
from arjuna_core.ros import qos
from arjuna_core.ros.convert import scan_from_msg, seconds
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.costmap.moving.tracker import REACH, Moving, Tracker
from arjuna_nav.nodes.costmap.node import CostmapNode
from arjuna_nav.nodes.velocity import VelocityOutput, subscribe_velocity
from arjuna_nav.safety.base import Action
from arjuna_nav.safety.collision_monitor import CollisionMonitor, MonitorConfig, Verdict

_BLIND = "invalid source"
_INTERVALS = 5  # between scans of which the shortest is the scanner's period
_UNKNOWN_INTERVAL = 0.4  # [s] before two scans have come
_PERIODS = 2.5  # of the scanner, that a scan may be old
_SLOWS = 0.4  # of that time, in which the robot slows down to a stop


@dataclass(frozen=True)
class CollisionMonitorConfig(MonitorConfig):
    """Parameters of the node `collision_monitor`, by Nav2's names."""

    base_frame_id: str = param(
        "", "Frame of the robot; empty: the local costmap's.", read_only=True
    )
    odom_frame_id: str = param(
        "", "Frame in which what is seen stays put; empty: the local costmap's.", read_only=True
    )
    cmd_vel_in_topic: str = param("cmd_vel_smoothed", "Topic of the commands.", read_only=True)
    cmd_vel_out_topic: str = param("cmd_vel", "Topic of what to drive.", read_only=True)
    state_topic: str = param("collision_monitor_state", "Topic of what is done.", read_only=True)
    scan_topic: str = param(
        "", "Topic of the scans; empty: the local costmap's, or none.", read_only=True
    )
    source_timeout: float = param(
        0.3,
        "How old a scan may be; never less than 2.5 of its periods. The robot slows down where none"
        " has come for three fifths of that.",
        unit="s",
        minimum=0.0,
    )
    stop_pub_timeout: float = param(2.0, "How long zero is repeated.", unit="s", minimum=0.0)
    enabled: bool = param(True, "Whether it looks at all; else commands pass.")
    enable_stamped_cmd_vel: bool = param(False, "Whether both are TwistStamped.", read_only=True)


class CollisionMonitorNode(ManagedNode):
    """Passes each command on, as far as what is seen allows; without sight the robot stands."""

    Config = CollisionMonitorConfig
    DEFAULT_NAME = "collision_monitor"

    def configure(self) -> None:
        """Create the monitor and its interfaces."""
        config = self.config
        self._costmap: CostmapNode = self.process.find("local_costmap/local_costmap")
        self._monitor = CollisionMonitor(config)
        self._enabled = config.enabled
        self._scan: Any | None = None
        self._tracker, self._moving = Tracker(REACH), Moving.nothing()
        self._intervals: deque[float] = deque(maxlen=_INTERVALS)
        self._heard = 0.0
        self._told = Verdict(STILL)
        self._moved_at = 0.0
        stamped, near = config.enable_stamped_cmd_vel, self._costmap.config
        self._base = config.base_frame_id or near.robot_base_frame
        self._odom = config.odom_frame_id or near.global_frame
        self._output = VelocityOutput(self, stamped, self._base, config.cmd_vel_out_topic)
        self._state = self.publisher(CollisionMonitorState, config.state_topic, qos.LATCHED)
        self._topic = config.scan_topic or self._costmap.scan_topic
        if self._topic:
            self.subscribe(LaserScan, self._topic, self._on_scan, qos.SENSOR_SUBSCRIPTION)
        subscribe_velocity(self, config.cmd_vel_in_topic, stamped, self._on_command)
        self.serve(Toggle, f"{self.get_name()}/toggle", self._on_toggle)

    def activate(self) -> None:
        """Judge by what is seen from now on."""
        self._scan, self._moved_at = None, self.now
        self._tracker, self._moving = Tracker(REACH), Moving.nothing()
        self._intervals.clear()

    def on_time_jump(self) -> None:
        """Forget what was seen in another run of time."""
        if self.active:
            self.activate()

    def on_config(self, config: CollisionMonitorConfig) -> None:
        """Judge by the new parameters from now on."""
        self._monitor = CollisionMonitor(config)
        self._enabled = config.enabled

    def _on_scan(self, message: Any) -> None:
        stamp, before = seconds(message.header.stamp), -math.inf
        if self._scan is not None:
            before = seconds(self._scan.header.stamp)
            self._intervals.append(stamp - before)
        if stamp > before:
            self._heard = self.now
        self._scan = message

    def _on_toggle(self, request: Any, response: Any) -> Any:
        self._enabled = request.enable
        response.success = True
        response.message = f"collision monitoring is {'on' if request.enable else 'off'}"
        return response

    def _on_command(self, velocity: Velocity) -> None:
        verdict = self._judge(velocity) if self._enabled else Verdict(velocity)
        self._tell(verdict)
        if verdict.velocity != STILL:
            self._moved_at = self.now
        if self.now - self._moved_at <= self.config.stop_pub_timeout:
            self._output.publish(verdict.velocity)

    def _judge(self, velocity: Velocity) -> Verdict:
        if not self._topic:
            return Verdict(velocity)
        seen = self._seen()
        if seen is None:
            return Verdict(STILL, Action.STOP, _BLIND)
        trust = self._trust()
        padding = self._costmap.config.footprint_padding
        outline = self._costmap.layered.footprint.without(padding)
        slowed = Velocity(velocity.v * trust, velocity.w * trust)
        verdict = self._monitor.judge(slowed, seen[0], outline, seen[1], self._moving.speeds)
        if trust < 1.0 and verdict.action is Action.DO_NOTHING:
            return Verdict(slowed, Action.SLOWDOWN, _BLIND)
        return verdict

    def _trust(self) -> float:
        """Return which share of its speed the robot may keep, by when the last new scan came.

        Not by its stamp: that is of the scan's first ray, a period before the scan is whole.
        """
        patience = self._patience()
        return min((patience - (self.now - self._heard)) / max(_SLOWS * patience, 1e-3), 1.0)

    def _seen(self) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Return what was last seen from where the robot is now, and how it moves; None if blind.

        What moves has moved on since.
        """
        message = self._scan
        if message is None or self._trust() <= 0.0 or self._age(message) > self._patience():
            return None
        stamp = seconds(message.header.stamp)
        transforms, base, odom = self.transforms, self._base, self._odom
        try:
            T_base_sensor = transforms.lookup(base, message.header.frame_id.lstrip("/"))
            T_odom_then = transforms.lookup(
                odom, base, min(stamp, transforms.latest_common(odom, base))
            )
            T_now_odom = transforms.lookup(base, odom)
        except TransformError as error:
            self.get_logger().warning(f"blind: {error}", throttle_duration_sec=1.0)
            return None
        if stamp != self._moving.stamp:
            self._moving = self._tracker.update(scan_from_msg(message, T_base_sensor), T_odom_then)
        moving, turn = self._moving, SE2(0.0, 0.0, T_now_odom.theta)
        points = moving.points + (self.now - stamp) * moving.velocities
        return T_now_odom.apply(points), turn.apply(moving.velocities)

    def trouble(self) -> str:
        """Say since when nothing is seen."""
        if not (self.active and self._topic and self._enabled):
            return ""
        if self._scan is None:
            return f"the robot is held: no scan has come on {self._topic}"
        age = self._age(self._scan)
        if age <= self._patience():
            return ""
        return f"the robot is held: the last scan on {self._topic} is {age:.2f} s old"

    def _age(self, scan: Any) -> float:
        return self.now - seconds(scan.header.stamp)

    def _patience(self) -> float:
        """Return how old a scan may be [s]; a scanner that turns slowly is not taken for dead."""
        period = min(self._intervals, default=_UNKNOWN_INTERVAL)
        return max(float(self.config.source_timeout), _PERIODS * period)

    def _tell(self, verdict: Verdict) -> None:
        """Publish what is done, where it is not what was done before."""
        if (verdict.action, verdict.zone) == (self._told.action, self._told.zone):
            return
        self._told = verdict
        name = verdict.zone
        self._state.publish(
            CollisionMonitorState(action_type=int(verdict.action), polygon_name=name)
        )
        self.get_logger().info(f"{verdict.action.name} {name}".rstrip())
