"""joint_state_publisher: a state for every joint of a description, from sources or by default."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from sensor_msgs.msg import JointState
from std_msgs.msg import String

from arjuna_core.config import NoParameters, fixed, param
from arjuna_core.errors import RobotError
from arjuna_core.plugins import names_below, with_configs, with_values
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.inputs import described
from arjuna_sim.model.urdf import Joint, Mimic

SLIDERS = "joint_state_publisher_gui/positions"
"""The topic of the view's sliders."""


@dataclass(frozen=True)
class DependentConfig:
    """Parameters of a joint that follows another."""

    parent: str = fixed("", "The joint that it follows.")
    factor: float = param(1.0, "Its position for a unit of the other's.")
    offset: float = param(0.0, "Its position where the other's is 0.")


@dataclass(frozen=True)
class JointStatePublisherConfig:
    """Parameters of `joint_state_publisher`; `zeros.JOINT` and `dependent_joints.JOINT.*` too."""

    robot_description: str = fixed("", "The text of a URDF; empty for the topic's.")
    rate: float = param(10.0, "Rate of the output.", unit="Hz", minimum=0.1, maximum=1000.0)
    publish_default_positions: bool = param(True, "Whether joints without a source have positions.")
    publish_default_velocities: bool = param(False, "Whether they have velocities.")
    publish_default_efforts: bool = param(False, "Whether they have efforts.")
    use_mimic_tags: bool = param(True, "Whether <mimic> of the description counts.")
    use_smallest_joint_limits: bool = param(True, "Has no effect: the limits are <limit>'s.")
    source_list: tuple[str, ...] = fixed((), "Topics of joint states.")
    sliders: bool = fixed(False, "Whether the sliders of the view are one, as of its _gui.")
    delta: float = param(0.0, "How far positions move at each output, to and fro.", unit="rad, m")
    zeros: NoParameters = field(default_factory=NoParameters)
    dependent_joints: NoParameters = field(default_factory=NoParameters)

    @classmethod
    def config_for(cls, values: Mapping[str, Any]) -> type[JointStatePublisherConfig]:
        """Return the class with the joints that values name."""
        zeros = tuple(key.partition(".")[2] for key in values if key.startswith("zeros."))
        dependent = names_below(values, "dependent_joints")
        own = tuple((name, DependentConfig) for name in dependent)
        at_rest = with_values(NoParameters, zeros, 0.0, "Its position without a source.")
        parts = ("zeros", at_rest), ("dependent_joints", with_configs(NoParameters, own))
        return with_configs(cls, parts)


class JointStatePublisherNode(ManagedNode):
    """Publishes `joint_states` of the joints of `robot_description`."""

    Config = JointStatePublisherConfig
    DEFAULT_NAME = "joint_state_publisher"

    def configure(self) -> None:
        """Create the topics."""
        config: JointStatePublisherConfig = self.config
        self._joints: dict[str, Joint] = {}
        self._states: dict[str, dict[str, float]] = {}
        self._forward: dict[str, bool] = {}
        self._out = self.publisher(JointState, "joint_states", qos.DEFAULT)
        for topic in (*config.source_list, *([SLIDERS] if config.sliders else [])):
            self.subscribe(JointState, topic, self._on_source, qos.DEFAULT)
        if config.robot_description:
            self._describe(config.robot_description)
        else:
            self.subscribe(
                String, "robot_description", self._on_description, qos.LATCHED, while_inactive=True
            )
        self.every(1.0 / config.rate, self._publish)

    def _on_description(self, message: Any) -> None:
        try:
            self._describe(message.data)
        except RobotError as error:
            self.get_logger().error(str(error))

    def _describe(self, text: str) -> None:
        """Take the joints of a description, each in the middle of limits that exclude 0."""
        joints = described(text).joints
        self._joints = {name: joint for name, joint in joints.items() if joint.has_position}
        self._states = {}
        for name, joint in self._joints.items():
            low, high = joint.limits or (-math.pi, math.pi)
            start = 0.0 if low <= 0.0 <= high else (low + high) / 2.0
            self._states[name] = {"position": getattr(self.config.zeros, name, start)}

    def _on_source(self, message: Any) -> None:
        for part in ("position", "velocity", "effort"):
            for name, value in zip(message.name, getattr(message, part), strict=False):
                if name in self._states:
                    self._states[name][part] = value

    def _follows(self, name: str) -> Mimic | None:
        """Return what a joint follows, if anything."""
        own = getattr(self.config.dependent_joints, name, None)
        if own is not None:
            return Mimic(own.parent, own.factor, own.offset)
        return self._joints[name].mimic if self.config.use_mimic_tags else None

    def _value(self, name: str, part: str, depth: int = 0) -> float:
        follows = self._follows(name)
        if follows is None or follows.joint not in self._states or depth > len(self._states):
            return self._states[name].get(part, 0.0)
        offset = follows.offset if part == "position" else 0.0
        return follows.multiplier * self._value(follows.joint, part, depth + 1) + offset

    def _move(self) -> None:
        """Move each position by `delta` within its limits."""
        for name, joint in self._joints.items():
            low, high = joint.limits or (-math.pi, math.pi)
            forward = self._forward.get(name, True)
            moved = self._states[name]["position"] + (1 if forward else -1) * self.config.delta
            self._forward[name] = moved < high if forward else moved <= low
            self._states[name]["position"] = min(max(moved, low), high)

    def _publish(self) -> None:
        config: JointStatePublisherConfig = self.config
        if not self._joints:
            return
        if config.delta > 0.0:
            self._move()
        message = JointState(header=header("", self.now), name=list(self._joints))
        has_default = {
            "position": config.publish_default_positions,
            "velocity": config.publish_default_velocities,
            "effort": config.publish_default_efforts,
        }
        for part, always in has_default.items():
            if always or any(part in state for state in self._states.values()):
                setattr(message, part, [self._value(name, part) for name in self._joints])
        self._out.publish(message)
