"""A node that does a little of everything."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from geometry_msgs.msg import Twist
from nav2_msgs.action import Wait

from arjuna_core.config import param
from arjuna_core.ros import qos
from arjuna_core.ros.goal_server import GoalServer
from arjuna_core.ros.node import ManagedNode


@dataclass(frozen=True)
class EchoConfig:
    """Parameters of the node under test."""

    gain: float = param(2.0, "Factor.", minimum=0.0, maximum=10.0)
    names: tuple[str, ...] = param(("a",), "Names.")
    others: tuple[str, ...] = param((), "Other names, whose type an empty list does not show.")


class EchoNode(ManagedNode):
    """Scales velocities, counts periods and runs Wait goals until asked to end them."""

    Config = EchoConfig
    DEFAULT_NAME = "echo"

    def configure(self) -> None:
        self.ticks: list[float] = []
        self.out = self.publisher(Twist, "out", qos.DEFAULT)
        self.subscribe(Twist, "in", self._on_twist, qos.DEFAULT)
        self.every(0.1, lambda: self.ticks.append(self.now))
        self.server = self.keep(GoalServer(self, Wait, "wait"))

    def _on_twist(self, message: Any) -> None:
        scaled = Twist()
        scaled.linear.x = message.linear.x * self.config.gain
        self.out.publish(scaled)
