"""The kind of a drive, by its plugin, by names, and by its wheels: sides, rollers or steering."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping

import numpy as np

from arjuna_sim.files.robots.plugins import torque_of
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.settings import OUTPUTS, DriveKind, DriveSettings
from arjuna_sim.model.urdf import Joint, Urdf
from arjuna_sim.model.wheels import (
    axis,
    center,
    effective_track,
    is_upright,
    radius_of,
    rolling_direction,
    span,
    steered_by,
    wheel_radius,
)

_HALF = math.sqrt(0.5)
_SPREAD = (
    0.1  # least singular value of the grips, by the largest: how well all directions are driven
)
_STEERS = re.compile(r"steer|swerve|azimuth|kingpin|knuckle|turn|swivel|hinge", re.I)
_PASSIVE = re.compile(r"cast[eo]r", re.I)
_ACROSS = 0.5  # least part of a wheel's axis along y
_LIMITS = (0.05, 1.4)  # of what steering about one centre can do [rad]
_QUARTER = math.pi / 2 - 0.02  # of a turn; wheels that are steered so far point in any direction
_OTHERWISE = {
    DriveKind.MECANUM: "it has no four mecanum wheels at four corners",
    DriveKind.OMNI: "its wheels' axes are parallel",
    DriveKind.STEERED: "no joint steers a wheel",
}


def omni_drive(urdf: Urdf, names: tuple[str, ...]) -> DriveSettings | None:
    """Return the drive of omni wheels; None where axes are parallel, or of less than three."""
    # The axis of an omni wheel is within 17 degrees of level.
    level = tuple(name for name in names if abs(axis(urdf, name)[2]) < 0.3)
    if len(level) < 3 or not axes_spread(urdf, level):
        return None
    radius, width = wheel_radius(urdf, level), span(urdf, level)
    torque = torque_of(urdf, radius, len(level))
    return with_omni(DriveSettings(level, (), width, radius, torque, width, radius), urdf)


def axes_spread(urdf: Urdf, names: tuple[str, ...]) -> bool:
    """Return whether wheels' axes point in different directions, seen from above."""
    directions = [rolling_direction(urdf, name) for name in names]
    # Axes within 14 degrees of each other count as parallel.
    return any(abs(float(directions[0] @ direction)) < 0.97 for direction in directions)


def with_omni(drive: DriveSettings, urdf: Urdf) -> DriveSettings:
    """Return a drive whose wheels grip as they roll, and roll across."""
    directions = [rolling_direction(urdf, name).tolist() for name in drive.wheels]
    grips = tuple((float(x), float(y)) for x, y in directions)
    return dataclasses.replace(drive, kind=DriveKind.OMNI, grips=grips)


def with_mecanum(
    xml: XmlFile, urdf: Urdf, drive: DriveSettings, named_grips: Mapping[str, tuple[float, float]]
) -> DriveSettings | None:
    """Return a drive by four mecanum wheels; None where there are no four at four corners.

    Their lowest rollers' axes, along which they grip, point at the middle of the robot's front and
    rear: the arrangement that ros2_controllers and Gazebo drive, called X from above.

    Args:
        named_grips: By link, the directions of friction that the file names.
    """
    if len(drive.left) != 2 or len(drive.right) != 2:
        return None
    grips: dict[str, tuple[float, float]] = {}
    for side, sign in ((drive.left, 1.0), (drive.right, -1.0)):
        rear, front = sorted(side, key=lambda name: float(center(urdf, name)[0]))
        # [m] Of wheels that are closer than this none is the front one.
        if float(center(urdf, front)[0] - center(urdf, rear)[0]) < 0.02:
            return None
        grips |= {front: (_HALF, -sign * _HALF), rear: (_HALF, sign * _HALF)}
    own = {n: named_grips.get(urdf.joints[n].child) for n in grips}
    named = {n: grip for n, grip in own.items() if grip is not None}
    if len(named) == 4 and _is_holonomic(urdf, named):
        grips = named
    elif named:
        xml.note("its <fdir1> do not let mecanum wheels drive: their rollers are those of an X")
    ordered = tuple(grips[name] for name in drive.wheels)
    return dataclasses.replace(drive, kind=DriveKind.MECANUM, grips=ordered)


def _is_holonomic(urdf: Urdf, grips: Mapping[str, tuple[float, float]]) -> bool:
    rows = []
    for name, (gx, gy) in grips.items():
        x, y = center(urdf, name)[:2].tolist()
        rows.append((gx, gy, (x * gy - y * gx) / max(math.hypot(x, y), 1e-3)))
        if abs(float(rolling_direction(urdf, name) @ (gx, gy))) < _SPREAD:
            return False
    values = np.linalg.svd(np.array(rows), compute_uv=False)
    return bool(values[-1] > _SPREAD * values[0])


def steering_joints(urdf: Urdf) -> tuple[str, ...]:
    """Return the joints that turn a wheel about the vertical, but for casters.

    Those without limits steer where their wheel stands below them: a caster's trails. So do those
    of any name, with limits, that carry a wheel or an axle. One that follows another to the same
    side is one, too: each steers its own wheel.
    """
    carried = {j.parent for j in urdf.joints.values() if j.kind == "continuous"}
    return tuple(
        joint.name
        for joint in urdf.joints.values()
        if joint.child in carried
        and (joint.kind == "revolute" or (joint.kind == "continuous" and _is_above(urdf, joint)))
        and (joint.mimic is None or joint.mimic.multiplier > 0.0)
        and (
            _STEERS.search(f"{joint.name} {joint.child}") is not None
            or (joint.kind == "revolute" and _is_above(urdf, joint))
        )
        and _PASSIVE.search(f"{joint.name} {joint.child}") is None
        and is_upright(urdf, joint.name)
    )


def trails(urdf: Urdf, wheel: str) -> bool:
    """Return whether a wheel is a caster's by its place: it trails a joint that turns freely."""
    joint = next(urdf.above(urdf.joints[wheel].parent), None)
    if joint is None or joint.kind != "continuous":
        return False
    return is_upright(urdf, joint.name) and not _is_above(urdf, joint)


def _is_above(urdf: Urdf, joint: Joint) -> bool:
    """Return whether a joint stands above the wheel that it carries, or beside it on its axle."""
    pivot = np.array(urdf.T_root(joint.child).position)
    for name, wheel in urdf.joints.items():
        if wheel.parent == joint.child and wheel.kind == "continuous":
            ahead = np.cross(axis(urdf, name), (0.0, 0.0, 1.0))
            # A caster's wheel trails its hinge by a tenth of its radius or more.
            if abs(float((center(urdf, name) - pivot) @ ahead)) > 0.1 * radius_of(urdf, name):
                return False
    return True


def with_steering(xml: XmlFile, urdf: Urdf, drive: DriveSettings) -> DriveSettings | None:
    """Return a drive that steers; None where no joint does, or no wheel drives.

    Where no plugin names the driven wheels, those drive that are not steered, if there are any.
    """
    named = tuple(n for n in drive.steering if is_upright(urdf, n))
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
    limit, free = min(limit, drive.steering_limit or limit), _free(urdf, driven)
    turn = {steered_by(urdf, name, steering) for name in (*driven, *free)}
    swerves = limit >= _QUARTER and len(turn) == len(driven + free) > 1 and -1 not in turn
    sides = [tuple(n for n in driven if n in side) for side in (drive.left, drive.right)]
    return dataclasses.replace(
        drive,
        left=sides[0],
        right=sides[1],
        kind=DriveKind.SWERVE if swerves else DriveKind.STEERED,
        steering=steering,
        steering_limit=limit if swerves else float(np.clip(limit, *_LIMITS)),
        free=free,
    )


def _limit(urdf: Urdf, name: str) -> float:
    limits = urdf.joints[name].limits
    return math.pi if limits is None else min(abs(limits[0]), abs(limits[1]), math.pi)


def _free(urdf: Urdf, driven: tuple[str, ...]) -> tuple[str, ...]:
    """Return the wheels that stand on the ground beside the driven ones."""
    ground = min(float(center(urdf, name)[2]) - radius_of(urdf, name) for name in driven)
    return tuple(
        name
        for name, joint in urdf.joints.items()
        if joint.kind == "continuous"
        and name not in driven
        and joint.mimic is None
        and (urdf.links[joint.child].collisions or urdf.links[joint.child].visuals)
        and abs(float(axis(urdf, name)[1])) > _ACROSS
        # [m] Its lowest point is level with the others'.
        and abs(float(center(urdf, name)[2]) - radius_of(urdf, name) - ground) < 0.02
        and _PASSIVE.search(f"{name} {joint.child}") is None
    )


def arranged(
    xml: XmlFile,
    urdf: Urdf,
    drive: DriveSettings,
    asked: DriveKind | None,
    grips: Mapping[str, tuple[float, float]],
) -> DriveSettings:
    """Return a drive as the kind that it is, with a note where it is simulated as another.

    Args:
        asked: The kind that its plugin names; None to find it by names and joints.
        grips: By link, the directions of friction that the file names.
    """
    if not drive.wheels or drive.kind is not DriveKind.SIDES or asked is DriveKind.SIDES:
        return drive
    kind = asked or _seen(urdf, drive, grips)
    found: DriveSettings | None = drive
    if kind is DriveKind.STEERED:
        found = with_steering(xml, urdf, drive)
    elif kind is not None and axes_spread(urdf, drive.wheels) and len(drive.wheels) > 2:
        found = with_omni(drive, urdf)
    elif kind is not None:
        found = with_mecanum(xml, urdf, drive, grips) if kind is not DriveKind.OMNI else None
    if found is None and asked in _OTHERWISE:
        problem = f"is a drive by {asked.value}, but {_OTHERWISE[asked]}"
        xml.note(f"{problem}: it drives by the wheels of its two sides, and not sideways")
    elif found is not None and asked is DriveKind.PLANAR:
        xml.note(f"is {asked.value}: it moves by {found.kind.value}, which slip and push as such")
    return drive if found is None else found


def joined(urdf: Urdf, first: DriveSettings, second: DriveSettings) -> DriveSettings | None:
    """Return a drive by the wheels of two plugins, one for each axle, that obey one topic.

    None where they are no such two.
    """
    left, right = (*first.left, *second.left), (*first.right, *second.right)
    same = first.command_topic.lstrip("/") == second.command_topic.lstrip("/")
    if (
        not (same and first.right and second.right)
        or second.steering
        or len({*left, *right}) < len(left + right)
    ):
        return None
    track = effective_track(urdf, left, right) or first.effective_track
    return dataclasses.replace(first, left=left, right=right, effective_track=track)


def with_outputs_of(outputs: DriveSettings, drive: DriveSettings) -> DriveSettings:
    """Return the wheels of one drive with the topics, frames and limits of another."""
    return dataclasses.replace(drive, **{name: getattr(outputs, name) for name in OUTPUTS})


def _seen(
    urdf: Urdf, drive: DriveSettings, grips: Mapping[str, tuple[float, float]]
) -> DriveKind | None:
    own = {n: grips[urdf.joints[n].child] for n in drive.wheels if urdf.joints[n].child in grips}
    if len(own) == len(drive.wheels) == 4 and _is_holonomic(urdf, own):
        return DriveKind.MECANUM
    children = [urdf.joints[name].child for name in drive.wheels]
    names = " ".join((urdf.name, *drive.wheels, *children)).lower()
    if "mecanum" in names:
        return DriveKind.MECANUM
    steers = drive.steering or (not drive.plugin and steering_joints(urdf))
    return DriveKind.STEERED if steers else None
