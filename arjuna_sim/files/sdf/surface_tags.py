"""Reading how surfaces of an SDF file rub, and how strongly its world pulls down."""

from __future__ import annotations

from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_sim.files.sdf.includes import leaving_out
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.world import World

_FRICTION = "surface/friction"
_ODE = f"{_FRICTION}/ode"
_PULL_MAX = 100.0  # [m/s^2]


def read_friction(xml: XmlFile, element: Element, place: str) -> float | None:
    """Return the friction of a `<collision>`; None where it names none.

    Rubber is the same all around here: what the file says of a second direction, of slip or of
    twisting becomes a note.
    """
    mu = element.findtext(f"{_ODE}/mu") or element.findtext(f"{_FRICTION}/bullet/friction")
    if mu is None:
        return None
    with leaving_out(xml, f"{place} <friction>"):
        value = max(0.0, xml.numbers(mu, 1, f"{place} <mu>")[0])
        second = xml.number(element, f"{_ODE}/mu2", value, place)
        if second != value:
            xml.note(f"{place}: <mu2> is taken to be <mu>, {value:g}")
        for tag in ("slip1", "slip2"):
            if xml.number(element, f"{_ODE}/{tag}", 0.0, place) != 0.0:
                xml.note(f"{place}: <{tag}>: not simulated", NoteKind.IGNORED)
        return value
    return None


def read_gravity(xml: XmlFile, world: Element) -> tuple[float, float, float]:
    """Return which way a `<world>` pulls and how strongly [m/s^2]."""
    text = world.findtext("gravity") or world.findtext("physics/gravity")
    if not text or not text.strip():
        return World.gravity
    with leaving_out(xml, "world <gravity>"):
        x, y, z = xml.numbers(text, 3, "world <gravity>")
        if max(abs(x), abs(y), abs(z)) > _PULL_MAX:
            raise xml.fail("world <gravity>", f"is {text.strip()}; valid: up to {_PULL_MAX:g}")
        return x, y, z
    return World.gravity
