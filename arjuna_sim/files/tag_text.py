"""Texts of Gazebo's tags, however its versions and ROS 1 and 2 spell them."""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_sim.files.xml_file import XmlFile


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


def value(xml: XmlFile, element: Element, place: str, default: float, *names: str) -> float:
    """Return the first number from 0 under one of these plain names; 0 means the default."""
    text = text_of(element, *names)
    if not text:
        return default
    number = xml.numbers(text, 1, f"{place} <{names[0]}>")[0]
    if number < 0.0:
        raise xml.fail(f"{place} <{names[0]}>", f"{text!r} must not be negative")
    return number or default


def flag(element: Element, default: bool, *names: str) -> bool:
    """Return the truth value under one of these plain names."""
    text = text_of(element, *names).lower()
    return text in ("true", "1") if text else default


def topic(element: Element, default: str, remapped: str, *names: str) -> str:
    """Return a topic: a remapping of the ROS 2 spelling wins over the tag.

    Args:
        element: The plugin or sensor.
        default: Where nothing names one.
        remapped: What ROS 2 remaps, such as `~/out` or `cmd_vel`.
        names: Plain names of tags that hold the topic.
    """
    found = text_of(element, *names) or default
    for text in (*texts(element, "remapping"), *texts(element, "argument")):
        source, _, target = text.partition(":=")
        if source.strip() in (remapped, default) and target.strip():
            found = target.strip()
    found = found if found != "__default_topic__" else default
    space = text_of(element, "robotnamespace", "namespace").strip("/")
    return f"/{space}/{found}" if space and not found.startswith("/") else found
