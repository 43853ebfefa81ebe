"""Nav2's conditions of the robot itself: whether it moves, its battery, its frames.

Source: nav2_behavior_tree, plugins/condition.
"""

from __future__ import annotations

import math
from typing import ClassVar

from arjuna_core.twist import Velocity
from arjuna_nav.trees.exchange import Battery, Heard, Topic
from arjuna_nav.trees.nav2.conditions import Condition
from arjuna_nav.trees.node import Status, TreeNode
from arjuna_nav.trees.ports import NUMBER, REQUIRED, TEXT, TRUTH, Port

_BRAKES = 10.0  # harder than a robot brakes by itself: it was stopped, as in Nav2 [m/s^2]


class IsStuck(Condition):
    """Whether the robot was stopped at once, as by a wall, between its last two odometries."""

    _last: tuple[float, float] | None = None
    _stuck = False

    def holds(self) -> bool:
        """Compare its speed with the one measured before."""
        state = self.running.state
        now, speed = state.measured_at, abs(state.velocity.x)
        if self._last is not None and now > self._last[0]:
            self._stuck = (self._last[1] - speed) / (now - self._last[0]) > _BRAKES
        self._last = now, speed
        return self._stuck


class IsStopped(TreeNode):
    """Whether the robot has stood for a while; it runs while it stands not long enough."""

    PORTS: ClassVar[dict[str, Port]] = {
        "velocity_threshold": Port(NUMBER, 0.01),
        "duration_stopped": Port(NUMBER, 1000.0),  # [ms]
    }
    _since = math.inf

    def tick(self) -> Status:
        """Count from when it was first seen to stand."""
        now, velocity = self.running.state.now, self.running.state.velocity
        if _fastest(velocity) >= self.get("velocity_threshold"):
            self._since = math.inf
            return Status.FAILURE
        self._since = min(self._since, now)
        if now - self._since <= self.get("duration_stopped") / 1000.0:
            return Status.RUNNING
        self._since = math.inf
        return Status.SUCCESS


class TransformAvailable(Condition):
    """Whether a transform is known; where it once was, it is."""

    PORTS: ClassVar[dict[str, Port]] = {
        "child": Port(TEXT, REQUIRED),
        "parent": Port(TEXT, REQUIRED),
    }
    _known = False

    def holds(self) -> bool:
        """Look for it."""
        connected = self.running.state.connected
        self._known = self._known or connected(self.get("parent"), self.get("child"))
        return self._known


class _OfBattery(Condition):
    """A condition of a battery; it is not so while nothing is known of one."""

    PORTS: ClassVar[dict[str, Port]] = {"battery_topic": Port(TEXT, "/battery_status")}

    def topics(self) -> set[Topic]:
        """Return the battery's topic."""
        return {Topic(Heard.BATTERY, self.topic("battery_topic"))}

    def holds(self) -> bool:
        """Judge the battery."""
        battery = self.running.state.batteries.get(self.topic("battery_topic"))
        return battery is not None and self.judge(battery)

    def judge(self, battery: Battery) -> bool:
        """Tell whether it is so."""
        raise NotImplementedError


class IsBatteryLow(_OfBattery):
    """Whether a battery has no more than some share (0..1), or voltage, left."""

    PORTS: ClassVar[dict[str, Port]] = {
        **_OfBattery.PORTS,
        "min_battery": Port(NUMBER, REQUIRED),
        "is_voltage": Port(TRUTH, False),
    }

    def judge(self, battery: Battery) -> bool:
        """Compare what is left."""
        left = battery.voltage if self.get("is_voltage") else battery.share
        return bool(left <= self.get("min_battery"))


class IsBatteryCharging(_OfBattery):
    """Whether a battery is being charged."""

    def judge(self, battery: Battery) -> bool:
        """Tell what it says."""
        return battery.charges


def _fastest(velocity: Velocity) -> float:
    return max(abs(velocity.x), abs(velocity.yaw_rate))
