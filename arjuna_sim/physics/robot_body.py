"""A robot as MuJoCo bodies: on a free joint, each wheel with a motor."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.errors import RobotError
from arjuna_core.pose3 import Pose3
from arjuna_sim.model.geometry.shapes import Group, Part
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.urdf import Joint
from arjuna_sim.physics.geoms import add_part
from arjuna_sim.physics.joint_servos import add_joint_servos, motored
from arjuna_sim.physics.wheels.servo import ServoConfig, add_rollers, add_servo, armature
from arjuna_sim.physics.wheels.tyres import add_tyre

_PASSIVE_DAMPING = 1e-3  # at most, lets casters come to rest [N m s/rad]
FAST = 1e9
"""Inertia of a robot that is fixed to the world, which no arm can move [kg]."""
ROBOTS_MAX = 30
"""Robots in one world: each takes one of 31 bits that say what touches what."""


def free_joint(robot: RobotModel) -> str:
    """Return the name of the joint on which a robot moves."""
    return f"free:{robot.urdf.root}"


def add_robot(spec: Any, robot: RobotModel, servo: ServoConfig, sag: float) -> None:
    """Add the robot to a MuJoCo world, its root at the origin.

    Links that fixed joints connect become one body; every link becomes a site of its name.

    Args:
        sag: How far its tyres sink in [m].

    Raises:
        RobotError: A moving part has no mass.
    """
    body = spec.worldbody.add_body(name=f"body:{robot.urdf.root}")
    joint = body.add_freejoint(name=free_joint(robot))
    if robot.anchored:
        joint.armature, joint.damping[0] = FAST, FAST
    _fill_body(spec, body, robot, robot.urdf.root, servo)
    for name in robot.drive.rolling:
        add_tyre(spec.body(f"body:{robot.urdf.joints[name].child}"), robot, name, sag)
    for name in robot.drive.wheels:
        add_servo(spec, name, robot.drive.torque)
    for name in robot.drive.steering:
        add_servo(spec, name)
    add_joint_servos(spec, motored(robot))
    for follower in robot.urdf.joints.values():
        _add_mimic(spec, follower)


def let_meet(spec: Any, robots: Sequence[RobotModel]) -> None:
    """Let robots that were added touch each other, and none itself.

    MuJoCo lets shapes touch where a bit of the one's type is in the other's affinity. The lowest
    bit is the world's type; each robot has one of its own.

    Raises:
        RobotError: They are more than there are bits.
    """
    if len(robots) > ROBOTS_MAX:
        problem = f"is robot {ROBOTS_MAX + 1}; at most {ROBOTS_MAX} can be in one world"
        raise RobotError(robots[ROBOTS_MAX].urdf.path, problem)
    every = sum(2 << i for i in range(len(robots)))
    for i, robot in enumerate(robots if len(robots) > 1 else ()):
        for geom in spec.body(f"body:{robot.urdf.root}").find_all("geom"):
            if geom.group == Group.ROBOT_COLLISION.value:
                geom.contype, geom.conaffinity = 2 << i, 1 | (every & ~(2 << i))


def add_mounts(spec: Any, robot: RobotModel) -> None:
    """Add a site for each sensor that sits off its link's origin."""
    for sensor in robot.settings.sensors:
        if sensor.site != sensor.link:
            link = spec.site(sensor.link)
            w, x, y, z = (float(value) for value in link.quat)
            a, b, c = (float(value) for value in link.pos)
            pose = Pose3((a, b, c), (w, x, y, z)) @ sensor.pose
            link.parent.add_site(name=sensor.site, pos=pose.position, quat=pose.quaternion)


def _fill_body(spec: Any, body: Any, robot: RobotModel, first: str, servo: ServoConfig) -> None:
    """Add a link with all that is fixed to it, then the bodies that joints carry."""
    masses: list[tuple[float, Floats, Floats]] = []
    queue = [(first, Pose3())]
    while queue:
        name, T_body_link = queue.pop(0)
        link = robot.urdf.links[name]
        body.add_site(name=name, pos=T_body_link.position, quat=T_body_link.quaternion)
        _add_parts(spec, body, robot, name, T_body_link)
        if link.inertial is not None:
            rotation = T_body_link.rotation()
            center = T_body_link.apply(np.array([link.inertial.center]))[0]
            masses.append(
                (link.inertial.mass, center, rotation @ link.inertial.inertia @ rotation.T)
            )
        for joint in robot.urdf.joints.values():
            if joint.parent == name and joint.kind == "fixed":
                queue.append((joint.child, T_body_link @ joint.T_parent_child))
            elif joint.parent == name:
                _add_moving(spec, body, robot, joint, T_body_link, servo)
    if not masses:
        problem = "moves, but neither it nor what is fixed to it has an <inertial>"
        raise RobotError(robot.urdf.path, problem, f"link '{first}'")
    _set_mass(body, masses)


def _set_mass(body: Any, masses: list[tuple[float, Floats, Floats]]) -> None:
    """Combine masses about their common centre (parallel axis theorem)."""
    total = sum(mass for mass, _, _ in masses)
    center = sum((mass * position for mass, position, _ in masses), np.zeros(3)) / total
    inertia = np.zeros((3, 3))
    for mass, position, own in masses:
        arm = position - center
        inertia += own + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    body.mass, body.ipos, body.explicitinertial = total, center, True
    body.fullinertia = [
        *np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2]
    ]  # fmt: skip


def _add_parts(spec: Any, body: Any, robot: RobotModel, name: str, T_body_link: Pose3) -> None:
    link = robot.urdf.links[name]
    for part in link.visuals:
        colour = robot.settings.colours.get(name, part.rgba)
        placed = dataclasses.replace(part, pose=T_body_link @ part.pose, rgba=colour)
        add_part(spec, body, placed, Group.ROBOT_VISUAL)
    for i, part in enumerate(() if _is_wheel(robot, name) else link.collisions):
        friction = robot.settings.friction.get(name)
        placed = Part(part.shape, T_body_link @ part.pose, part.rgba, friction)
        add_part(spec, body, placed, Group.ROBOT_COLLISION)[0].name = f"{name}//{i}"


def _is_wheel(robot: RobotModel, link: str) -> bool:
    return any(robot.urdf.joints[name].child == link for name in robot.drive.rolling)


def _add_moving(
    spec: Any, body: Any, robot: RobotModel, joint: Joint, T_body_link: Pose3, servo: ServoConfig
) -> None:
    pose = T_body_link @ joint.T_parent_child
    child = body.add_body(name=f"body:{joint.child}", pos=pose.position, quat=pose.quaternion)
    if joint.name in robot.drive.wheels:  # the motor makes up for friction and damping
        add_rollers(child, robot, joint.name)
        rotor = armature(robot, servo, spec.option.timestep)
        child.add_joint(name=joint.name, axis=joint.axis, armature=rotor)
    elif joint.has_position:
        _add_joint(child, joint, _passive_damping(robot))
    else:
        _add_loose(child, joint)
    _fill_body(spec, child, robot, joint.child, servo)


def _passive_damping(robot: RobotModel) -> float:
    """Return how damped joints are that nothing drives: hardly felt by the lightest robot."""
    load = robot.urdf.mass / max(1, len(robot.drive.rolling))
    # [1/s] 0.2 by load and radius^2: 1 % of the weight at 0.5 m/s.
    return min(_PASSIVE_DAMPING, 0.2 * load * robot.drive.radius**2)


def _add_joint(child: Any, joint: Joint, least_damping: float) -> None:
    slides = joint.kind == "prismatic"
    kind = mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE
    added = child.add_joint(name=joint.name, type=kind, axis=joint.axis)
    added.damping[0] = max(joint.damping, least_damping)
    added.frictionloss = joint.friction
    added.stiffness[0], added.springref = joint.stiffness, joint.spring_at
    if joint.limits is not None:
        added.limited, added.range = joint.limits[0] < joint.limits[1], joint.limits


def _add_loose(child: Any, joint: Joint) -> None:
    """Add the joints that together move freely in a plane, or in space."""
    slide, ball = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_BALL
    normal = np.array(joint.axis)
    first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first /= np.linalg.norm(first)
    axes = [first, np.cross(normal, first)]
    if joint.kind == "floating":
        axes.append(normal)
    for i, along in enumerate(axes):
        added = child.add_joint(name=f"{joint.name}/{i}", type=slide, axis=along)
        added.damping[0] = _PASSIVE_DAMPING
    kind = mujoco.mjtJoint.mjJNT_HINGE if joint.kind == "planar" else ball
    turn = child.add_joint(name=f"{joint.name}/turn", type=kind, axis=normal)
    turn.damping[0] = _PASSIVE_DAMPING


def _add_mimic(spec: Any, joint: Joint) -> None:
    if joint.mimic is None:
        return
    equality = spec.add_equality(
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=joint.name,
        name2=joint.mimic.joint,
    )
    equality.data[0:2] = (joint.mimic.offset, joint.mimic.multiplier)
