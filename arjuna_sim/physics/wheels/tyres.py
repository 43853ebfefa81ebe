"""Tyres: the round shapes on which a robot rolls, as stiff and as damped as its weight asks for.

MuJoCo's contact is a spring and a damper along the normal and a damper along the ground, all with
one ratio of damping to regularization. Three things are wanted of a tyre:

- It rests: what friction holds creeps by the force over the damping along the ground, which
  `STICTION` makes so large that a parked robot moves less than 1 um/min.
- It slides as Coulomb says. MuJoCo's cone is convex, so that sliding at speed v lifts a contact as
  if c mu v were added to the normal force, c the normal damping: the damping must stay light
  against the load, and the damper along the ground as stiff as the time step lets it be.
- It carries: the robot sinks in by a small share of the wheel's radius.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.geodesy import GRAVITY
from arjuna_sim.model.geometry.shapes import Group, Kind
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.wheels import CASTER_GAP_MAX, center, idle_wheels, radius_of, width_of
from arjuna_sim.physics.geoms import name_friction
from arjuna_sim.physics.wheels.traction import (
    SPREAD,
    GroundContacts,
    Weight,
    carrier,
    steady_acceleration,
    traction_notes,
)

STICTION = 1e6
"""Damping along the ground, by the normal damping (MuJoCo's `impratio`)."""
_CASTER_DAMPING, _DAMPING_BY_FRICTION = (
    0.7,
    0.03,
)  # the same of casters, at most, and by their friction
_LEAST, _MOST = 1e-4, 0.9999  # of MuJoCo's impedance


@dataclass(frozen=True)
class WheelSupport:
    """The support of a robot by its wheels and casters.

    Attributes:
        ride_height: Height of its root above the ground [m].
        steady: Greatest acceleration at which it stands on all its contacts and grips [m/s^2].
        faults: What keeps it from driving as others do.
        tyres: Its tyres' geoms, rising.
        contacts: Where it touches level ground, from above, in its root's frame, `(N, 2)` [m].
    """

    ride_height: float
    steady: float
    faults: tuple[str, ...]
    tyres: tuple[int, ...]
    contacts: Floats

    @property
    def balances(self) -> bool:
        """True where its wheels stand in one line across, which does not hold it upright."""
        return bool(self.tyres) and bool(np.ptp(self.contacts[:, 0]) < SPREAD)


def sag_of(robot: RobotModel, timestep: float) -> float:
    """Return how far a tyre sinks in under its load [m]."""
    # Below four times the fall in one step a tyre would oscillate faster than the steps.
    return max(0.008 * robot.drive.radius, 4.0 * GRAVITY * timestep**2)


def add_tyre(body: Any, robot: RobotModel, joint: str, sag: float) -> None:
    """Add a wheel's shapes to a MuJoCo body: a crowned tyre on a rim.

    The tyre touches the ground in the wheel's middle. It is larger than the wheel by half its sag,
    so that it rolls like the wheel. The rim, a cylinder as wide as the wheel, is what bumps; that
    of a ball is a ball, on which it rolls where it leans.

    Args:
        body: The spec's body; its frame is the wheel's link's.
    """
    urdf, link = robot.urdf, robot.urdf.joints[joint].child
    radius, width = radius_of(urdf, joint) or robot.drive.radius, width_of(urdf, joint)
    position = urdf.T_root(link).inverse().apply(center(urdf, joint)[None])[0]
    along = np.zeros(4)
    mujoco.mju_quatZ2Vec(along, np.array(urdf.joints[joint].axis))
    outer, half = radius + sag / 2, width / 2 or radius
    is_ball = {part.shape.kind for part in urdf.links[link].collisions} == {Kind.SPHERE}
    rim = mujoco.mjtGeom.mjGEOM_SPHERE if is_ball else mujoco.mjtGeom.mjGEOM_CYLINDER
    for name, kind, size in (
        ("tyre", mujoco.mjtGeom.mjGEOM_ELLIPSOID, [outer, outer, half]),
        # The rim stays clear of the ground by more than the tyre sags.
        ("rim", rim, [radius - 2.0 * sag, half, 0.0]),
    ):
        geom = body.add_geom(type=kind, size=size, pos=position, quat=along, mass=0.0)
        geom.name = f"{link}//{name}"
        geom.group, geom.conaffinity, geom.contype = Group.ROBOT_COLLISION.value, 1, 0
        name_friction(geom, robot.settings.friction.get(link, geom.friction[0]))


def tune_tyres(model: Any, robot: RobotModel, sag: float) -> WheelSupport:
    """Set how stiff and how damped the robot's contacts with the ground are."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    lowest = _lowest_points(model, data, int(model.body(f"body:{robot.urdf.root}").id))
    bodies = _bodies(model, robot, robot.drive.rolling)
    round_ones = model.geom_type == mujoco.mjtGeom.mjGEOM_ELLIPSOID
    wheels = {g for g in lowest if round_ones[g] and model.geom_bodyid[g] in bodies}
    ground = min((lowest[geom] for geom in wheels), default=0.0)
    near = {g for g in lowest if wheels and lowest[g] < ground + CASTER_GAP_MAX}
    casters = {g for g in near if model.geom_bodyid[g] not in bodies}
    load = robot.urdf.mass / max(1, len(wheels))
    for geom in wheels:
        # A robot bounces on its tyres with 0.005 of the critical damping.
        _set_contact(model, geom, load, sag, 0.005)
    for geom in casters:
        _crown(model, data, geom)
        friction = max(float(model.geom_friction[geom, 0]), 1e-3)
        _set_contact(model, geom, load, sag, min(_CASTER_DAMPING, _DAMPING_BY_FRICTION / friction))
    sunk = [low + sag * (geom in wheels) for geom, low in lowest.items()]
    geoms = sorted(wheels) + sorted(casters)
    gaps = [(lowest[geom] - ground) / sag for geom in geoms]
    driven = _bodies(model, robot, robot.drive.wheels)
    free = (bodies | _bodies(model, robot, idle_wheels(robot.urdf))) - driven
    contacts = _ground_contacts(model, data, geoms, gaps, (driven, free))
    weight = _weight(model, data, robot, ground)
    steady, instead = steady_acceleration(contacts, weight), carrier(contacts, weight)
    height = -min(sunk, default=-0.0)
    return WheelSupport(
        max(0.0, height) if robot.anchored else height,  # what hangs from the world hangs on
        steady,
        traction_notes(steady, "" if instead < 0 else _link(model, geoms[instead])),
        tuple(sorted(wheels)),
        contacts.positions,
    )


def _crown(model: Any, data: Any, geom: int) -> None:
    """Make a roller an ellipsoid: MuJoCo lets cylinders run against an edge as against a wall."""
    cylinder, ellipsoid = mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_ELLIPSOID
    # The axis of a roller on the ground is within 6 degrees of level.
    if model.geom_type[geom] == cylinder and abs(data.geom_xmat[geom][8]) < 0.1:
        radius, half, _ = model.geom_size[geom]
        model.geom_type[geom], model.geom_size[geom] = ellipsoid, (radius, radius, half)


def _link(model: Any, geom: int) -> str:
    """Return the link of which a geom is a shape."""
    name: str = model.geom(geom).name
    return name.split("//")[0]


def _bodies(model: Any, robot: RobotModel, joints: tuple[str, ...]) -> set[int]:
    return {int(model.body(f"body:{robot.urdf.joints[name].child}").id) for name in joints}


def _ground_contacts(
    model: Any, data: Any, geoms: list[int], gaps: list[float], bodies: tuple[set[int], set[int]]
) -> GroundContacts:
    """Return where a robot stands; wheels that nothing drives, of the second bodies, just roll."""
    driven, free = (np.isin(model.geom_bodyid[geoms], list(each)) for each in bodies)
    positions = [_contact_point(model, data, geom) for geom in geoms]
    friction = np.where(free, 0.0, model.geom_friction[geoms, 0])
    return GroundContacts(np.array(positions).reshape(-1, 2), np.array(gaps), friction, driven)


def _contact_point(model: Any, data: Any, geom: int) -> Floats:
    """Return where a geom touches level ground, seen from above, `(2,) float64` [m]."""
    position = data.geom_xpos[geom]
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        points = position + _mesh_points(model, geom) @ data.geom_xmat[geom].reshape(3, 3).T
        # [m] Points within 1 mm of the lowest are a mesh's underside.
        position = points[points[:, 2] < points[:, 2].min() + 1e-3].mean(axis=0)
    touching: Floats = position[:2].copy()
    return touching


def _weight(model: Any, data: Any, robot: RobotModel, ground: float) -> Weight:
    body = model.body(f"body:{robot.urdf.root}").id
    rates = [model.joint(name).dofadr[0] for name in robot.drive.wheels]
    inertia, radius = float(model.dof_M0[rates].sum()), robot.drive.radius
    return Weight(
        float(model.body_subtreemass[body]),
        data.subtree_com[body] - np.array([0.0, 0.0, ground]),
        inertia / radius,
        len(rates) * robot.drive.torque / radius,
        inertia / radius**2,
    )


def _set_contact(model: Any, geom: int, load: float, sag: float, share: float) -> None:
    """Give a shape the contact that sinks in by its sag under a load [kg], and a share of damping.

    MuJoCo asks for acceleration -b v - k r and yields by a regularization R, so that the force
    is (-b v - k r) / R: b is as large as the step allows, R and k follow from damping and sag.
    """
    damping = 2.0 * share * load * float(np.sqrt(GRAVITY / sag))
    # [1/s] The rate at which friction takes away a sliding speed, less for long steps.
    b = min(50.0, 0.5 / model.opt.timestep)
    regularization = b / damping
    k = regularization * load * GRAVITY / sag
    inverse_mass = float(model.body_invweight0[model.geom_bodyid[geom], 0])
    impedance = 1.0 / (1.0 + regularization / max(inverse_mass, mujoco.mjMINVAL))
    impedance = float(np.clip(impedance, _LEAST, _MOST))
    model.geom_solimp[geom, :2] = impedance
    model.geom_solref[geom] = (-k * impedance, -b * impedance)


def _lowest_points(model: Any, data: Any, root: int) -> dict[int, float]:
    """Return how low each collision shape of the robot reaches from its root, a body [m]."""
    own = model.body_rootid[model.geom_bodyid] == root
    geoms = np.flatnonzero(own & (model.geom_group == Group.ROBOT_COLLISION.value)).tolist()
    return {
        geom: float(data.geom_xpos[geom][2]) + _lowest(model, geom, data.geom_xmat[geom][6:9])
        for geom in geoms
    }


def _lowest(model: Any, geom: int, down: Floats) -> float:
    """Return the least of `down . point` over a geom's points in its own frame [m]."""
    size, kind = model.geom_size[geom], model.geom_type[geom]
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        return -float(size[0])
    if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
        return -float(np.linalg.norm(down * size))
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return -float(size[0] * np.hypot(down[0], down[1]) + size[1] * abs(down[2]))
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return -float(np.abs(down) @ size)
    return float((_mesh_points(model, geom) @ down).min())


def _mesh_points(model: Any, geom: int) -> Floats:
    """Return the corners of a mesh in its geom's frame, `(N, 3)` [m]."""
    mesh = model.geom_dataid[geom]
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    points: Floats = model.mesh_vert[first : first + count]
    return points
