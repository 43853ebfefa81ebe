"""Node collision_monitor: cmd_vel_smoothed in, cmd_vel out, as in Nav2's chain."""

from __future__ import annotations

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
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.nodes.costmap.node import CostmapNode
from arjuna_nav.nodes.velocity import VelocityOutput, subscribe_velocity
from arjuna_nav.safety.collision_monitor import CollisionMonitor, MonitorConfig, Verdict
from arjuna_nav.safety.zones import Action

_BLIND = "invalid source"


@dataclass(frozen=True)
class CollisionMonitorConfig(MonitorConfig):
    """Parameters of the node `collision_monitor`, by Nav2's names."""

    base_frame_id: str = param("base_link", "Frame of the robot.", read_only=True)
    odom_frame_id: str = param("odom", "Frame in which what is seen stays put.", read_only=True)
    cmd_vel_in_topic: str = param("cmd_vel_smoothed", "Topic of the commands.", read_only=True)
    cmd_vel_out_topic: str = param("cmd_vel", "Topic of what to drive.", read_only=True)
    state_topic: str = param("collision_monitor_state", "Topic of what is done.", read_only=True)
    scan_topic: str = param("scan", "Topic of the scans.", read_only=True)
    source_timeout: float = param(1.0, "How old a scan may be.", unit="s", minimum=0.0)
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
        self._told = Verdict(STILL)
        self._moved_at = 0.0
        stamped = config.enable_stamped_cmd_vel
        self._output = VelocityOutput(self, stamped, config.base_frame_id, config.cmd_vel_out_topic)
        self._state = self.publisher(CollisionMonitorState, config.state_topic, qos.LATCHED)
        self.subscribe(LaserScan, config.scan_topic, self._on_scan, qos.SENSOR_SUBSCRIPTION)
        subscribe_velocity(self, config.cmd_vel_in_topic, stamped, self._on_command)
        self.serve(Toggle, f"{self.get_name()}/toggle", self._on_toggle)

    def activate(self) -> None:
        """Judge by what is seen from now on."""
        self._scan, self._moved_at = None, self.now

    def on_time_jump(self) -> None:
        """Forget what was seen in another run of time."""
        if self.active:
            self.activate()

    def on_config(self, config: CollisionMonitorConfig) -> None:
        """Judge by the new parameters from now on."""
        self._monitor = CollisionMonitor(config)
        self._enabled = config.enabled

    def _on_scan(self, message: Any) -> None:
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
        try:
            points = self._points()
        except TransformError as error:
            self.get_logger().warning(f"blind: {error}", throttle_duration_sec=1.0)
            points = None
        if points is None:
            return Verdict(STILL, Action.STOP, _BLIND)
        return self._monitor.judge(velocity, points, self._costmap.layered.footprint)

    def _points(self) -> NDArray[np.float64] | None:
        """Return what was last seen from where the robot is now; None if that is too old."""
        config, message = self.config, self._scan
        if message is None:
            return None
        stamp = seconds(message.header.stamp)
        if self.now - stamp > config.source_timeout:
            return None
        base, odom = config.base_frame_id, config.odom_frame_id
        T_base_sensor = self.transforms.lookup(base, message.header.frame_id.lstrip("/"))
        known = min(stamp, self.transforms.latest_common(odom, base))
        T_odom_then = self.transforms.lookup(odom, base, known)
        T_now_then = self.transforms.lookup(base, odom) @ T_odom_then
        return T_now_then.apply(scan_from_msg(message, T_base_sensor).points())

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
