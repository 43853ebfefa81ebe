"""Finding how the wheels of a robot with mecanum or omni wheels grip."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np

from arjuna_sim.files.robots.plugins import torque_of
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.settings import DriveKind, DriveSettings
from arjuna_sim.model.urdf import Urdf
from arjuna_sim.model.wheels import axis, center, rolling_direction, span, wheel_radius

_LEVEL = 0.3  # greatest part of a wheel's axis along z
_PARALLEL = 0.97  # cosine from which axes have the same direction
_APART = 0.02  # of a front wheel and a rear one [m]
_HALF = math.sqrt(0.5)
_SPREAD = 0.1  # least singular value of the grips, by the largest: how well all ways are driven


def omni_drive(urdf: Urdf, names: tuple[str, ...]) -> DriveSettings | None:
    """Return the drive of omni wheels; None where axes are parallel, or of less than three."""
    level = tuple(name for name in names if abs(axis(urdf, name)[2]) < _LEVEL)
    if len(level) < 3 or not axes_spread(urdf, level):
        return None
    radius, width = wheel_radius(urdf, level), span(urdf, level)
    torque = torque_of(urdf, radius, len(level))
    return with_omni(DriveSettings(level, (), width, radius, torque, width, radius), urdf)


def axes_spread(urdf: Urdf, names: tuple[str, ...]) -> bool:
    """Tell whether wheels' axes point different ways, seen from above."""
    ways = [rolling_direction(urdf, name) for name in names]
    return any(abs(float(ways[0] @ way)) < _PARALLEL for way in ways)


def with_omni(drive: DriveSettings, urdf: Urdf) -> DriveSettings:
    """Return a drive whose wheels grip as they roll, and roll across."""
    ways = [rolling_direction(urdf, name).tolist() for name in drive.wheels]
    grips = tuple((float(x), float(y)) for x, y in ways)
    return dataclasses.replace(drive, kind=DriveKind.OMNI, grips=grips)


def with_mecanum(
    xml: XmlFile, urdf: Urdf, drive: DriveSettings, told: Mapping[str, tuple[float, float]]
) -> DriveSettings | None:
    """Return a drive by four mecanum wheels; None where there are no four at four corners.

    Their lowest rollers' axes, along which they grip, point at the middle of the robot's front and
    rear: the arrangement that ros2_controllers and Gazebo drive, called X from above.

    Args:
        xml: Keeps the notes.
        urdf: The robot.
        drive: Its wheels, by sides.
        told: By link, the directions of friction that the file names.
    """
    if len(drive.left) != 2 or len(drive.right) != 2:
        return None
    grips: dict[str, tuple[float, float]] = {}
    for side, sign in ((drive.left, 1.0), (drive.right, -1.0)):
        rear, front = sorted(side, key=lambda name: float(center(urdf, name)[0]))
        if float(center(urdf, front)[0] - center(urdf, rear)[0]) < _APART:
            return None
        grips |= {front: (_HALF, -sign * _HALF), rear: (_HALF, sign * _HALF)}
    own = {n: told.get(urdf.joints[n].child) for n in grips}
    named = {n: grip for n, grip in own.items() if grip is not None}
    if len(named) == 4 and _drives_all_ways(urdf, named):
        grips = named
    elif named:
        xml.note("its <fdir1> do not let mecanum wheels drive: their rollers are those of an X")
    ordered = tuple(grips[name] for name in drive.wheels)
    return dataclasses.replace(drive, kind=DriveKind.MECANUM, grips=ordered)


def _drives_all_ways(urdf: Urdf, grips: Mapping[str, tuple[float, float]]) -> bool:
    rows = []
    for name, (gx, gy) in grips.items():
        x, y = center(urdf, name)[:2].tolist()
        rows.append((gx, gy, (x * gy - y * gx) / max(math.hypot(x, y), 1e-3)))
        if abs(float(rolling_direction(urdf, name) @ (gx, gy))) < _SPREAD:
            return False
    values = np.linalg.svd(np.array(rows), compute_uv=False)
    return bool(values[-1] > _SPREAD * values[0])
