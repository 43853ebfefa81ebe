"""Commands of a world's models that move by themselves."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import Twist

from arjuna_core.ros import qos
from arjuna_core.ros.node import ManagedNode
from arjuna_core.twist import Velocity
from arjuna_sim.model.world import World
from arjuna_sim.physics.stage import Stage


class MoverTopics:
    """Takes velocities of the movers of the world that is there, each from its own topic."""

    def __init__(self, node: ManagedNode, stage: Stage) -> None:
        self._node, self._stage = node, stage
        self._world: World | None = None
        self._heard: list[Any] = []
        self.follow()

    def follow(self) -> None:
        """Listen to those of another world, where that has been loaded."""
        world = self._stage.world
        if world is self._world:
            return
        for subscription in self._heard:
            self._node.unsubscribe(subscription)
        self._world, self._heard = world, []
        for name, mover in world.movers.items():

            def command(message: Twist, name: str = name) -> None:
                x, y, turn = message.linear.x, message.linear.y, message.angular.z
                self._stage.movers.command(name, Velocity(x, y=y, yaw_rate=turn))

            heard = self._node.subscribe(Twist, mover.topic, command, qos.LATEST)
            self._heard.append(heard)
