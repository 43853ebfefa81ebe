"""Links of a world's model that move as one, and the hinges on which they swing."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

import numpy as np

from arjuna_core.arrays import Ints
from arjuna_sim.files.sdf.includes import leaving_out
from arjuna_sim.files.sdf.model_tags import SWINGING, WORLD, SdfJoint, SdfLink
from arjuna_sim.files.xml_file import UNLIMITED, XmlFile
from arjuna_sim.model.entities import bounds
from arjuna_sim.model.geometry.shapes import Kind
from arjuna_sim.model.geometry.thickness import numbered
from arjuna_sim.model.urdf import Hinge

_AXES = {
    **dict.fromkeys(SWINGING, ("axis",)),
    **dict.fromkeys(("universal", "revolute2"), ("axis", "axis2")),
    "ball": (),
}
"""Kinds of joints that let a link move, and the tags of their axes."""


def read_hinge(joint: SdfJoint, link: SdfLink, own: set[str]) -> Hinge | None:
    """Read the joint between what swings and what stands fast; None if it has no play.

    Args:
        link: The link whose frame is that of what swings.
        own: Names of the links that swing.

    Raises:
        WorldError: An axis or a limit is invalid.
    """
    xml, label = joint.file, f"joint '{joint.element.get('name', '?')}'"
    T_link, swings = link.T_world.inverse(), joint.child in own
    x, y, z = T_link.apply(np.array([joint.T_world.position]))[0].tolist()
    axes = [xml.child(joint.element, tag, label) for tag in _AXES[joint.kind]]
    hinge = None if axes else Hinge(False, None, (x, y, z))
    order = -1 if swings else 1  # the last axis is the child's; else the parent swings
    for axis, T_axis in list(zip(axes, joint.T_axes, strict=False))[::order]:
        toward = np.array(xml.numbers(axis.findtext("xyz") or "0 0 1", 3, f"{label} <xyz>"))
        length = math.hypot(*toward)
        if not 0.0 < length < math.inf:
            raise xml.fail(label, "axis must not be zero")
        along = (T_link @ T_axis).rotation() @ toward / (length if swings else -length)
        a, b, c = along.tolist()
        limits = None if joint.kind == "continuous" else _limits(xml, axis, label)
        if limits is None or limits[0] < limits[1]:
            kind, dynamics = joint.kind == "prismatic", joint.dynamics(axis)
            hinge = Hinge(kind, (a, b, c), (x, y, z), limits, **dynamics, further=hinge)
    return hinge


def _limits(xml: XmlFile, axis: Element, label: str) -> tuple[float, float] | None:
    low = xml.limit(axis.findtext("limit/lower"), -UNLIMITED, f"{label} <lower>")
    high = xml.limit(axis.findtext("limit/upper"), UNLIMITED, f"{label} <upper>")
    return (low, high) if low > -UNLIMITED or high < UNLIMITED else None


@dataclass(frozen=True)
class RigidGroup:
    """Links that move as one.

    Attributes:
        fast: Whether they stand fast in the world.
        hinge: How they swing, where a joint connects them to what they hang on.
        on: The place in the list of the group that they hang on; None where it is the world.
        joint: The name of the joint on which they swing.
    """

    links: list[SdfLink]
    fast: bool
    hinge: Hinge | None = None
    on: int | None = None
    joint: str = ""


def rigid_groups(
    xml: XmlFile,
    label: str,
    links: list[SdfLink],
    joints: list[SdfJoint],
    driven: Collection[str] = (),
) -> list[RigidGroup]:
    """Group a model's links; what stands fast comes first, and each before what hangs on it.

    Links hold together by fixed joints, or where no joint connects them and they overlap: Gazebo
    lets links of one model pass through each other. A group that a hinge or slide connects to
    another hangs on it, as a handle on a door or a wheel on a cart. Where such joints make a ring,
    or one is of another kind or driven, what they connect holds together, with a note.

    Args:
        driven: Names of joints that plugins move or hold.
    """
    index = {**{link.name: i for i, link in enumerate(links)}, WORLD: -1}
    ends = [(j, index.get(j.parent, -2), index.get(j.child, -2)) for j in joints]
    fixed = [(a, b) for j, a, b in ends if j.kind == "fixed" and min(a, b) > -2]
    moving = [(j, a, b) for j, a, b in ends if j.kind != "fixed" and min(a, b) > -2]
    held = [i for i, link in enumerate(links) if _stands(link)]
    held += [max(pair) for pair in fixed if min(pair) < 0 <= max(pair)]
    jointed = {i for pair in (*fixed, *((a, b) for _, a, b in moving)) for i in pair}
    bodies = _Hanging(_joined(links, fixed, jointed), held, moving)
    free = [(j, a, b) for j, a, b in moving if min(bodies.number(a), bodies.number(b)) >= 0]
    stiff = [one for one in free if not _plays(xml, label, one, links, driven)]
    for is_last in (False, True):
        if stiff:
            pairs = [*fixed, *((a, b) for _, a, b in stiff)]
            bodies = _Hanging(_joined(links, pairs, jointed), held, moving)
        stiff += [j for j in free if not is_last and bodies.number(j[1]) in bodies.rings]
    if stiff:
        names = ", ".join(dict.fromkeys(j.name for j, _, _ in stiff))
        xml.note(f"{label}: its links hold together as one body at {names}")
    return _groups_of(xml, label, links, bodies)


def with_belts(groups: list[RigidGroup], belts: Mapping[str, Hinge]) -> list[RigidGroup]:
    """Return groups with each belt apart from what stands fast, behind all that does not run."""
    kept, running = list[RigidGroup](), list[RigidGroup]()
    for group in groups:
        own = [link for link in group.links if group.fast and link.name in belts]
        running += [RigidGroup([one], False, belts[one.name], None, one.name) for one in own]
        rest = [link for link in group.links if link not in own]
        kept += [dataclasses.replace(group, links=rest)] if rest else []
    return kept + running


def _groups_of(
    xml: XmlFile, label: str, links: list[SdfLink], bodies: _Hanging
) -> list[RigidGroup]:
    standing = [link for i, link in enumerate(links) if bodies.number(i) < 0]
    groups = [RigidGroup(standing, True)] if standing else []
    base, places = 0 if groups else None, dict[int, int]()
    for number, found, on in bodies.walk():
        own = [link for i, link in enumerate(links) if bodies.number(i) == number]
        places[number] = len(groups)
        groups.append(_on_hinge(xml, label, own, found, base if on is None else places[on]))
    return groups


class _Hanging:
    """Which bodies hang on which.

    Args:
        body_of: A number for each link, the same for those that hold together.
        held: The links that stand fast.
        moving: Joints that are not fixed, and the links of each; below 0 for the world.

    Attributes:
        rings: Those of bodies that do not hang on each other as a tree.
    """

    def __init__(
        self, body_of: Ints, held: list[int], moving: list[tuple[SdfJoint, int, int]]
    ) -> None:
        self._body_of, self._fast = body_of, set(body_of[held].tolist())
        self._above: dict[int, list[SdfJoint]] = {}
        self._beside: dict[int, list[tuple[SdfJoint, int]]] = {}
        for joint, a, b in moving:
            one, other = self.number(a), self.number(b)
            if one != other and min(one, other) < 0:
                self._above.setdefault(max(one, other), []).append(joint)
            elif one != other:
                self._beside.setdefault(one, []).append((joint, other))
                self._beside.setdefault(other, []).append((joint, one))
        trees = [self._connected(number) for number in self._beside]
        self.rings = {number for tree in trees if not self._is_tree(tree) for number in tree}

    def number(self, link: int) -> int:
        """Return the number of a link's body; -1 for what stands fast."""
        number = int(self._body_of[link]) if link >= 0 else -1
        return -1 if number in self._fast else number

    def _is_tree(self, numbers: list[int]) -> bool:
        above = sum(len(self._above.get(number, ())) for number in numbers)
        return above < 2 and sum(len(self._beside[n]) for n in numbers) // 2 < len(numbers)

    def _connected(self, number: int) -> list[int]:
        found = {number: None}
        for one in (stack := [number]):
            others = [other for _, other in self._beside.get(one, ()) if other not in found]
            found |= dict.fromkeys(others)
            stack += dict.fromkeys(others)
        return list(found)

    def walk(self) -> Iterator[tuple[int, list[SdfJoint], int | None]]:
        """Yield each body that moves, its joints and the body that it hangs on, that one first."""
        seen = set[int]()
        for first in dict.fromkeys(self.number(i) for i in range(len(self._body_of))):
            if first < 0 or first in seen:
                continue
            root = next((one for one in self._connected(first) if one in self._above), first)
            stack: list[tuple[int, list[SdfJoint], int | None]]
            stack = [(root, self._above.get(root, []), None)]
            while stack:
                number, joints, on = stack.pop()
                seen.add(number)
                yield number, joints, on
                below = [each for each in self._beside.get(number, ()) if each[1] not in seen]
                stack += [(other, [joint], number) for joint, other in reversed(below)]


def _plays(
    xml: XmlFile,
    label: str,
    connection: tuple[SdfJoint, int, int],
    links: list[SdfLink],
    driven: Collection[str],
) -> bool:
    """Return whether a joint lets the one of its two links move by the other."""
    joint, one, other = connection
    is_free = joint.kind in _AXES and joint.name not in driven
    if not is_free or not (links[one].solid and links[other].solid):
        return False
    return _on_hinge(xml, label, [links[other]], [joint], None).hinge is not None


def _stands(link: SdfLink) -> bool:
    return link.static or any(p.shape.kind in (Kind.PLANE, Kind.TERRAIN) for p in link.solid)


def _joined(links: list[SdfLink], pairs: list[tuple[int, int]], jointed: set[int]) -> Ints:
    """Return a number for each link, the same for those that hold together.

    Args:
        pairs: Indices of links that joints hold together; below 0 for the world.
        jointed: Those that any joint connects, which do not join by overlapping.
    """
    held = np.array([pair for pair in pairs if min(pair) >= 0], np.int64).reshape(-1, 2)
    return numbered(np.vstack((held, _overlaps(links, jointed))), len(links))


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


def _on_hinge(
    xml: XmlFile, label: str, links: list[SdfLink], joints: list[SdfJoint], on: int | None
) -> RigidGroup:
    if not joints:
        return RigidGroup(links, False)
    kinds = sorted({joint.kind for joint in joints})
    if len(joints) == 1 and joints[0].kind in _AXES:
        own = {link.name for link in links}
        with leaving_out(xml, f"{label} joint '{joints[0].element.get('name', '?')}'"):
            hinge = read_hinge(joints[0], links[0], own)
            return RigidGroup(links, hinge is None, hinge, on, joints[0].name)
    else:
        xml.note(f"{label}: stands fast, held by {len(joints)} joints ({', '.join(kinds)})")
    return RigidGroup(links, True)
