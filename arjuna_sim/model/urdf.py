"""A robot description: links, and the joints that connect them to a tree."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.geometry.inertia import Inertial
from arjuna_sim.model.geometry.shapes import Part
from arjuna_sim.model.joints import Joint


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
        path: The file.
        name: The robot's name.
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
        """What all links weigh together [kg]."""
        return sum(link.inertial.mass for link in self.links.values() if link.inertial is not None)

    def T_root(self, link: str) -> Pose3:
        """Return a link's pose in the root's frame, all joints at position 0."""
        carrier = {joint.child: joint for joint in self.joints.values()}
        T = Pose3()
        while link in carrier:
            T = carrier[link].T_parent_child @ T
            link = carrier[link].parent
        return T
