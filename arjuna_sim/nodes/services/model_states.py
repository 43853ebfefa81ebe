"""gazebo_msgs/ModelStates: where all entities are, as Gazebo Classic's gazebo_ros_state says it."""

from __future__ import annotations

from typing import Any

from gazebo_msgs.msg import ModelStates

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.nodes.messages import WORLD
from arjuna_sim.nodes.services.known_entities import KnownEntities

_TOPICS = "gazebo/model_states", "model_states"
_PERIOD = 0.1  # [s]; most worlds that have the plug-in ask for 10 Hz


class StatesOfModels:
    """Publishes on a topic once somebody listens to it; nobody else sees it."""

    def __init__(self, node: ManagedNode, known: KnownEntities) -> None:
        self._node, self._known = node, known
        self._out: dict[str, Any] = {}
        if node.transport is None:  # else nobody listens but nodes of this process
            node.every(_PERIOD, self._publish)

    def message(self) -> ModelStates:
        """Return the poses and velocities of all entities in the world's frame."""
        message = ModelStates(header=header(WORLD, self._node.now))
        for entity in self._known.all():
            state = self._known.state(entity)
            message.name.append(entity.name)
            message.pose.append(state.pose)
            message.twist.append(state.twist)
        return message

    def _publish(self) -> None:
        node = self._node
        for topic in _TOPICS:
            if topic not in self._out and node.count_subscribers(node.process.absolute(topic)):
                self._out[topic] = node.publisher(ModelStates, topic, qos.DEFAULT)
        read = [out for out in self._out.values() if out.get_subscription_count()]
        if read:
            message = self.message()
            for out in read:
                out.publish(message)
