"""Poses of all entities, on the topics of Gazebo that somebody listens to.

Gazebo Classic's gazebo_ros_state has them as `gazebo_msgs/ModelStates`; what ros_gz_bridge makes of
gz-sim's PosePublisher (`/model/NAME/pose`) and SceneBroadcaster (`/world/NAME/dynamic_pose/info`,
`/world/NAME/pose/info`) is of the type that the bridge's user names.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gazebo_msgs.msg import ModelStates
from geometry_msgs.msg import Pose, PoseArray, PoseStamped, Transform, TransformStamped
from tf2_msgs.msg import TFMessage

from arjuna_core.pose3 import Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, pose3_from_transform, pose3_msg, transform3_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.model.entities import POSES, Category, Entity
from arjuna_sim.model.robot import SOLO
from arjuna_sim.model.settings import PublishedPoses, spelled
from arjuna_sim.nodes.messages import WORLD, pose3_from_msg
from arjuna_sim.nodes.services.known_entities import KnownEntities

_STATES = ("/gazebo/model_states", "/model_states")
_LOOK = 0.5  # [s] between looks at who listens
_STATES_PERIOD = 0.1  # [s]; most worlds that have the plug-in ask for 10 Hz
_POSES_PERIOD = 0.02  # [s] of what gz-sim publishes at 60 Hz or each step
_TYPES = {
    "gazebo_msgs/msg/ModelStates": ModelStates,
    "tf2_msgs/msg/TFMessage": TFMessage,
    "geometry_msgs/msg/PoseArray": PoseArray,
    "geometry_msgs/msg/Pose": Pose,
    "geometry_msgs/msg/PoseStamped": PoseStamped,
    "geometry_msgs/msg/Transform": Transform,
    "geometry_msgs/msg/TransformStamped": TransformStamped,
}

_FIXED = Category.STATIC_OBJECT


def messages_of(kind: Any, found: list[TransformStamped]) -> list[Any]:
    """Return poses as messages of a type that bridges make of gz-sim's `Pose` and `Pose_V`."""
    if kind is TFMessage:
        return [TFMessage(transforms=found)]
    if kind is TransformStamped:
        return found
    if kind is Transform:
        return [T.transform for T in found]
    poses = [pose3_msg(pose3_from_transform(T.transform)) for T in found]
    if kind is Pose:
        return poses
    if kind is PoseArray:
        return [PoseArray(header=T.header, poses=poses) for T in found[:1]]
    return [PoseStamped(header=T.header, pose=p) for T, p in zip(found, poses, strict=True)]


class EntityTopics:
    """Publishes on a topic once somebody listens to it; nobody else sees it."""

    def __init__(self, node: ManagedNode, known: KnownEntities) -> None:
        self._node, self._known = node, known
        self._out: dict[tuple[str, Any], Any] = {}
        self._states = [node.process.absolute(topic) for topic in _STATES]
        if node.transport is None:  # else nobody listens but nodes of this process
            node.every(_LOOK, self._look)
            node.every(_STATES_PERIOD, self._publish_states)
            node.every(_POSES_PERIOD, self._publish_poses)

    def states(self) -> ModelStates:
        """Return the poses and velocities of all entities in the world's frame."""
        message = ModelStates(header=header(WORLD, self._node.now))
        for entity in self._known.all():
            state = self._known.state(entity)
            message.name.append(entity.name)
            message.pose.append(state.pose)
            message.twist.append(state.twist)
        return message

    def poses(self, topic: str) -> list[TransformStamped]:
        """Return what is on a topic of poses: models in the world, and robots' links in theirs.

        A robot's own topic has the poses that its PosePublisher selects, its own without one; the
        simulator's own robot is there under any name, as on the other topics of a bridge.
        """
        found, entities = POSES.fullmatch(topic), self._known.all()
        if found is None:
            return []
        name = found["model"]
        if name is None:
            chosen = [e for e in entities if not found["moving"] or e.category is not _FIXED]
            both = PublishedPoses(of_model=True, of_links=True)
            return [T for each in chosen for T in self._of(each, each.name, both)]
        robots = ((entity, self._known.robot(entity)) for entity in entities)
        own = [entity for entity, robot in robots if robot is not None and robot.name == SOLO]
        named = (e for e in entities if spelled(e.name) == name)
        one = next((e for e in [*named, *own]), None)
        robot = None if one is None else self._known.robot(one)
        asked = PublishedPoses() if robot is None else robot.model.settings.poses
        return [] if one is None else list(self._of(one, name, asked))

    def _of(self, entity: Entity, name: str, asked: PublishedPoses) -> Iterator[TransformStamped]:
        """Yield an entity's pose, and those of a robot's links that move in it, the root first."""
        now = self._node.now
        if asked.of_model:
            yield transform3_msg(pose3_from_msg(self._known.state(entity).pose), WORLD, name, now)
        robot = self._known.robot(entity)
        if asked.of_links and robot is not None:
            urdf, joints = robot.model.urdf, robot.joints()
            yield transform3_msg(Pose3(), name, f"{name}/{urdf.root}", now)
            at = dict(zip(joints.names, joints.positions.tolist(), strict=True))
            for joint in joints.names:
                link = urdf.joints[joint].child
                yield transform3_msg(urdf.T_root(link, at), name, f"{name}/{link}", now)

    def _look(self) -> None:
        """Advertise what somebody listens to and is not there yet."""
        for topic, kinds in self._node.get_topic_names_and_types():
            is_state = topic in self._states
            if not is_state and POSES.fullmatch(topic) is None:
                continue
            for kind in (_TYPES[name] for name in kinds if name in _TYPES):
                if (kind is ModelStates) == is_state and (topic, kind) not in self._out:
                    made = self._node.publisher(kind, topic, qos.DEFAULT)
                    self._out[topic, kind] = made

    def _publish_states(self) -> None:
        for (_, kind), out in self._out.items():
            if kind is ModelStates and _is_read(out):
                out.publish(self.states())

    def _publish_poses(self) -> None:
        for (topic, kind), out in self._out.items():
            if kind is not ModelStates and _is_read(out):
                for message in messages_of(kind, self.poses(topic)):
                    out.publish(message)


def _is_read(out: Any) -> bool:
    return bool(out.get_subscription_count())
