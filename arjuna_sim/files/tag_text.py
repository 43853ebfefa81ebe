"""Texts of Gazebo's tags, in the spellings of its versions and of ROS 1 and 2, and its colours."""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.settings import spelled

_COLOURS = {
    "red": (0.8, 0.1, 0.1, 1.0),
    "green": (0.1, 0.7, 0.1, 1.0),
    "blue": (0.1, 0.1, 0.8, 1.0),
    "yellow": (0.9, 0.8, 0.1, 1.0),
    "orange": (1.0, 0.5, 0.1, 1.0),
    "purple": (0.6, 0.1, 0.7, 1.0),
    "turquoise": (0.1, 0.8, 0.8, 1.0),
    "indigo": (0.3, 0.1, 0.6, 1.0),
    "gold": (0.8, 0.65, 0.1, 1.0),
    "silver": (0.75, 0.75, 0.75, 1.0),
    "white": (1.0, 1.0, 1.0, 1.0),
    "black": (0.05, 0.05, 0.05, 1.0),
    "grey": (0.7, 0.7, 0.7, 1.0),
    "gray": (0.7, 0.7, 0.7, 1.0),
    "road": (0.2, 0.2, 0.2, 1.0),
    "wood": (0.65, 0.45, 0.25, 1.0),
}
PATH, OWN = "path-of-nested-model", "names-of-nested-model"
"""Attributes of a plugin of a nested model: the path before its names, and those names in lines."""
_VARIANTS = ("dark", "light", "flat", "bright")
_SUFFIXES = ("transparent", "glow")


def plain(tag: str) -> str:
    """Drop what the versions spell differently: `wheel_separation` is `wheelSeparation`."""
    return tag.rpartition("}")[2].replace("_", "").lower()


def texts(element: Element, *names: str) -> Iterator[str]:
    """Yield the texts of all descendants that have one of these plain names."""
    for child in element.iter():
        if plain(child.tag) in names and child.text and child.text.strip():
            yield child.text.strip()


def text_of(element: Element, *names: str, default: str = "") -> str:
    """Return the first text under the first of these plain names that is there."""
    return next((text for name in names for text in texts(element, name)), default)


def value(xml: XmlFile, element: Element, label: str, default: float, *names: str) -> float:
    """Return the first number from 0 under one of these plain names; 0 means the default."""
    text = text_of(element, *names)
    if not text:
        return default
    number = xml.numbers(text, 1, f"{label} <{names[0]}>")[0]
    if number < 0.0:
        raise xml.fail(f"{label} <{names[0]}>", f"{text!r} must not be negative")
    return number or default


def is_true(text: str | None) -> bool:
    """Return whether a text says yes, as SDF and URDF write it."""
    return (text or "").strip().lower() in ("true", "1")


def flag(element: Element, default: bool, *names: str) -> bool:
    """Return the truth value under one of these plain names."""
    text = text_of(element, *names)
    return is_true(text) if text else default


def remappings(element: Element) -> Iterator[tuple[str, str]]:
    """Yield what a plugin below an element remaps, and to what."""
    for text in (*texts(element, "remapping"), *texts(element, "argument")):
        source, _, target = text.partition(":=")
        if target.strip():
            yield source.strip(), target.strip()


def topic(element: Element, default: str, remapped: str, *names: str) -> str:
    """Return a topic as ROS spells it: a remapping of the ROS 2 spelling wins over the tag.

    Args:
        remapped: What ROS 2 remaps, such as `~/out` or `cmd_vel`.
        names: Plain names of tags that hold the topic.
    """
    found = text_of(element, *names) or default
    for source, target in remappings(element):
        if source in (remapped, default):
            found = target
    found = found if found != "__default_topic__" else default
    space = text_of(element, "robotnamespace", "namespace").strip("/")
    return spelled(f"/{space}/{found}" if space and not found.startswith("/") else found)


def gazebo_colour(name: str) -> tuple[float, ...] | None:
    """Return the colour of a material such as `Gazebo/DarkGrey`, or None."""
    plain = name.strip().rpartition("/")[2].lower().replace("_", "")
    for variant in _VARIANTS:
        plain = plain.removeprefix(variant) or plain
    for suffix in _SUFFIXES:
        plain = plain.removesuffix(suffix)
    return _COLOURS.get(plain)
