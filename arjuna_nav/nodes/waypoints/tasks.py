"""Tasks at waypoints: waiting for a time or a message, taking a picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

from std_msgs.msg import Empty

from arjuna_core.config import duration_param, fixed, param
from arjuna_core.plugins import PluginTypes
from arjuna_core.ros import qos
from arjuna_core.ros.node import ManagedNode


class WaypointTask(Protocol):
    """A task at a waypoint; made of `(config, node)` in the node's `configure`.

    A class has `Config`, the frozen dataclass of its parameters.

    Attributes:
        problem: Why it failed, once `tick` returned False.
    """

    problem: str

    def start(self, pose: Any, index: int, now: float) -> None:
        """Begin at a waypoint, a PoseStamped and its number, at a time [s]."""
        ...

    def tick(self, now: float) -> bool | None:
        """Return whether it succeeded, None while it runs; it must not block."""
        ...


@dataclass(frozen=True)
class WaitConfig:
    """Parameters of a wait."""

    enabled: bool = param(True, "Whether to wait.")
    waypoint_pause_duration: int = param(0, "How long to wait.", unit="ms")


class WaitAtWaypoint:
    """Waits.

    Source: nav2_waypoint_follower, WaitAtWaypoint.
    """

    Config: ClassVar[type[Any]] = WaitConfig

    def __init__(self, config: Any, node: ManagedNode) -> None:
        self._config = config
        self._until = 0.0
        self.problem = ""

    def start(self, pose: Any, index: int, now: float) -> None:
        pause = self._config.waypoint_pause_duration / 1000.0 if self._config.enabled else 0.0
        self._until = now + pause

    def tick(self, now: float) -> bool | None:
        return True if now >= self._until else None


@dataclass(frozen=True)
class InputConfig:
    """Parameters of a wait for a message."""

    enabled: bool = param(True, "Whether to wait.")
    timeout: float = duration_param(10.0, "How long to wait.")
    input_topic: str = fixed("input_at_waypoint/input", "Topic of the message, a std_msgs/Empty.")


class InputAtWaypoint:
    """Waits for a message; without one in time it fails.

    Source: nav2_waypoint_follower, InputAtWaypoint.
    """

    Config: ClassVar[type[Any]] = InputConfig

    def __init__(self, config: Any, node: ManagedNode) -> None:
        self._config = config
        self._came, self._until = False, 0.0
        self.problem = ""
        node.subscribe(Empty, config.input_topic, self._on_input, qos.DEFAULT)

    def _on_input(self, message: Any) -> None:
        self._came = True

    def start(self, pose: Any, index: int, now: float) -> None:
        self._came, self._until = False, now + self._config.timeout

    def tick(self, now: float) -> bool | None:
        if self._came or not self._config.enabled:
            return True
        if now < self._until:
            return None
        self.problem = f"nothing came on {self._config.input_topic} in {self._config.timeout:g} s"
        return False


TASKS = PluginTypes(
    "waypoint task",
    {
        "nav2_waypoint_follower::WaitAtWaypoint": f"{__name__}:WaitAtWaypoint",
        "nav2_waypoint_follower::PhotoAtWaypoint": f"{__package__}.photo:PhotoAtWaypoint",
        "nav2_waypoint_follower::InputAtWaypoint": f"{__name__}:InputAtWaypoint",
    },
    "nav2_waypoint_follower::WaitAtWaypoint",
    stands_in=True,
)
"""Waypoint tasks by Nav2's class names."""
