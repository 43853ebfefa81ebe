"""Rules that links and joints keep, from whichever file they are."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.errors import RobotError, nearest
from arjuna_core.files.xml_text import DEPTH_MAX
from arjuna_core.pose3 import Pose3
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.shapes import MASS_MAX, MASS_MIN, Inertial, Part, inertial_of_parts
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.urdf import Joint, Link

_FACTOR_MAX = 1e6  # of damping, friction and what mimics


def checked_joint(xml: XmlFile, joint: Joint) -> Joint:
    """Return a joint with a unit axis; a revolute one without a stop is continuous.

    Raises:
        RobotError: Its axis is zero, its limits are crossed, or a value is beyond all bounds.
    """
    label = f"joint '{joint.name}'"
    if joint.kind == "fixed":
        return joint
    if not joint.has_position:
        xml.note(f"{label}: moves freely as a {joint.kind} joint; its position is not published")
    limits, kind = joint.limits, joint.kind
    if limits is not None and limits[0] > limits[1]:
        raise xml.fail(label, f"limit lower {limits[0]} is above upper {limits[1]}; swap them")
    # [rad] A revolute joint that may turn 50 times has no stop.
    if kind == "revolute" and limits is not None and limits[1] - limits[0] > 100.0 * math.pi:
        kind, limits = "continuous", None
    for name in ("damping", "friction"):
        number = getattr(joint, name)
        if not 0.0 <= number <= _FACTOR_MAX:
            raise xml.fail(f"{label} {name}", f"is {number:g}; valid: 0 to {_FACTOR_MAX:g}")
    length = math.hypot(*joint.axis)
    if not 0.0 < length < math.inf:
        raise xml.fail(label, "axis must not be zero; valid: as 0 0 1")
    mimic = joint.mimic
    if mimic is not None and max(abs(mimic.multiplier), abs(mimic.offset)) > _FACTOR_MAX:
        raise xml.fail(f"{label} mimic", f"multiplier and offset may reach {_FACTOR_MAX:g}")
    x, y, z = (float(value / length) for value in joint.axis)
    return dataclasses.replace(joint, kind=kind, limits=limits, axis=(x, y, z))


def limit_of(text: str | None) -> float:
    """Return a joint's greatest speed or effort; what is no number above 0 is none.

    Exporters write 0 and -1 for none.
    """
    try:
        limit = float(text or 0.0)
    except ValueError:
        return 0.0
    return limit if 0.0 < limit < math.inf else 0.0


def check_mimics(xml: XmlFile, joints: dict[str, Joint]) -> dict[str, Joint]:
    """Return joints of which none follows one that does not exist; that is noted.

    Raises:
        RobotError: A joint follows one that does not move, or itself.
    """
    joints = {name: _free_if_alone(xml, joint, joints) for name, joint in joints.items()}
    for joint in joints.values():
        label, followed, steps = f"joint '{joint.name}' mimic", joint, 0
        while followed.mimic is not None:
            followed, steps = joints[followed.mimic.joint], steps + 1
            if steps > len(joints):
                raise xml.fail(label, "the joints follow each other in a circle")
        if joint.mimic is not None and not (joint.has_position and followed.has_position):
            raise xml.fail(label, "only joints with one position can follow each other")
    return joints


def _free_if_alone(xml: XmlFile, joint: Joint, joints: Mapping[str, Joint]) -> Joint:
    """Return a joint, free where the one that it follows does not exist."""
    if joint.mimic is None or joint.mimic.joint in joints:
        return joint
    name = joint.mimic.joint
    problem = f"joint '{name}' does not exist; {nearest(name, joints)}; it moves freely"
    xml.note(f"joint '{joint.name}' mimic: {problem}", NoteKind.MISSING)
    return dataclasses.replace(joint, mimic=None)


def inertial_of(
    xml: XmlFile, label: str, mass: float, pose: Pose3, tensor: Floats | None, parts: Sequence[Part]
) -> Inertial | None:
    """Return the mass properties of a link; None where its mass is next to nothing.

    An inertia that no body can have is replaced by that of the link's shapes, with a note.

    Args:
        pose: Of the centre of mass, in the link.
        tensor: Inertia about it, `(3, 3) float64` [kg m^2]; None where the file names none.

    Raises:
        RobotError: The mass is negative or too great.
    """
    if not 0.0 <= mass <= MASS_MAX:
        raise xml.fail(f"{label} mass", f"weighs {mass:g} kg; valid: 0 to {MASS_MAX:g} kg")
    if mass < MASS_MIN:
        xml.note(f"{label}: mass {mass:g}: the link counts as massless")
        return None
    problem = "lacks <inertia>" if tensor is None else _problem(tensor)
    if tensor is not None and not problem:
        rotation = pose.rotation()
        return Inertial(mass, pose.position, rotation @ tensor @ rotation.T)
    computed = inertial_of_parts(parts, mass)
    source = "its shapes" if parts else "a ball of 5 cm"
    xml.note(f"{label}: {problem}, so it is computed from {source} of {mass:g} kg")
    return Inertial(mass, pose.position, computed.inertia)


def _problem(inertia: Floats) -> str:
    """Return why no body has this inertia, "" where one can have it."""
    if np.abs(inertia).max() > 1e12:
        return "the inertia is beyond all bounds"
    principal = np.linalg.eigvalsh(inertia)
    # [kg m^2] MuJoCo treats a smaller inertia as none.
    if principal[0] <= 1e-13:
        return "the inertia is not positive definite"
    if principal[2] > 2.0 * (principal[0] + principal[1]):
        return "the inertia's largest axis is more than the sum of the others"
    return ""


def root_of(xml: XmlFile, links: Mapping[str, Link], joints: Mapping[str, Joint]) -> str:
    """Return the one root of the tree that joints span.

    Raises:
        RobotError: They span none, or one too deep.
    """
    if not links:
        raise RobotError(xml.path, "has no links; valid: one or more")
    parents: dict[str, str] = {}
    for joint in joints.values():
        if joint.child in parents:
            two = f"has two parents, '{parents[joint.child]}' and '{joint.parent}'"
            raise xml.fail(f"joint '{joint.name}'", f"link '{joint.child}' {two}; one is valid")
        parents[joint.child] = joint.parent
    roots = [name for name in links if name not in parents]
    if len(roots) != 1:
        found = ", ".join(roots) or "none, the joints form a loop: one must go"
        problem = f"must have one root link; it has: {found}"
        if roots:
            problem += f"; a fixed joint ties each to '{roots[0]}'"
        raise RobotError(xml.path, problem)
    for start in links:
        link, steps = start, 0
        while link in parents:
            link, steps = parents[link], steps + 1
            if steps > len(links):
                raise xml.fail(f"link '{start}'", "the joints form a loop")
            if steps > DEPTH_MAX:
                problem = f"is below more than {DEPTH_MAX} others, one after the other"
                raise xml.fail(f"link '{start}'", problem)
    return roots[0]
