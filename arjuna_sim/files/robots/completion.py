"""Completing links: masses of moving parts, and the friction of casters."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Collection, Mapping

import numpy as np

from arjuna_core.pose3 import Pose3
from arjuna_sim.files.robots.rollers import turned_to
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.shapes import (
    Inertial,
    Kind,
    Part,
    Shape,
    corners,
    estimated_inertial,
    inertial_of_parts,
    volume_of,
)
from arjuna_sim.model.robot import ANCHOR
from arjuna_sim.model.settings import DriveKind, DriveSettings
from arjuna_sim.model.urdf import Link, Urdf
from arjuna_sim.model.wheels import CASTER_GAP_MAX, axis, center, is_upright, radius_of

CASTER_FRICTION = 0.01
"""Of what slides along on the ground: a fixed shape there stands for a caster, which rolls."""
_BEYOND = 4.0  # of the inertia of a mass that is all at the reach of its shapes
_LEAST = 0.01  # mass of a moving part without mass or shape [kg]
_WIDTH = 0.5  # of a wheel that has no shape, by its radius
_MARK = 0.002  # a shape that is nowhere larger only marks a frame [m]
_CASTER = re.compile(r"cast[eo]r", re.I)
_GRIP = 0.8  # of rubber on dry concrete (Wong, Theory of Ground Vehicles: 0.8 to 0.9)
_GROUND = 1.0  # friction of a ground that names none, in SDF: the lower of two holds
_PULLED = 2.0  # the weight that motors without a torque pull, `torque_of`: more friction holds them


def complete_shapes(xml: XmlFile, urdf: Urdf) -> Urdf:
    """Give a robot that could touch nothing but by its wheels the shapes by which it is drawn.

    What marks a frame, as a box of 1 mm at the ground, is not solid: it would bear the robot.
    """
    links = {name: _without_marks(link) for name, link in urdf.links.items()}
    urdf = dataclasses.replace(urdf, links=links)
    rolling = {joint.child for joint in urdf.joints.values() if joint.kind == "continuous"}
    if any(link.collisions for link in urdf.links.values() if link.name not in rolling):
        return urdf
    links = dict(urdf.links)
    for name, link in urdf.links.items():
        if link.visuals and not link.collisions:
            xml.note(f"link '{name}': has no <collision>, so it is as solid as it is drawn")
            links[name] = _without_marks(dataclasses.replace(link, collisions=link.visuals))
    if urdf.root != ANCHOR and not any(link.collisions for link in links.values()):
        xml.note("no link has a shape (<collision> or <visual>): only wheels of a drive bear it")
    return dataclasses.replace(urdf, links=links)


def _without_marks(link: Link) -> Link:
    marks = (Kind.BOX, Kind.SPHERE, Kind.CYLINDER)
    solid = (
        part
        for part in link.collisions
        if part.shape.kind not in marks or np.ptp(corners(part.shape), axis=0).max() > _MARK
    )
    return dataclasses.replace(link, collisions=tuple(solid))


def bound_inertias(xml: XmlFile, urdf: Urdf, drive: DriveSettings) -> Urdf:
    """Replace the inertias of a part that moves where its mass cannot have them in its shapes.

    Such a placeholder, as 1 kg m^2 of a wheel of 50 g, is more than all else that motors move.
    """
    links = dict(urdf.links)
    wheels = {urdf.joints[name].child for name in drive.rolling}
    for group in rigid_groups(urdf):
        least = 0.0 if wheels.isdisjoint(group) else drive.radius
        most = {name: _most_inertia(urdf, group, name, least) for name in group}
        said = {name: _greatest(urdf.links[name].inertial) for name in group}
        if not sum(said.values()) > _BEYOND * sum(most.values()) > 0.0:
            continue
        for link in (urdf.links[name] for name in group if said[name] > _BEYOND * most[name]):
            assert link.inertial is not None
            mass, parts = link.inertial.mass, link.collisions or link.visuals
            found = inertial_of_parts(parts, mass).inertia if parts else np.eye(3) * most[link.name]
            links[link.name] = dataclasses.replace(
                link, inertial=dataclasses.replace(link.inertial, inertia=found)
            )
            xml.note(
                f"link '{link.name}': {mass:.3g} kg of its size cannot have an inertia of"
                f" {said[link.name]:.3g} kg m^2: that of its shapes is taken"
            )
    return dataclasses.replace(urdf, links=links)


def _greatest(inertial: Inertial | None) -> float:
    return 0.0 if inertial is None else float(np.linalg.eigvalsh(inertial.inertia)[2])


def _most_inertia(urdf: Urdf, group: list[str], name: str, least: float) -> float:
    """Return the inertia of a link's mass at the farthest of its rigid part's shapes [kg m^2].

    Where it has none, at a least reach [m].
    """
    own = urdf.links[name].inertial
    if own is None:
        return 0.0
    middle = urdf.T_root(name).apply(np.array([own.center]))
    reaches = [
        np.linalg.norm(part.points(urdf.T_root(n)) - middle, axis=1)
        for n in group
        for part in (*urdf.links[n].collisions, *urdf.links[n].visuals)
        if part.shape.kind is not Kind.PLANE
    ]
    return own.mass * max((float(reach.max()) for reach in reaches), default=least) ** 2


def complete_masses(xml: XmlFile, urdf: Urdf) -> Urdf:
    """Give each part that moves a mass: by its shapes, where its links have none.

    Each such link is noted. A link without mass beside links with a plausible one stays massless.
    """
    links = dict(urdf.links)
    for group in rigid_groups(urdf):
        given = sum(i.mass for n in group if (i := urdf.links[n].inertial) is not None)
        parts = [part for n in group for part in urdf.links[n].collisions]
        without = [n for n in group if urdf.links[n].inertial is None]
        # [kg/m^3] A body as light as foam lacks masses that its file forgot.
        if given > 0.0 and (not parts or given > 20.0 * volume_of(parts)):
            continue
        for name in without:
            found = estimated_inertial(urdf.links[name].collisions)
            if found is not None:
                xml.note(
                    f"link '{name}': has no <inertial>: {found.mass:.3g} kg and its inertia are"
                    " computed from its shapes"
                )
                links[name] = dataclasses.replace(urdf.links[name], inertial=found)
        if given == 0.0 and all(links[n].inertial is None for n in group):
            links[group[0]] = dataclasses.replace(links[group[0]], inertial=_least(urdf, group))
            xml.note(f"link '{group[0]}': has neither mass nor solid shape: it gets {_LEAST} kg")
    return dataclasses.replace(urdf, links=links)


def _least(urdf: Urdf, group: list[str]) -> Inertial:
    parts = [part for part in urdf.links[group[0]].visuals if part.shape.kind is not Kind.PLANE]
    return inertial_of_parts(parts, _LEAST)


def rigid_groups(urdf: Urdf) -> list[list[str]]:
    """Return the links that fixed joints hold together, each group's root first."""
    fixed = {j.child: j.parent for j in urdf.joints.values() if j.kind == "fixed"}
    groups: dict[str, list[str]] = {}
    for name in urdf.links:
        top = name
        while top in fixed:
            top = fixed[top]
        group = groups.setdefault(top, [top])
        group += [name] if name != top else []
    return list(groups.values())


def friction_of(
    xml: XmlFile,
    urdf: Urdf,
    said: Mapping[str, float],
    drive: DriveSettings,
    kind: DriveKind | None = None,
) -> dict[str, float]:
    """Return the friction of links: as the file says, low where a fixed shape slides along.

    A robot that Gazebo moved without its wheels' help gets wheels that grip.

    Args:
        said: By link, what the file says.
        kind: Of drive that a plugin names.
    """
    friction = dict(said)
    wheels = {urdf.joints[name].child for name in drive.rolling}
    if kind is DriveKind.PLANAR:
        for name in sorted(n for n in wheels if friction.get(n, _GRIP) < _GRIP):
            xml.note(f"link '{name}': its friction {friction[name]:g} would slip; it gets {_GRIP}")
            friction[name] = _GRIP
    if not wheels:
        return friction
    held = sorted(name for name in wheels if friction.get(name, 0.0) > _PULLED)
    slides = drive.kind is DriveKind.SIDES and _turns_by_sliding(urdf, drive)
    if held and (slides or drive.steering):
        xml.note(
            f"links {', '.join(held)}: friction {friction[held[0]]:g} is taken to be {_GROUND:g},"
            " as of Gazebo's ground: wheels that slide in a turn would hold or overturn the robot"
        )
        friction |= dict.fromkeys(held, _GROUND)
    lowest = {n: found for n in urdf.links if (found := _lowest(urdf, n)) is not None}
    ground = _ground(urdf, drive)
    carried = {n for g in rigid_groups(urdf) if wheels.isdisjoint(g) for n in g} - _trailed(urdf)
    casters = {n: urdf.T_root(n).position[:2] for n in carried & lowest.keys() if _CASTER.search(n)}
    rubbing = (n for n in carried & lowest.keys() if lowest[n][0] < ground + CASTER_GAP_MAX)
    _loosen(xml, friction, wheels, sorted(rubbing))
    for name, (low, shape) in lowest.items():
        is_ball = shape is Kind.SPHERE
        # Of a caster's parts, which stand together, the lowest.
        is_caster = name in casters and all(
            low <= lowest[other][0] or math.dist(casters[name], casters[other]) > drive.radius
            for other in casters
        )
        # [m] A robot leans on a caster, wherever below its axles that is.
        gap = drive.radius if is_ball or is_caster else CASTER_GAP_MAX
        if name in carried and name not in friction and low < ground + gap:
            friction[name] = CASTER_FRICTION
            if not is_ball:
                xml.note(f"link '{name}': slides along on the ground, as a caster")
    return friction


def _loosen(
    xml: XmlFile, friction: dict[str, float], wheels: Collection[str], rubbing: list[str]
) -> None:
    """Let what slides along on the ground hold a robot no more than its wheels do."""
    most = min([_GROUND, *(friction.get(name, _GROUND) for name in wheels)])
    for name in (n for n in rubbing if friction.get(n, 0.0) > _PULLED):
        text = f"friction {friction[name]:g} is taken to be {most:g}, as of its wheels"
        xml.note(f"link '{name}': {text}: what slides along would hold the robot")
        friction[name] = most


def _trailed(urdf: Urdf) -> set[str]:
    """Return the wheels of trailers, which grip: those of an axle that swings about a hinge."""
    axles: dict[str, list[str]] = {}
    for name, wheel in urdf.joints.items():
        hinge = next((j for j in urdf.above(wheel.parent) if j.kind != "fixed"), None)
        # The axis of a wheel is within 17 degrees of level.
        rolls = wheel.kind == "continuous" and abs(float(axis(urdf, name)[2])) < 0.3
        if rolls and hinge is not None and is_upright(urdf, hinge.name):
            axles.setdefault(hinge.name, []).append(wheel.child)
    found = (link for links in axles.values() if len(links) > 1 for link in links)
    return {link for link in found if _CASTER.search(link) is None}


def _turns_by_sliding(urdf: Urdf, drive: DriveSettings) -> bool:
    """Return whether wheels of one side stand one behind the other."""
    along = [float(center(urdf, name)[0]) for name in drive.left]
    return max(along) - min(along) > 0.1 * drive.radius


def _ground(urdf: Urdf, drive: DriveSettings) -> float:
    """Return where the lowest wheel touches the ground, in the root's frame [m]."""
    return min(
        float(center(urdf, name)[2]) - (radius_of(urdf, name) or drive.radius)
        for name in drive.rolling
    )


def complete_wheels(xml: XmlFile, urdf: Urdf, drive: DriveSettings) -> Urdf:
    """Give wheels without a shape, whose meshes are missing, cylinders of the drive's radius."""
    links = dict(urdf.links)
    for joint in map(urdf.joints.__getitem__, drive.rolling):
        link = links[joint.child]
        if link.collisions or link.visuals:
            continue
        shape = Shape(Kind.CYLINDER, (drive.radius, _WIDTH * drive.radius))
        wheel = Part(shape, turned_to(np.array(joint.axis)))
        links[link.name] = dataclasses.replace(link, collisions=(wheel,))
        xml.note(
            f"link '{link.name}': has no shape: a cylinder of radius {drive.radius:.3g} m is taken"
        )
    return dataclasses.replace(urdf, links=links)


def complete_casters(xml: XmlFile, urdf: Urdf, drive: DriveSettings) -> Urdf:
    """Give casters balls that reach the ground, where none has a shape: their meshes are missing.

    Without, a robot on two wheels tips over. A ball's centre is the caster's centre of mass.
    """
    carriers = {urdf.joints[name].parent for name in drive.rolling}
    named = (link for name, link in urdf.links.items() if _CASTER.search(name))
    casters = [link for link in named if link.name not in carriers]
    if not drive.rolling or any(link.collisions or link.visuals for link in casters):
        return urdf
    ground, links = _ground(urdf, drive), dict(urdf.links)
    fixed = next(group for group in rigid_groups(urdf) if urdf.root in group)
    for link in casters:
        if link.inertial is None or link.name not in fixed:
            continue
        height = float(urdf.T_root(link.name).apply(np.array([link.inertial.center]))[0, 2])
        if _MARK < (radius := height - ground) < 2.0 * drive.radius:
            ball = Part(Shape(Kind.SPHERE, (radius,)), Pose3(link.inertial.center))
            links[link.name] = dataclasses.replace(link, collisions=(ball,))
            xml.note(f"link '{link.name}': has no shape: a ball of radius {radius:.3g} m is taken")
    return dataclasses.replace(urdf, links=links)


def _lowest(urdf: Urdf, name: str) -> tuple[float, Kind] | None:
    """Return how low a link's solid shapes reach in the root's frame [m], and the shape there."""
    T = urdf.T_root(name)
    heights = [
        (float(part.points(T)[:, 2].min()), part.shape.kind) for part in urdf.links[name].collisions
    ]
    return min(heights, default=None, key=lambda low: low[0])
