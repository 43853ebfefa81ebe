"""A robot that can be simulated."""

from __future__ import annotations

from dataclasses import dataclass, replace

from arjuna_sim.model.notes import Note
from arjuna_sim.model.settings import DriveSettings, GazeboSettings
from arjuna_sim.model.urdf import Urdf

ANCHOR = "world"
"""Name of a root link that is fixed to the world."""
SOLO = ""
"""Name on the stage of a robot that has it for its own."""
_BELOW = "//"


@dataclass(frozen=True)
class RobotModel:
    """A robot that can be simulated.

    Attributes:
        urdf: Links, joints and their fixed transforms.
        settings: Sensors and friction from the Gazebo tags.
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
        """True for a robot fixed to the world, as Gazebo fixes a robot whose root is `world`."""
        return self.urdf.root.rpartition(_BELOW)[2] == ANCHOR

    def below(self, name: str) -> RobotModel:
        """Return the robot with its links, joints and sensors below a name, `SOLO` for as they are.

        So several can share a stage; its topics and frames keep their names.
        """
        if name == SOLO:
            return self
        prefix = name + _BELOW
        return replace(
            self,
            urdf=_urdf_below(prefix, self.urdf),
            settings=_settings_below(prefix, self.settings),
            drive=_drive_below(prefix, self.drive),
        )


def _urdf_below(prefix: str, urdf: Urdf) -> Urdf:
    links = {
        prefix + name: replace(link, name=prefix + link.name) for name, link in urdf.links.items()
    }
    joints = {
        prefix + name: replace(
            joint,
            name=prefix + joint.name,
            parent=prefix + joint.parent,
            child=prefix + joint.child,
            mimic=joint.mimic and replace(joint.mimic, joint=prefix + joint.mimic.joint),
        )
        for name, joint in urdf.joints.items()
    }
    return replace(urdf, root=prefix + urdf.root, links=links, joints=joints)


def _settings_below(prefix: str, settings: GazeboSettings) -> GazeboSettings:
    return replace(
        settings,
        sensors=tuple(
            replace(one, link=prefix + one.link, name=prefix + one.name) for one in settings.sensors
        ),
        friction={prefix + link: value for link, value in settings.friction.items()},
        colours={prefix + link: value for link, value in settings.colours.items()},
    )


def _drive_below(prefix: str, drive: DriveSettings) -> DriveSettings:
    def below(joints: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(prefix + joint for joint in joints)

    return replace(
        drive,
        left=below(drive.left),
        right=below(drive.right),
        steering=below(drive.steering),
        free=below(drive.free),
    )
