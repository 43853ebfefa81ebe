"""Reading SDF's joints on which a part of the world swings."""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

import numpy as np

from arjuna_sim.files.sdf.model_tags import SdfJoint, SdfLink
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.joints import Hinge

SWINGING = ("revolute", "continuous", "prismatic")
_UNLIMITED = 1e6  # beyond it a limit is none [rad or m]


def read_hinge(joint: SdfJoint, link: SdfLink, own: set[str]) -> Hinge:
    """Read the joint between what swings and what stands fast.

    Args:
        joint: The joint.
        link: The link whose frame is that of what swings.
        own: Names of the links that swing.

    Raises:
        WorldError: Its axis or a limit is invalid.
    """
    xml, place = joint.file, f"joint '{joint.element.get('name', '?')}'"
    axis = xml.child(joint.element, "axis", place)
    toward = np.array(xml.numbers(axis.findtext("xyz") or "0 0 1", 3, f"{place} <xyz>"))
    length = math.hypot(*toward)
    if not 0.0 < length < math.inf:
        raise xml.fail(place, "axis must not be zero")
    T_link = link.T_world.inverse()
    along = T_link.rotation() @ joint.T_axis.rotation() @ toward / length
    x, y, z = T_link.apply(np.array([joint.T_world.position]))[0]
    sign = 1.0 if joint.child in own else -1.0  # else the parent swings
    a, b, c = (sign * along).tolist()
    return Hinge(
        joint.kind == "prismatic",
        (a, b, c),
        (float(x), float(y), float(z)),
        None if joint.kind == "continuous" else _limits(xml, axis, place),
        max(0.0, xml.number(axis, "dynamics/damping", 0.0, place)),
        max(0.0, xml.number(axis, "dynamics/friction", 0.0, place)),
    )


def _limits(xml: XmlFile, axis: Element, place: str) -> tuple[float, float] | None:
    low = max(xml.number(axis, "limit/lower", -_UNLIMITED, place), -_UNLIMITED)
    high = min(xml.number(axis, "limit/upper", _UNLIMITED, place), _UNLIMITED)
    return (low, high) if low > -_UNLIMITED or high < _UNLIMITED else None
