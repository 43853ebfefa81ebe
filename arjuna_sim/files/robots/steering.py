"""Finding which joints steer a robot's wheels, and which wheels drive it."""

from __future__ import annotations

import dataclasses
import re

import numpy as np

from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.joints import Joint
from arjuna_sim.model.settings import DriveKind, DriveSettings
from arjuna_sim.model.urdf import Urdf
from arjuna_sim.model.wheels import axis, center, radius_of, steered_by

_STEERS = re.compile(r"steer|kingpin|knuckle|turn|swivel|hinge", re.I)
_PASSIVE = re.compile(r"cast[eo]r", re.I)
_UPRIGHT, _ACROSS = 0.7, 0.5  # least part of a steering axis along z, and of a wheel's along y
_LIMITS = (0.05, 1.4)  # of what steering can do [rad]
_TRAIL = 0.1  # least of a caster's wheel behind its hinge, by its radius
_STANDS = 0.02  # how far a wheel's lowest point may be off the others' [m]


def steering_joints(urdf: Urdf) -> tuple[str, ...]:
    """Return the joints that turn a wheel about the vertical, but for casters.

    Those without limits steer where their wheel stands below them: a caster's trails.
    One that follows another to the same side is one, too: each steers its own wheel.
    """
    carriers = {joint.parent for joint in urdf.joints.values() if joint.kind == "continuous"}
    return tuple(
        joint.name
        for joint in urdf.joints.values()
        if joint.child in carriers
        and (joint.kind == "revolute" or (joint.kind == "continuous" and _is_above(urdf, joint)))
        and (joint.mimic is None or joint.mimic.multiplier > 0.0)
        and _STEERS.search(f"{joint.name} {joint.child}") is not None
        and _PASSIVE.search(f"{joint.name} {joint.child}") is None
        and _is_upright(urdf, joint)
    )


def _is_upright(urdf: Urdf, joint: Joint) -> bool:
    return abs(float(axis(urdf, joint.name)[2])) > _UPRIGHT


def _is_above(urdf: Urdf, joint: Joint) -> bool:
    """Tell whether a joint stands above the wheel that it carries, or beside it on its axle."""
    place = np.array(urdf.T_root(joint.child).position)
    for name, wheel in urdf.joints.items():
        if wheel.parent == joint.child and wheel.kind == "continuous":
            ahead = np.cross(axis(urdf, name), (0.0, 0.0, 1.0))
            if abs(float((center(urdf, name) - place) @ ahead)) > _TRAIL * radius_of(urdf, name):
                return False
    return True


def with_steering(xml: XmlFile, urdf: Urdf, drive: DriveSettings) -> DriveSettings | None:
    """Return a drive that steers; None where no joint does, or no wheel drives.

    Where no plugin names the driven wheels, those drive that are not steered, if there are any.
    """
    named = tuple(n for n in drive.steering if _is_upright(urdf, urdf.joints[n]))
    steering = named or steering_joints(urdf)
    if not steering or not drive.wheels:
        return None
    for name in steering:
        if urdf.joints[name].mimic is not None:
            xml.note(f"joint '{name}': steers its own wheel, so that none slides, and mimics none")
    wheels = tuple(n for n in drive.wheels if abs(float(axis(urdf, n)[1])) > _ACROSS)
    fixed = tuple(n for n in wheels if steered_by(urdf, n, steering) < 0)
    driven = wheels if drive.plugin else fixed or wheels
    limit = min([_limit(urdf, name) for name in steering])
    limit = min(limit, drive.steering_limit or limit)
    sides = [tuple(n for n in driven if n in side) for side in (drive.left, drive.right)]
    return dataclasses.replace(
        drive,
        left=sides[0],
        right=sides[1],
        kind=DriveKind.STEERED,
        steering=steering,
        steering_limit=float(np.clip(limit, *_LIMITS)),
        free=_free(urdf, driven),
    )


def _limit(urdf: Urdf, name: str) -> float:
    limits = urdf.joints[name].limits
    return _LIMITS[1] if limits is None else min(abs(limits[0]), abs(limits[1]))


def _free(urdf: Urdf, driven: tuple[str, ...]) -> tuple[str, ...]:
    """Return the wheels that stand on the ground beside the driven ones."""
    ground = min(float(center(urdf, name)[2]) - radius_of(urdf, name) for name in driven)
    return tuple(
        name
        for name, joint in urdf.joints.items()
        if joint.kind == "continuous"
        and name not in driven
        and joint.mimic is None
        and radius_of(urdf, name) > 0.0
        and abs(float(axis(urdf, name)[1])) > _ACROSS
        and abs(float(center(urdf, name)[2]) - radius_of(urdf, name) - ground) < _STANDS
        and _PASSIVE.search(f"{name} {joint.child}") is None
    )
