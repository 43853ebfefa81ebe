"""Reading a link's `<inertial>`."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

import numpy as np
from numpy.typing import NDArray

from arjuna_sim.files.urdf.joint_tags import read_origin
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.inertia import MASS_MIN, Inertial, inertial_of_parts
from arjuna_sim.model.geometry.shapes import Part

_MASS_MAX = 1e7  # [kg]
_LEAST = 1e-13  # below this MuJoCo takes an inertia for none [kg m^2]


def read_inertial(
    xml: XmlFile, link: Element, place: str, parts: tuple[Part, ...]
) -> Inertial | None:
    """Read a link's `<inertial>`; None where it has none, or one without mass.

    An inertia that no body can have is replaced by that of the link's shapes, with a note.

    Raises:
        RobotError: The mass is missing, not finite, negative or too great.
    """
    element = link.find("inertial")
    if element is None:
        return None
    place = f"{place} inertial"
    mass_text = xml.attribute(xml.child(element, "mass", place), "value", place)
    mass = xml.numbers(mass_text, 1, f"{place} mass")[0]
    if not 0.0 <= mass <= _MASS_MAX:
        raise xml.fail(f"{place} mass", f"weighs {mass:g} kg; valid: 0 to {_MASS_MAX:g} kg")
    if mass < MASS_MIN:
        xml.note(f"{place}: mass {mass:g}: the link counts as massless")
        return None
    origin = read_origin(xml, element, place)
    tensor = element.find("inertia")
    problem, given = "lacks <inertia>", np.zeros((3, 3))
    if tensor is not None:
        given = _tensor(xml, tensor, place)
        problem = _problem(given)
    if not problem:
        rotation = origin.rotation()
        return Inertial(mass, origin.position, rotation @ given @ rotation.T)
    computed = inertial_of_parts(parts, mass)
    xml.note(f"{place}: {problem}, so it is computed from {_source(parts)} of {mass:g} kg")
    return Inertial(mass, origin.position, computed.inertia)


def _tensor(xml: XmlFile, tensor: Element, place: str) -> NDArray[np.float64]:
    xx, yy, zz = (
        xml.numbers(xml.attribute(tensor, key, place), 1, f"{place} {key}")[0]
        for key in ("ixx", "iyy", "izz")
    )
    xy, xz, yz = (xml.attribute_number(tensor, key, "0", place) for key in ("ixy", "ixz", "iyz"))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _problem(inertia: NDArray[np.float64]) -> str:
    """Say why no body has this inertia, "" where one can have it."""
    if np.abs(inertia).max() > 1e12:
        return "the inertia is beyond all bounds"
    principal = np.linalg.eigvalsh(inertia)
    if principal[0] <= _LEAST:
        return "the inertia is not positive definite"
    if principal[2] > 2.0 * (principal[0] + principal[1]):
        return "the inertia's largest axis is more than the sum of the others"
    return ""


def _source(parts: Sequence[Part]) -> str:
    return "its shapes" if parts else "a ball of 5 cm"
