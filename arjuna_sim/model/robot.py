"""A robot that can be simulated."""

from __future__ import annotations

from dataclasses import dataclass

from arjuna_sim.model.notes import Note
from arjuna_sim.model.settings import DriveSettings, GazeboSettings
from arjuna_sim.model.urdf import Urdf

ANCHOR = "world"
"""Name of a root link that is fixed to the world."""


@dataclass(frozen=True)
class Robot:
    """A robot that can be simulated.

    Attributes:
        urdf: Links, joints and their fixed transforms.
        settings: Sensors and friction from the Gazebo tags.
        drive: The wheels.
        notes: What its files say and the simulation leaves out.
    """

    urdf: Urdf
    settings: GazeboSettings
    drive: DriveSettings
    notes: tuple[Note, ...]

    @property
    def wheel_joints(self) -> tuple[str, ...]:
        """Names of the driven joints, left ones first."""
        return self.drive.wheels

    @property
    def rolling_joints(self) -> tuple[str, ...]:
        """Names of the joints of all wheels, the driven ones first."""
        return self.drive.rolling

    @property
    def moving_joints(self) -> tuple[str, ...]:
        """Names of all joints that have a position, in the file's order."""
        return tuple(j.name for j in self.urdf.joints.values() if j.has_position)

    @property
    def anchored(self) -> bool:
        """Whether it is fixed to the world, as Gazebo fixes a robot whose root is `world`."""
        return self.urdf.root == ANCHOR
