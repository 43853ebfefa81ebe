"""Wheels that a robot's file has not: those that a track runs on, and those of a planar base.

Gazebo moves the surface of tracks, and a planar base without any wheels' help. Here wheels do it,
which push, slip and tip as such; they are in no description and no joint states.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable
from typing import Any
from xml.etree.ElementTree import Element  # a type alone

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.pose3 import Pose3
from arjuna_sim.files.robots.drive_kinds import with_mecanum
from arjuna_sim.files.robots.plugins import (
    Sides,
    drive_kind,
    facing_ahead,
    limits_of,
    torque_of,
    types_of,
)
from arjuna_sim.files.sensor_tag import Tags
from arjuna_sim.files.tag_text import text_of, value
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape, inertial_of_parts, points_of
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.settings import DriveKind, DriveSettings
from arjuna_sim.model.urdf import Joint, Link, Urdf
from arjuna_sim.model.wheels import CASTER_GAP_MAX, center, effective_track, wheel_separation

_LEVEL = 0.01  # wheels that are higher than the lowest one by more meet no ground [m]
_TOUCH = 0.001  # of those, the ones that bear it on level ground [m]
_UNLIKE = 0.05  # part of the tracks' separation from which on the file contradicts the links
_WHEELS_MAX = 8  # of a track
_MASS = 0.01  # of each wheel, of the robot's
_ACROSS = Pose3.from_rpy((0.0, 0.0, 0.0), (math.pi / 2, 0.0, 0.0))  # a cylinder's axis along y


@dataclasses.dataclass(frozen=True)
class _Wheel:
    """A wheel in the root's frame: its middle, radius and width [m]."""

    middle: tuple[float, float, float]
    radius: float
    width: float

    @property
    def lowest(self) -> float:
        return self.middle[2] - self.radius

    def shrunk(self, radius: float) -> _Wheel:
        """Return a smaller wheel that touches the same ground."""
        x, y, _ = self.middle
        return _Wheel((x, y, self.lowest + radius), radius, self.width)


def on_tracks(
    xml: XmlFile, urdf: Urdf, tracks: Sides, tags: Tags
) -> tuple[Urdf, DriveSettings, dict[str, float]]:
    """Return a robot whose tracks are rows of wheels, its drive, and its links' friction.

    Wheels stand where a track meets the ground, of one size, so that all of it runs at one speed.
    Tracks that are off the ground, as flippers are, do not turn.

    Args:
        tags: Of the robot; a TrackController limits how its track runs.

    Raises:
        RobotError: A side has no track on the ground.
    """
    plugins = tags.plugins
    controllers = [p for p in plugins if "trackcontroller" in types_of(p)]
    limits = {text_of(p, "link"): limits_of(xml, "TrackController", p) for p in controllers}
    rows = {link: _row(urdf, link) for side in tracks for link in side}
    ground = min((wheel.lowest for row in rows.values() for wheel in row), default=0.0)
    rows = {
        link: [wheel for wheel in row if wheel.lowest < ground + _LEVEL]
        for link, row in rows.items()
    }
    radius = min((wheel.radius for row in rows.values() for wheel in row), default=0.0)
    friction, sides = dict(tags.friction), list[tuple[str, ...]]()
    for side in tracks:
        names: list[str] = []
        for link in side:
            if not rows[link]:
                xml.note(
                    f"link '{link}': is off the ground: its track stands", NoteKind.UNSUPPORTED
                )
                continue
            raised = tuple(
                part
                for part in urdf.links[link].collisions
                if part.points(urdf.T_root(link))[:, 2].min() >= ground + _LEVEL
            )
            wheels = [wheel.shrunk(radius) for wheel in rows[link]]
            most = limits.get(link, {}).get("max_velocity", 0.0)
            urdf, added = _with_wheels(urdf, link, wheels, most / radius)
            bare = dataclasses.replace(urdf.links[link], collisions=raised)
            urdf = dataclasses.replace(urdf, links={**urdf.links, link: bare})
            own = friction.get(link)
            friction |= {} if own is None else {urdf.joints[n].child: own for n in added}
            names += added
        sides.append(tuple(names))
    left, right = sides
    if not left or not right:
        raise xml.fail("tracks", "a side has no track with a <collision> on the ground")
    left, right = facing_ahead(xml, "tracks", urdf, left, right)
    bearing = _bearing(urdf, left), _bearing(urdf, right)
    drive = DriveSettings(
        *(left, right, _separation(xml, plugins, wheel_separation(urdf, *bearing)), radius),
        *(torque_of(urdf, radius, len(left + right)), effective_track(urdf, *bearing), radius),
    )
    return urdf, strictest(drive, *limits.values()), friction


def strictest(drive: DriveSettings, *limits: dict[str, float]) -> DriveSettings:
    """Return a drive that changes its speed no faster than it and some limits allow, 0 for any."""
    strict: dict[str, Any] = {}
    for key in ("max_acceleration", "max_deceleration", "max_jerk"):
        known = [getattr(drive, key), *(each[key] for each in limits)]
        strict[key] = min((each for each in known if each > 0.0), default=0.0)
    return dataclasses.replace(drive, **strict)


def _separation(xml: XmlFile, plugins: Iterable[Element], seen: float) -> float:
    """Return the distance between tracks as the file says; by default that of the links [m]."""
    said = seen
    for plugin in plugins:
        if drive_kind(plugin) is DriveKind.TRACKED:
            label = f"plugin '{plugin.get('name')}'"
            said = value(xml, plugin, label, seen, "tracksseparation")
            if abs(said - seen) > _UNLIKE * seen:
                tracks = f"tracks_separation is {said:g}, but the tracks are {seen:g} apart"
                xml.note(f"{label}: {tracks}: it drives by that")
    return said


def _bearing(urdf: Urdf, side: tuple[str, ...]) -> tuple[str, ...]:
    """Return those of a side's wheels, all of one size, that stand lowest and bear the robot."""
    heights = {name: float(center(urdf, name)[2]) for name in side}
    return tuple(name for name in side if heights[name] < min(heights.values()) + _TOUCH)


def on_rollers(xml: XmlFile, urdf: Urdf) -> tuple[Urdf, DriveSettings | None]:
    """Return a robot on four mecanum wheels below its own, and its drive; None without shapes.

    Raises:
        RobotError: A mesh is not there: where its body is, under which they stand, is not known.
    """
    for note in xml.notes:
        if (note.kind, note.of) == (NoteKind.MISSING, "collision"):
            problem = "is moved in the plane, on wheels that would stand below what is not there"
            raise xml.fail("drive", f"{problem}: {note.text}")
    points = np.vstack([np.zeros((0, 3)), *(_points(urdf, link) for link in urdf.links)])
    if not len(points):
        return urdf, None
    low, high = points.min(axis=0), points.max(axis=0)
    (x, y), half = ((low + high) / 2)[:2].tolist(), (high - low) / 2
    radius = 0.3 * float(half[:2].min())
    # Its own wheels and casters stay clear of the ground, so that they neither roll nor rub.
    height = float(low[2]) - 1.1 * CASTER_GAP_MAX + radius
    # Of a round robot the corners at 0.6 of its half width are within its outline.
    wheels = [
        _Wheel((x + 0.6 * i * float(half[0]), y + 0.6 * j * float(half[1]), height), radius, radius)
        for j in (1, -1)
        for i in (-1, 1)
    ]
    urdf, names = _with_wheels(urdf, urdf.root, wheels)
    (left, right), width = (tuple(names[:2]), tuple(names[2:])), 1.2 * float(half[1])
    torque = torque_of(urdf, radius, 4)
    drive = DriveSettings(left, right, width, radius, torque, width, radius)
    return urdf, with_mecanum(xml, urdf, drive, {})


def _points(urdf: Urdf, link: str) -> Floats:
    """Return the corners of a link's solid shapes in the root's frame, `(N, 3) float64` [m]."""
    return points_of(urdf.links[link].collisions, urdf.T_root(link))


def _row(urdf: Urdf, link: str) -> list[_Wheel]:
    """Return the wheels on which a track runs: round shapes as they are, and between them more."""
    points, T = _points(urdf, link), urdf.T_root(link)
    if not len(points):
        return []
    low, high = points.min(axis=0), points.max(axis=0)
    y, width = float(low[1] + high[1]) / 2, float(high[1] - low[1])
    ends: list[tuple[float, float, float]] = []  # along, up and radius
    for part in urdf.links[link].collisions:
        pose = T @ part.pose
        if part.shape.kind is Kind.SPHERE or (
            part.shape.kind is Kind.CYLINDER and abs(float(pose.rotation()[1, 2])) > 0.9
        ):
            ends.append((pose.position[0], pose.position[2], part.shape.size[0]))
    radius = float(min(high[2] - low[2], high[0] - low[0])) / 2
    rear, front, z = float(low[0]) + radius, float(high[0]) - radius, float(low[2]) + radius
    first, last = (min(ends)[0], max(ends)[0]) if ends else (math.inf, -math.inf)
    # What reaches beyond its round shapes by more than a tenth of its radius is track, too.
    ends += [(rear, z, radius)] if rear < first - 0.1 * radius else []
    ends += [(front, z, radius)] if front > last + 0.1 * radius else []
    found = sorted(set(ends))
    row = found[:1]
    for a, b in itertools.pairwise(found):
        gaps = max(1, min(_WHEELS_MAX, math.ceil((b[0] - a[0]) / max(a[2] + b[2], 1e-3))))
        row += [tuple(np.add(a, np.subtract(b, a) * (i + 1) / gaps).tolist()) for i in range(gaps)]
    return [_Wheel((x, y, z), radius, width) for x, z, radius in row]


def _with_wheels(
    urdf: Urdf, parent: str, wheels: list[_Wheel], most: float = 0.0
) -> tuple[Urdf, list[str]]:
    """Return a robot with wheels on a link, which turn about y of the root, and their joints.

    Args:
        most: How fast they may turn, 0 for no limit [rad/s].
    """
    links, joints, names = dict(urdf.links), dict(urdf.joints), []
    T_parent_root = urdf.T_root(parent).inverse()
    for i, wheel in enumerate(wheels):
        name = f"{parent}/wheel_{i}"
        part = Part(Shape(Kind.CYLINDER, (wheel.radius, wheel.width)), _ACROSS)
        mass = max(_MASS * urdf.mass, 1e-3)
        links[name] = Link(name, inertial_of_parts([part], mass), (part,), ())
        T = T_parent_root @ Pose3(wheel.middle)
        joints[name] = Joint(name, "continuous", parent, name, T, (0.0, 1.0, 0.0), max_speed=most)
        names.append(name)
    return dataclasses.replace(urdf, links=links, joints=joints), names
