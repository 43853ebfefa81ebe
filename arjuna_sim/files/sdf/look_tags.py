"""Reading SDF's lights and its `<scene>`: ambient light, sky and fog."""

from __future__ import annotations

import math
from dataclasses import replace
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

import numpy as np

from arjuna_core.pose3 import Pose3
from arjuna_sim.files.sdf.includes import SUN_TYPE, leaving_out
from arjuna_sim.files.tag_text import is_true
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.look import AMBIENT, SUN, Fog, Light, LightKind, Look, Rgb

LIGHTS_MAX = 7
"""OpenGL draws eight lights at once, of which one is the ambient one."""
_DIMMED = math.log(20.0)
_FOGS = {"linear": 0.0, "constant": _DIMMED, "quadratic": math.sqrt(_DIMMED)}
"""By type, where a fog hides all but 5 %: a distance times its density; 0 for its `<end>`."""


def read_light(xml: XmlFile, element: Element, T_world: Pose3) -> list[Light]:
    """Return the light of a tag that stands at a pose in the world; none where it is off.

    Raises:
        WorldError: A value is invalid.
    """
    label, kind = f"light '{element.get('name', '?')}'", element.get("type", "point")
    kinds = [each.value for each in LightKind]
    if kind == SUN_TYPE or not is_true(element.findtext("light_on") or "true"):
        return [SUN] if kind == SUN_TYPE else []
    if kind not in kinds:
        raise xml.fail(label, f"type '{kind}' is unknown; valid: {', '.join(kinds)}")
    numbers = xml.numbers(element.findtext("direction") or "0 0 -1", 3, f"{label} <direction>")
    length = math.hypot(*numbers)
    if not length > 0.0:
        raise xml.fail(f"{label} <direction>", "must not be zero")
    x, y, z = (T_world.rotation() @ np.array(numbers) / length).tolist()
    bright = xml.number(element, "intensity", 1.0, label)
    diffuse, specular = (
        _rgb(xml, element, path, default, label, bright)
        for path, default in (("diffuse", (1.0,) * 3), ("specular", (0.1,) * 3))
    )
    fades = kind != LightKind.DIRECTIONAL.value
    edge = xml.number(element, "spot/outer_angle", 1.0, label) / 2.0
    return [
        Light(
            *(LightKind(kind), T_world.position, (x, y, z), diffuse, specular),
            _attenuation(xml, element, label) if fades else (1.0, 0.0, 0.0),
            min(max(edge, 0.01), math.pi / 2.0),
            max(0.0, xml.number(element, "spot/falloff", 1.0, label)),
            is_true(element.findtext("cast_shadows")),
        )
    ]


def _attenuation(xml: XmlFile, element: Element, label: str) -> tuple[float, float, float]:
    paths = (("constant", 1.0), ("linear", 1.0), ("quadratic", 0.0))
    a, b, c = (max(0.0, xml.number(element, f"attenuation/{k}", v, label)) for k, v in paths)
    return (a, b, c) if a + b + c > 0.0 else (1.0, 0.0, 0.0)


def _rgb(
    xml: XmlFile, element: Element, path: str, default: Rgb, label: str, bright: float = 1.0
) -> Rgb:
    """Return a colour times a brightness; its fourth number, opacity, has no effect."""
    words = (element.findtext(path) or "").split()
    given = xml.numbers(" ".join(words[:3]), 3, f"{label} <{path}>") if words else default
    r, g, b = (max(0.0, value * bright) for value in given)
    return r, g, b


def read_look(xml: XmlFile, world: Element, lights: list[Light]) -> Look:
    """Return the look of a world with the lights that were read; what is broken is left out."""
    if len(lights) > LIGHTS_MAX:
        xml.note(f"has {len(lights)} lights: cameras see by the first {LIGHTS_MAX}")
    scene, own = world.find("scene"), any(light is not SUN for light in lights)
    look = Look(tuple(lights[:LIGHTS_MAX]) or (SUN,), AMBIENT if own else None)
    if scene is None:
        return look
    with leaving_out(xml, "<scene>"):
        ambient = look.ambient
        if own or scene.find("ambient") is not None:
            ambient = _rgb(xml, scene, "ambient", AMBIENT, "<scene>")
        sky = scene.find("sky") is not None or scene.find("background") is None
        background = None if sky else _rgb(xml, scene, "background", AMBIENT, "<scene>")
        shadows = is_true(scene.findtext("shadows") or "true")
        lit = tuple(
            replace(each, casts_shadow=each.casts_shadow and shadows) for each in look.lights
        )
        return Look(lit, ambient, background, _fog(xml, scene.find("fog")))
    return look


def _fog(xml: XmlFile, element: Element | None) -> Fog | None:
    """Return a fog, None for none; one that thickens otherwise than evenly becomes an even one."""
    label = "<fog>"
    kind = "" if element is None else (element.findtext("type") or "none").strip()
    if element is None or kind not in _FOGS:
        return None
    start, end = (xml.number(element, key, v, label) for key, v in (("start", 1.0), ("end", 100.0)))
    if _FOGS[kind]:
        density = xml.number(element, "density", 1.0, label)
        start, end = 0.0, _FOGS[kind] / density if density > 0.0 else math.inf
    if not 0.0 <= start < end:
        raise xml.fail(label, f"from {start:g} to {end:g} m; valid: 0 <= start < end")
    colour = _rgb(xml, element, "color", (1.0,) * 3, label)
    return None if end == math.inf else Fog(colour, start, end)
