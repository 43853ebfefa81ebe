"""The robot: what its URDF says, and its MuJoCo body on a free joint."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.errors import RobotError
from arjuna_sim.gazebo import DriveSettings, GazeboSettings, guess_drive, read_gazebo
from arjuna_sim.pose3 import Pose3
from arjuna_sim.shapes import Group, Kind, Part, Shape, add_part
from arjuna_sim.urdf import Joint, Urdf, read_urdf
from arjuna_sim.xacro_file import expand, has_macros
from arjuna_sim.xml_file import XmlFile, read_bytes

BODY_JOINT = "arjuna_free_joint"
_ACROSS = 0.5
_PASSIVE_DAMPING = 1e-3  # [N m s/rad] lets casters come to rest
_CASTER_FRICTION = 0.01  # a ball on the chassis stands for a caster, which rolls
# Tyres: stiffness [1/s^2] and damping [1/s] per unit mass. Stiff against damping, and with friction
# softened by the scene's impratio, a sliding wheel stays on the ground: at MuJoCo's defaults it
# hops, and how the robot turns then depends on the time step.
_TYRE = (-3000.0, -20.0)


@dataclass(frozen=True)
class ServoConfig:
    """How a wheel follows its commanded speed."""

    gain: float = param(
        10.0, "Torque per error of wheel speed.", unit="N m s/rad", minimum=0.0, read_only=True
    )
    armature: float = param(
        0.02, "Rotor inertia as the wheel feels it.", unit="kg m^2", minimum=0.0, read_only=True
    )


@dataclass(frozen=True)
class Robot:
    """A robot that can be simulated.

    Attributes:
        urdf: Links, joints and their fixed transforms.
        settings: Sensors and friction from the Gazebo tags.
        drive: The wheels.
        notes: What its files say and the simulation leaves out, one line each.
    """

    urdf: Urdf
    settings: GazeboSettings
    drive: DriveSettings
    notes: tuple[str, ...]

    @property
    def wheel_joints(self) -> tuple[str, ...]:
        """Names of the driven joints, left ones first."""
        return self.drive.left + self.drive.right

    @property
    def moving_joints(self) -> tuple[str, ...]:
        """Names of all joints that are not fixed, in the file's order."""
        return tuple(j.name for j in self.urdf.joints.values() if j.kind != "fixed")


def load_robot(path: str | Path) -> Robot:
    """Read a robot from a `.urdf` or `.xacro` file.

    Raises:
        RobotError: The file cannot be read or does not describe a robot with wheels.
    """
    path = Path(path)
    text = read_bytes(path, RobotError)
    if has_macros(path, text):
        text = expand(path, text)
    xml = XmlFile(path, "robot", RobotError, text)
    urdf = read_urdf(xml)
    settings = read_gazebo(xml, urdf)
    drive = settings.drive or _find_wheels(xml, urdf)
    for name in drive.left + drive.right:
        if urdf.joints[name].kind != "continuous":
            raise xml.fail(f"joint '{name}'", "drives a wheel, so its type must be 'continuous'")
        wheel_sign(xml.path, urdf, name)
    return Robot(urdf, settings, drive, tuple(xml.notes))


def _find_wheels(xml: XmlFile, urdf: Urdf) -> DriveSettings:
    """Take the continuous joints whose axis lies across as the wheels."""
    sides: dict[bool, list[str]] = {True: [], False: []}
    for name, joint in urdf.joints.items():
        y = urdf.T_root(joint.child).position[1]
        if joint.kind == "continuous" and abs(_axis_y(urdf, name)) > _ACROSS and y != 0.0:
            sides[y > 0.0].append(name)
    left, right = tuple(sides[True]), tuple(sides[False])
    if not left or not right:
        problem = "has no drive: neither a drive plugin nor a 'continuous' wheel joint on each side"
        raise RobotError(xml.path, problem)
    return guess_drive(xml, urdf, left, right)


def _axis_y(urdf: Urdf, joint: str) -> float:
    """Return how far a joint's axis points to the robot's left."""
    rotation = urdf.T_root(urdf.joints[joint].child).rotation()
    return float(rotation[1] @ np.array(urdf.joints[joint].axis))


def wheel_sign(path: Path, urdf: Urdf, joint: str) -> float:
    """Return +1 where positive turning drives forward, -1 where it drives backward.

    Raises:
        RobotError: The joint's axis does not lie across the robot.
    """
    across = _axis_y(urdf, joint)
    if abs(across) < _ACROSS:
        raise RobotError(path, "a wheel's axis must lie across the robot (y)", f"joint '{joint}'")
    return 1.0 if across > 0.0 else -1.0


def add_robot(spec: Any, robot: Robot, servo: ServoConfig) -> None:
    """Add the robot to a MuJoCo world, its root at the origin.

    Links that fixed joints connect become one body; every link becomes a site of its name.

    Args:
        spec: The `mujoco.MjSpec` of the world.
        robot: The robot.
        servo: How its wheels are driven.

    Raises:
        RobotError: A moving part has no mass.
    """
    body = spec.worldbody.add_body(name=f"body:{robot.urdf.root}")
    body.add_freejoint(name=BODY_JOINT)
    _fill_body(spec, body, robot, robot.urdf.root, servo)
    for name in robot.wheel_joints:
        _add_servo(spec, robot, name, servo)


def _fill_body(spec: Any, body: Any, robot: Robot, first: str, servo: ServoConfig) -> None:
    """Add a link and all that fixed joints hang on it, then the bodies that joints carry."""
    masses: list[tuple[float, NDArray[np.float64], NDArray[np.float64]]] = []
    queue = [(first, Pose3())]
    while queue:
        name, T_body_link = queue.pop(0)
        link = robot.urdf.links[name]
        body.add_site(name=name, pos=T_body_link.position, quat=T_body_link.quaternion)
        _add_parts(spec, body, robot, name, T_body_link)
        if link.inertial is not None:
            turn = T_body_link.rotation()
            center = T_body_link.apply(np.array([link.inertial.center]))[0]
            masses.append((link.inertial.mass, center, turn @ link.inertial.inertia @ turn.T))
        for joint in robot.urdf.joints.values():
            if joint.parent == name and joint.kind == "fixed":
                queue.append((joint.child, T_body_link @ joint.T_parent_child))
            elif joint.parent == name:
                _add_moving(spec, body, robot, joint, T_body_link, servo)
    if not masses:
        problem = "moves, but neither it nor what is fixed to it has an <inertial>"
        raise RobotError(robot.urdf.path, problem, f"link '{first}'")
    _set_mass(body, masses)


def _set_mass(
    body: Any, masses: list[tuple[float, NDArray[np.float64], NDArray[np.float64]]]
) -> None:
    """Combine masses about their common centre (parallel axis theorem)."""
    total = sum(mass for mass, _, _ in masses)
    center = sum((mass * place for mass, place, _ in masses), np.zeros(3)) / total
    inertia = np.zeros((3, 3))
    for mass, place, own in masses:
        arm = place - center
        inertia += own + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    body.mass, body.ipos, body.explicitinertial = total, center, True
    body.fullinertia = [
        *np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2]
    ]  # fmt: skip


def _add_parts(spec: Any, body: Any, robot: Robot, name: str, T_body_link: Pose3) -> None:
    link = robot.urdf.links[name]
    for part in link.visuals:
        placed = Part(part.shape, T_body_link @ part.pose, part.rgba)
        add_part(spec, body, placed, Group.ROBOT_VISUAL)
    for part in _collisions(robot, name):
        placed = Part(part.shape, T_body_link @ part.pose, part.rgba)
        geom = add_part(spec, body, placed, Group.ROBOT_COLLISION)[0]
        friction = robot.settings.friction.get(name)
        if friction is None and part.shape.kind is Kind.SPHERE and not _is_wheel(robot, name):
            friction = _CASTER_FRICTION
        if friction is not None:
            geom.friction[0] = friction
            geom.priority = 1  # the link's friction holds, whatever the ground's
        if _is_wheel(robot, name):
            geom.solref, geom.priority = _TYRE, 1


def _is_wheel(robot: Robot, link: str) -> bool:
    return any(robot.urdf.joints[name].child == link for name in robot.wheel_joints)


def _collisions(robot: Robot, link: str) -> tuple[Part, ...]:
    """Return a link's collision shapes; a wheel whose mesh was left out becomes a sphere."""
    parts = robot.urdf.links[link].collisions
    if not parts and _is_wheel(robot, link):
        return (Part(Shape(Kind.SPHERE, (robot.drive.radius,))),)
    return parts


def _add_moving(
    spec: Any, body: Any, robot: Robot, joint: Joint, T_body_link: Pose3, servo: ServoConfig
) -> None:
    pose = T_body_link @ joint.T_parent_child
    child = body.add_body(name=f"body:{joint.child}", pos=pose.position, quat=pose.quaternion)
    slides = joint.kind == "prismatic"
    kind = mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE
    added = child.add_joint(name=joint.name, type=kind, axis=joint.axis)
    if joint.limits is not None:
        added.limited, added.range = True, joint.limits
    if joint.name in robot.wheel_joints:
        added.armature = servo.armature
    else:
        added.damping[0] = _PASSIVE_DAMPING
    _fill_body(spec, child, robot, joint.child, servo)


def _add_servo(spec: Any, robot: Robot, joint: str, servo: ServoConfig) -> None:
    """Add a motor whose torque is the gain times the error of speed, up to its limit."""
    motor = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    motor.gaintype, motor.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    motor.gainprm[0], motor.biasprm[2] = servo.gain, -servo.gain
    motor.forcelimited, motor.forcerange = True, [-robot.drive.torque, robot.drive.torque]
