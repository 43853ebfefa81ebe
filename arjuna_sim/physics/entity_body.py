"""Entities as MuJoCo bodies, each beside the world's static one."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection
from typing import Any

import mujoco
import numpy as np

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.entities import Entity, EntityMotion, body_name
from arjuna_sim.model.geometry.convex_pieces import PIECES_MAX, PIECES_OF_MOVING
from arjuna_sim.model.geometry.shapes import Group
from arjuna_sim.model.urdf import Hinge
from arjuna_sim.model.world import Fixture
from arjuna_sim.physics.geoms import add_part
from arjuna_sim.physics.robot_body import FAST


def add_entity(spec: Any, entity: Entity) -> int:
    """Add an entity to a MuJoCo world.

    One that is held or follows a path is a mocap body: nothing moves it but `Stage`. One with a
    mass is a free body, with the inertia of its bounding box.

    Returns:
        How many geoms it has.
    """
    held = entity.mass == 0.0
    above, pose = spec.worldbody, entity.start
    carrier = spec.body(body_name(entity.on))
    if carrier is not None and (carrier.joints or carrier.mocap):
        above, pose = carrier, entity.mount
    body = above.add_body(name=entity.body, pos=pose.position, quat=pose.quaternion, mocap=held)
    geoms = [
        geom
        for parts, group in (
            (entity.solid, Group.WORLD_COLLISION),
            (entity.drawn or entity.solid, Group.WORLD_VISUAL),
        )
        for part in parts
        for geom in add_part(spec, body, part, group, PIECES_MAX if held else PIECES_OF_MOVING)
    ]
    if not held:
        _set_mass(body, entity)
        if entity.hinge is None:
            body.add_freejoint(name=entity.body)
        else:
            _add_hinge(body, entity.body, entity.hinge)
        body.gravcomp = float(entity.floats)
        if entity.hinge is None or not entity.hinge.runs:  # a belt stands, as the world does
            for geom in geoms:  # it meets the world and its like, as robots do
                geom.conaffinity = geom.contype
    return len(geoms)


def let_pass(spec: Any, entities: Collection[Entity]) -> None:
    """Let what hangs on each other pass through each other, as links of one model do in Gazebo.

    Those that say so touch others of their model all the same, but for what they hang on.
    """
    touching = {entity.name for entity in entities if entity.self_collides}
    tops = {entity.name: entity.on for entity in entities if entity.on}
    models: dict[str, list[str]] = {}
    for name in tops:
        top = name
        while top in tops:
            top = tops[top]
        models.setdefault(top, [top]).append(name)
    for names in models.values():
        found = [name for name in names if spec.body(body_name(name)) is not None]
        for one, other in itertools.combinations(found, 2):
            joined = tops.get(other) == one or tops.get(one) == other
            if joined or touching.isdisjoint((one, other)):
                spec.add_exclude(bodyname1=body_name(one), bodyname2=body_name(other))


def add_fixture(spec: Any, fixture: Fixture, moving: Collection[str]) -> None:
    """Add the site of a world's sensor, to its model where that is one of the entities."""
    if spec.site(fixture.settings.site) is not None:
        return  # a lidar of several rows is two sensors in one place
    carried = fixture.model in moving
    body = spec.body(body_name(fixture.model)) if carried else spec.worldbody
    T = fixture.T_model if carried else fixture.T_world
    body.add_site(name=fixture.settings.site, pos=T.position, quat=T.quaternion)


def _add_hinge(body: Any, name: str, hinge: Hinge) -> None:
    """Add a joint, and that of its further axis, to a body whose inertia is set."""
    if hinge.axis is None:
        joint = body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_BALL, pos=hinge.anchor)
    else:
        kind = mujoco.mjtJoint.mjJNT_SLIDE if hinge.slides else mujoco.mjtJoint.mjJNT_HINGE
        joint = body.add_joint(name=name, type=kind, axis=hinge.axis, pos=hinge.anchor)
    arm = 1.0 if hinge.slides else math.dist(body.ipos, hinge.anchor)
    inertia = body.mass * arm**2 + (0.0 if hinge.slides else max(body.inertia))
    # [N m s/rad] A door that was pushed comes to rest; what is light does so within 10 s.
    joint.damping[0] = max(hinge.damping, min(0.1, 0.1 * inertia))
    joint.frictionloss, joint.armature = hinge.friction, FAST * hinge.runs
    joint.stiffness[0], joint.springref = hinge.stiffness, hinge.spring_at
    if hinge.limits is not None:
        joint.limited, joint.range = True, hinge.limits
    if hinge.further is not None:
        _add_hinge(body, f"{name}/further", hinge.further)


def _set_mass(body: Any, entity: Entity) -> None:
    low, high = entity.bounds()
    # [m] Least extent that the inertia is computed with.
    x, y, z = np.maximum(high - low, 1e-3) ** 2
    body.mass, body.ipos, body.explicitinertial = entity.mass, (low + high) / 2, True
    body.inertia = np.array([y + z, x + z, x + y]) * entity.mass / 12.0


def motion_of(model: Any, data: Any, entity: Entity) -> EntityMotion:
    """Return where an entity is and how it moves, with positions and velocities up to date."""
    body, velocity = model.body(entity.body).id, np.zeros(6)
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, velocity, 0)
    x, y, z = data.xpos[body].tolist()
    qw, qx, qy, qz = data.xquat[body].tolist()
    wx, wy, wz, vx, vy, vz = velocity.tolist()
    return EntityMotion(Pose3((x, y, z), (qw, qx, qy, qz)), (vx, vy, vz), (wx, wy, wz))


def addresses_of(model: Any, entity: Entity) -> tuple[int, int, int]:
    """Return an entity's addresses: mocap index (-1 for one that moves), in qpos, in qvel."""
    body = model.body(entity.body)
    mocap = int(model.body_mocapid[body.id])
    if mocap >= 0:
        return mocap, -1, -1
    joint = model.joint(entity.body)
    return -1, int(joint.qposadr[0]), int(joint.dofadr[0])
