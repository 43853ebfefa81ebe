"""Reading where on Earth an SDF world is."""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.geodesy import GeoPoint
from arjuna_sim.files.sdf.includes import leaving_out
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.world import Earth

_ANGLES = {"latitude_deg": 90.0, "longitude_deg": 360.0, "heading_deg": 360.0}


def read_earth(xml: XmlFile, world: Element) -> Earth:
    """Read `<spherical_coordinates>` and `<magnetic_field>`; what is broken is left out."""
    nowhere = Earth()
    origin, heading, field = nowhere.origin, nowhere.heading, nowhere.magnetic_field
    with leaving_out(xml, "<spherical_coordinates>"):
        tag, place = world.find("spherical_coordinates"), "<spherical_coordinates>"
        latitude, longitude, turn = (_angle(xml, tag, key, place) for key in _ANGLES)
        altitude = xml.number(tag, "elevation", 0.0, place)
        origin = GeoPoint(latitude, math.remainder(longitude, 360.0), altitude)
        heading = math.radians(turn)
    with leaving_out(xml, "<magnetic_field>"):
        text = world.findtext("magnetic_field")
        if text is not None and text.strip():
            x, y, z = xml.numbers(text, 3, "<magnetic_field>")
            field = (x, y, z)
    return Earth(origin, heading, field)


def _angle(xml: XmlFile, tag: Element | None, key: str, place: str) -> float:
    value = xml.number(tag, key, 0.0, place)
    if abs(value) > _ANGLES[key]:
        raise xml.fail(place, f"<{key}> is {value:g}; valid: up to {_ANGLES[key]:g}")
    return value
