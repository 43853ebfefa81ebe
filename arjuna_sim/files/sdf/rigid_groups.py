"""Links of a world's model that move as one, and the hinges on which they swing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from arjuna_core.arrays import Ints
from arjuna_sim.files.sdf.includes import leaving_out
from arjuna_sim.files.sdf.model_tags import SWINGING, WORLD, SdfJoint, SdfLink
from arjuna_sim.files.xml_file import UNLIMITED, XmlFile
from arjuna_sim.model.entities import bounds
from arjuna_sim.model.geometry.shapes import Kind
from arjuna_sim.model.urdf import Hinge


def read_hinge(joint: SdfJoint, link: SdfLink, own: set[str]) -> Hinge:
    """Read the joint between what swings and what stands fast.

    Args:
        link: The link whose frame is that of what swings.
        own: Names of the links that swing.

    Raises:
        WorldError: Its axis or a limit is invalid.
    """
    xml, label = joint.file, f"joint '{joint.element.get('name', '?')}'"
    axis = xml.child(joint.element, "axis", label)
    toward = np.array(xml.numbers(axis.findtext("xyz") or "0 0 1", 3, f"{label} <xyz>"))
    length = math.hypot(*toward)
    if not 0.0 < length < math.inf:
        raise xml.fail(label, "axis must not be zero")
    T_link = link.T_world.inverse()
    along = T_link.rotation() @ joint.T_axis.rotation() @ toward / length
    x, y, z = T_link.apply(np.array([joint.T_world.position]))[0]
    sign = 1.0 if joint.child in own else -1.0  # else the parent swings
    a, b, c = (sign * along).tolist()
    return Hinge(
        joint.kind == "prismatic",
        (a, b, c),
        (float(x), float(y), float(z)),
        None if joint.kind == "continuous" else _limits(xml, axis, label),
        max(0.0, xml.number(axis, "dynamics/damping", 0.0, label)),
        max(0.0, xml.number(axis, "dynamics/friction", 0.0, label)),
    )


def _limits(xml: XmlFile, axis: Element, label: str) -> tuple[float, float] | None:
    low = xml.limit(axis.findtext("limit/lower"), -UNLIMITED, f"{label} <lower>")
    high = xml.limit(axis.findtext("limit/upper"), UNLIMITED, f"{label} <upper>")
    return (low, high) if low > -UNLIMITED or high < UNLIMITED else None


@dataclass(frozen=True)
class RigidGroup:
    """Links that move as one.

    Attributes:
        fast: Whether they stand fast in the world.
        hinge: How they swing, where a joint connects them to what stands fast.
    """

    links: list[SdfLink]
    fast: bool
    hinge: Hinge | None = None


def rigid_groups(
    xml: XmlFile, label: str, links: list[SdfLink], joints: list[SdfJoint]
) -> list[RigidGroup]:
    """Group a model's links; what stands fast comes first.

    Links hold together by fixed joints, or where no joint connects them and they overlap: Gazebo
    lets links of one model pass through each other. A group that a hinge or slide connects to what
    stands fast swings on it. Groups that joints connect to each other, such as a cart and its
    wheels, hold together, with a note.
    """
    index = {**{link.name: i for i, link in enumerate(links)}, WORLD: -1}
    ends = [(j, index.get(j.parent, -2), index.get(j.child, -2)) for j in joints]
    fixed = [(a, b) for j, a, b in ends if j.kind == "fixed" and min(a, b) > -2]
    moving = [(j, a, b) for j, a, b in ends if j.kind != "fixed" and min(a, b) > -2]
    held = [i for i, link in enumerate(links) if _stands(link)]
    held += [max(pair) for pair in fixed if min(pair) < 0 <= max(pair)]
    body_of = _joined(links, fixed, [*fixed, *((a, b) for _, a, b in moving)])
    fast = set(body_of[held].tolist())
    free = [
        (a, b) for _, a, b in moving if min(a, b) >= 0 and fast.isdisjoint(body_of[[a, b]].tolist())
    ]
    if free:
        xml.note(f"{label}: its links hold together as one body")
        body_of = _joined(links, [*fixed, *free], [*fixed, *free])
        fast = set(body_of[held].tolist())
    suspended: dict[int, list[SdfJoint]] = {}
    for joint, *pair in moving:
        bodies = {int(body_of[i]) if i >= 0 else -1 for i in pair}
        for number in bodies - fast - {-1} if len(bodies) > 1 else ():  # else within one body
            suspended.setdefault(number, []).append(joint)
    groups = [RigidGroup([link for i, link in enumerate(links) if int(body_of[i]) in fast], True)]
    for number in dict.fromkeys(int(value) for value in body_of if int(value) not in fast):
        own = [link for i, link in enumerate(links) if body_of[i] == number]
        groups.append(_on_hinge(xml, label, own, suspended.get(number, [])))
    return [group for group in groups if group.links]


def _stands(link: SdfLink) -> bool:
    return link.static or any(p.shape.kind in (Kind.PLANE, Kind.TERRAIN) for p in link.solid)


def _joined(
    links: list[SdfLink], pairs: list[tuple[int, int]], jointed: list[tuple[int, int]]
) -> Ints:
    """Return a number for each link, the same for those that hold together.

    Args:
        pairs: Indices of links that joints hold together; below 0 for the world.
        jointed: Those of links that any joint connects, which do not join by overlapping.
    """
    edges = [pair for pair in pairs if min(pair) >= 0]
    loose = _overlaps(links, {i for pair in jointed for i in pair})
    rows, columns = np.vstack((np.array(edges, np.int64).reshape(-1, 2), loose)).T
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(len(links), len(links)))
    return np.asarray(connected_components(graph, directed=False)[1], np.int64)


def _overlaps(links: list[SdfLink], jointed: set[int]) -> Ints:
    """Return the pairs of links without joints whose bounding boxes overlap, `(N, 2)`."""
    loose = [i for i, link in enumerate(links) if i not in jointed and link.solid]
    loose = [i for i in loose if not _stands(links[i])]
    boxes = np.array([bounds(links[i].solid) for i in loose]).reshape(-1, 2, 3)
    # [m] Boxes that overlap by less than 1 mm only touch.
    low, high = boxes[:, 0], boxes[:, 1] - 1e-3
    pairs = [np.empty((0, 2), np.int64)]
    for i in range(len(loose)):
        others = np.flatnonzero(((low[i] < high[:i]) & (low[:i] < high[i])).all(axis=1))
        pairs.append(np.column_stack((np.full(len(others), i), others)))
    return np.array(loose, np.int64)[np.vstack(pairs)]


def _on_hinge(xml: XmlFile, label: str, links: list[SdfLink], joints: list[SdfJoint]) -> RigidGroup:
    if not joints:
        return RigidGroup(links, False)
    kinds = sorted({joint.kind for joint in joints})
    if len(joints) == 1 and joints[0].kind in SWINGING:
        own = {link.name for link in links}
        with leaving_out(xml, f"{label} joint '{joints[0].element.get('name', '?')}'"):
            hinge = read_hinge(joints[0], links[0], own)
            is_locked = hinge.limits is not None and hinge.limits[0] >= hinge.limits[1]
            return RigidGroup(links, is_locked, None if is_locked else hinge)
    else:
        xml.note(f"{label}: stands fast, held by {len(joints)} joints ({', '.join(kinds)})")
    return RigidGroup(links, True)
