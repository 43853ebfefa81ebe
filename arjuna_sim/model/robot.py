"""A robot that can be simulated, and its outline from above, as costmaps want it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_sim.model.geometry.shapes import points_of
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
        start: Where its root link stands in the world that its file holds; None without a world.
    """

    urdf: Urdf
    settings: GazeboSettings
    drive: DriveSettings
    notes: tuple[Note, ...]
    start: SE2 | None = None

    @property
    def moving_joints(self) -> tuple[str, ...]:
        """Names of all joints that have a position, in the file's order."""
        return tuple(j.name for j in self.urdf.joints.values() if j.has_position)

    @property
    def anchored(self) -> bool:
        """True for a robot fixed to the world, as Gazebo fixes a robot whose root is `world`."""
        return self.urdf.root.rpartition(_BELOW)[2] == ANCHOR

    def standard(self) -> RobotModel:
        """Return the robot with the standard topics, whatever its file says."""
        return replace(self, settings=self.settings.standard(), drive=self.drive.standard())

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
        driven=tuple(replace(joint, name=prefix + joint.name) for joint in settings.driven),
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


def footprint(robot: RobotModel, frame: str) -> Floats:
    """Return the convex outline of all that can touch something, wheels steered as far as they are.

    Returns:
        `(N, 2) float64` [m], counter-clockwise; none where no shape has an area.
    """
    every = extent(robot, frame)[:, :2]
    try:
        outline = every[ConvexHull(every).vertices]
    except (QhullError, ValueError):
        return np.zeros((0, 2))
    return np.round(_without_fine_corners(outline), 3)


def extent(robot: RobotModel, frame: str) -> Floats:
    """Return the corners of all that can touch something, `(N, 3)` [m].

    Every joint is at zero, but those that steer wheels are everywhere that they are turned to. A
    driven wheel touches with its looks where it has no collision shape.
    """
    urdf = robot.urdf
    wheels = {urdf.joints[joint].child for joint in robot.drive.wheels}
    T_frame_root = urdf.T_root(frame).inverse()
    parts = {
        link.name: link.collisions or (link.visuals if link.name in wheels else ())
        for link in urdf.links.values()
    }
    steering, limit = robot.drive.steering, min(robot.drive.steering_limit, math.pi)
    angles = limit * np.linspace(-1.0, 1.0, 9) if steering else np.zeros(1)  # of them all alike
    return np.vstack(
        [
            points_of(own, T_frame_root @ urdf.T_root(name, dict.fromkeys(steering, angle)))
            for name, own in parts.items()
            for angle in angles.tolist()
            if not angle or any(joint.name in steering for joint in urdf.above(name))
        ]
    )


def inscribed_radius(robot: RobotModel) -> float:
    """Return half the width of the narrowest gap that a robot passes ahead or sideways [m]."""
    outline = footprint(robot, robot.urdf.root)
    return float(np.ptp(outline, axis=0).min()) / 2.0 if len(outline) else 0.0


def _without_fine_corners(outline: Floats) -> Floats:
    """Take out corners, the finest first, that stand out less than counts."""
    while len(outline) > 3:
        before, after = np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0)
        along, offset = after - before, outline - before
        length = np.maximum(np.hypot(*along.T), 1e-9)
        height = np.abs(along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0]) / length
        finest = int(height.argmin())
        # [m] A corner that stands out by less is left out.
        if height[finest] >= 0.003:
            break
        outline = np.delete(outline, finest, axis=0)
    return outline
