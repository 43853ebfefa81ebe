"""A robot description: links, and the joints that connect them to a tree."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.geometry.shapes import Inertial, Part

JOINT_KINDS = ("fixed", "continuous", "revolute", "prismatic", "floating", "planar")
_LOOSE = ("floating", "planar")


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: its position is `multiplier * other + offset`."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Joint:
    """A connection of two links.

    Attributes:
        kind: One of `JOINT_KINDS`.
        parent: The link that carries it.
        child: The link it carries.
        T_parent_child: The child's pose in the parent's frame at joint position 0.
        axis: Axis in the child's frame, a unit vector; of a planar joint the plane's normal.
        limits: Least and greatest position [rad or m], None where unlimited.
        mimic: What it follows, if anything.
        damping: Per speed [N m s/rad or N s/m].
        friction: Dry friction [N m or N].
        max_speed: Greatest speed, 0 for none [rad/s or m/s].
        max_effort: Greatest effort of a motor, 0 for none [N m or N].
        stiffness: Of a spring, 0 for none [N m/rad or N/m].
        spring_at: Position at which that is at rest [rad or m].
    """

    name: str
    kind: str
    parent: str
    child: str
    T_parent_child: Pose3
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    limits: tuple[float, float] | None = None
    mimic: Mimic | None = None
    damping: float = 0.0
    friction: float = 0.0
    max_speed: float = 0.0
    max_effort: float = 0.0
    stiffness: float = 0.0
    spring_at: float = 0.0

    @property
    def has_position(self) -> bool:
        """True where one number is its position."""
        return self.kind not in ("fixed", *_LOOSE)

    def at(self, position: float) -> Pose3:
        """Return the child's pose in the parent's frame at a joint position [rad or m]."""
        x, y, z = self.axis
        if self.kind == "prismatic":
            return self.T_parent_child @ Pose3((x * position, y * position, z * position))
        c, s = math.cos(position / 2), math.sin(position / 2)
        return self.T_parent_child @ Pose3(quaternion=(c, s * x, s * y, s * z))


@dataclass(frozen=True)
class Hinge:
    """How an entity may move on the world, or on another.

    Attributes:
        slides: Whether it slides along the axis rather than turns about it.
        axis: In the entity's frame, a unit vector; None for a ball, which turns about any.
        anchor: A point of the axis in the entity's frame [m].
        limits: Least and greatest position [rad or m], None where unlimited.
        damping: Per speed [N m s/rad or N s/m].
        friction: Dry friction [N m or N].
        stiffness: Of a spring, 0 for none [N m/rad or N/m].
        spring_at: Position at which that is at rest [rad or m].
        further: A second axis through the anchor, which the first turns, of a universal joint.
        runs: Whether it is a belt, which runs on the spot and which nothing else moves.
    """

    slides: bool
    axis: tuple[float, float, float] | None
    anchor: tuple[float, float, float] = (0.0, 0.0, 0.0)
    limits: tuple[float, float] | None = None
    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    spring_at: float = 0.0
    further: Hinge | None = None
    runs: bool = False


@dataclass(frozen=True)
class Link:
    """A rigid part of the robot; shapes lie in its frame."""

    name: str
    inertial: Inertial | None
    collisions: tuple[Part, ...]
    visuals: tuple[Part, ...]


@dataclass(frozen=True)
class Urdf:
    """A robot description as it was read.

    Attributes:
        text: The URDF itself, for `/robot_description`.
        root: Name of the link that no joint carries.
        links: By name, in the file's order.
        joints: By name, in the file's order.
    """

    path: Path
    name: str
    text: str
    root: str
    links: dict[str, Link] = field(default_factory=dict)
    joints: dict[str, Joint] = field(default_factory=dict)

    @property
    def mass(self) -> float:
        """The mass of all links together [kg]."""
        return sum(link.inertial.mass for link in self.links.values() if link.inertial is not None)

    def T_root(self, link: str, moved: Mapping[str, float] | None = None) -> Pose3:
        """Return a link's pose in the root's frame, all joints at position 0.

        Args:
            moved: Positions of joints that are not at 0 [rad or m].
        """
        T = Pose3()
        for joint in self.above(link):
            T = joint.at((moved or {}).get(joint.name, 0.0)) @ T
        return T

    def above(self, link: str) -> Iterator[Joint]:
        """Yield the joints that carry a link, the root's last."""
        carriers = {joint.child: joint for joint in self.joints.values()}
        while link in carriers:
            yield carriers[link]
            link = carriers[link].parent
