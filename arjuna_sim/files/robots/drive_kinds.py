"""Which kind of drive a robot has: by its plugin, by names, and by how its wheels stand."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

from arjuna_sim.files.robots.rollers import axes_spread, with_mecanum, with_omni
from arjuna_sim.files.robots.steering import steering_joints, with_steering
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.settings import OUTPUTS, DriveKind, DriveSettings
from arjuna_sim.model.urdf import Urdf

_OTHERWISE = {
    DriveKind.MECANUM: "it has no four mecanum wheels at four corners",
    DriveKind.OMNI: "its wheels' axes are parallel",
    DriveKind.PLANAR: "its wheels are no mecanum or omni ones",
    DriveKind.STEERED: "no joint steers a wheel",
}


def arranged(
    xml: XmlFile,
    urdf: Urdf,
    drive: DriveSettings,
    asked: DriveKind | None,
    grips: Mapping[str, tuple[float, float]],
) -> DriveSettings:
    """Return a drive as the kind that it is, with a note where it is simulated as another.

    Args:
        xml: Keeps the notes.
        urdf: The robot.
        drive: Its wheels.
        asked: The kind that its plugin names; None to find it by names and joints.
        grips: By link, the directions of friction that the file names.
    """
    if not drive.wheels or drive.kind is not DriveKind.SIDES or asked is DriveKind.SIDES:
        return drive
    kind = asked or _seen(urdf, drive)
    found: DriveSettings | None = drive
    if kind is DriveKind.STEERED:
        found = with_steering(xml, urdf, drive)
    elif kind is not None and axes_spread(urdf, drive.wheels) and len(drive.wheels) > 2:
        found = with_omni(drive, urdf)
    elif kind is not None:
        found = with_mecanum(xml, urdf, drive, grips) if kind is not DriveKind.OMNI else None
    if found is None and asked is not None:
        problem = f"is a drive by {asked.value}, but {_OTHERWISE[asked]}"
        xml.note(f"{problem}: it drives by the wheels of its two sides, and not sideways")
    elif found is not None and asked is DriveKind.PLANAR:
        xml.note(f"is {asked.value}: it moves by {found.kind.value}, which slip and push as such")
    return drive if found is None else found


def with_outputs_of(outputs: DriveSettings, drive: DriveSettings) -> DriveSettings:
    """Return the wheels of one drive with the topics, frames and limits of another."""
    return dataclasses.replace(drive, **{name: getattr(outputs, name) for name in OUTPUTS})


def _seen(urdf: Urdf, drive: DriveSettings) -> DriveKind | None:
    """Return the kind of a drive whose plugin names none."""
    children = [urdf.joints[name].child for name in drive.wheels]
    names = " ".join((urdf.name, *drive.wheels, *children)).lower()
    if "mecanum" in names:
        return DriveKind.MECANUM
    return DriveKind.STEERED if not drive.plugin and steering_joints(urdf) else None
