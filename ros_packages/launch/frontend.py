"""Launch files of XML and YAML: https://design.ros2.org/articles/roslaunch_xml.html."""

from __future__ import annotations

import typing
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element as XmlElement  # a type alone

import yaml

from arjuna_core.errors import nearest
from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.xml_text import parse_xml
from arjuna_core.files.yaml_file import read_yaml
from launch import substitutions
from launch.action import Action
from launch.conditions import IfCondition, UnlessCondition
from launch.launch_description import LaunchDescription
from launch.texts import (
    InvalidLaunchFileError,
    Text,
    closing,
    expose_substitution,
    parse_substitution,
)

__all__ = ["Entity", "Parser", "closing", "expose_action", "expose_substitution"]
__all__ += ["parse_substitution"]

_EXTENSIONS = ("launch_ros.frontend", "ros_gz_bridge.actions", "ros_gz_sim.actions")


@dataclass
class Entity:
    """An element: a tag, texts by name, and what is in it."""

    tag: str
    texts: dict[str, str] = field(default_factory=dict)
    children: list[Entity] = field(default_factory=list)

    def all(self, tag: str) -> Iterator[Entity]:
        return (child for child in self.children if child.tag == tag)

    def text(self, name: str, *others: str) -> Text | None:
        """Return a text as substitutions, under the first of some names that it has."""
        is_there = any(one in self.texts for one in (name, *others))
        return self.needed(name, *others) if is_there else None

    def needed(self, name: str, *others: str) -> Text:
        """Return a text that must be there."""
        return parse_substitution(self.plain(name, *others))

    def plain(self, name: str, *others: str) -> str:
        """Return a text that must be there, as it stands."""
        found = next((self.texts[one] for one in (name, *others) if one in self.texts), None)
        if found is None:
            has = ", ".join(self.texts) or "nothing"
            raise InvalidLaunchFileError(f"<{self.tag}> lacks '{name}', it has: {has}")
        return found

    def flag(self, name: str, usual: bool) -> bool:
        """Return a text that is true or false."""
        return substitutions.is_true(self.texts.get(name, str(usual)))

    @property
    def type_name(self) -> str:
        return self.tag

    def get_attr(
        self, name: str, *, data_type: Any = str, optional: bool = False, can_be_str: bool = True
    ) -> Any:
        """Return an attribute for an action of one's own, or what is in it below a tag.

        Raises:
            AttributeError: It is not there, and not optional.
        """
        if typing.get_origin(data_type) is list and Entity in typing.get_args(data_type):
            return list(self.all(name)) or None
        if name not in self.texts:
            if optional:
                return None
            raise AttributeError(f"<{self.tag}> lacks '{name}', it has: {', '.join(self.texts)}")
        text = self.texts[name]
        if "$(" in text and can_be_str:
            return text
        kinds: dict[Any, Callable[[str], Any]] = {bool: substitutions.is_true}
        return kinds.get(data_type, data_type if data_type in (int, float) else str)(text)


TAGS: dict[str, Callable[[Entity], Action]] = {}
"""What makes the action of an element, by its tag; whoever has actions adds to it."""


class Parser:
    """The parser that an action's own `parse` gets: texts and actions of its entity."""

    parse_substitution = staticmethod(parse_substitution)

    @staticmethod
    def parse_if_substitutions(value: Any) -> Any:
        """Return a text as substitutions, any other value as it is."""
        return parse_substitution(value) if isinstance(value, str) else value

    @staticmethod
    def parse_action(entity: Entity) -> Action:
        return action_of(entity)


def expose_action(name: str) -> Callable[[type[Any]], type[Any]]:
    """Return a decorator that has `<NAME ...>` be the action that a class's `parse` describes."""

    def exposed(kind: type[Any]) -> type[Any]:
        def made(entity: Entity) -> Action:
            chosen, given = kind.parse(entity, Parser())
            found: Action = chosen(**given)
            return found

        TAGS[name] = made
        return kind

    return exposed


def of_xml(path: Path) -> LaunchDescription:
    return _description(path, _of_xml(parse_xml(path, read_bytes(path))))


def _of_xml(element: XmlElement) -> Entity:
    children = [_of_xml(child) for child in element]
    return Entity(element.tag.replace("-", "_"), dict(element.attrib), children)


def of_yaml(path: Path) -> LaunchDescription:
    document = read_yaml(path)
    if not isinstance(document, Mapping) or list(document) != ["launch"]:
        raise InvalidLaunchFileError(f"launch file {path}: valid: 'launch:' and a list of actions")
    return _description(path, _of_yaml("launch", document["launch"]))


def _of_yaml(tag: str, value: Any) -> Entity:
    found = Entity(str(tag).replace("-", "_"))
    for item in value if isinstance(value, list) else [value]:
        if not isinstance(item, Mapping):
            raise InvalidLaunchFileError(f"'{tag}' holds {item!r}; valid: names and values")
        for key, below in item.items():
            if isinstance(below, str | int | float):
                found.texts[key] = str(below).lower() if isinstance(below, bool) else str(below)
            elif isinstance(below, list) and not any(isinstance(each, Mapping) for each in below):
                found.texts[key] = yaml.safe_dump(below, default_flow_style=True, width=2**20)
            elif key == "children":
                found.children += _of_yaml(tag, below).children
            elif isinstance(below, list) and tag != "launch" and key not in _CONTAINERS:
                found.children += [_of_yaml(key, each) for each in below]
            else:
                found.children.append(_of_yaml(key, below))
    return found


_CONTAINERS = ("group", "timer")


def _description(path: Path, root: Entity) -> LaunchDescription:
    if root.tag != "launch":
        raise InvalidLaunchFileError(f"launch file {path} is of <{root.tag}>; valid: <launch>")
    try:
        return LaunchDescription([action_of(child) for child in root.children])
    except (RuntimeError, AttributeError, TypeError, ValueError) as error:  # too deep, too
        raise InvalidLaunchFileError(f"launch file {path}: {error}") from error


def action_of(entity: Entity) -> Action:
    if entity.tag not in TAGS:
        for extension in entry_points(group="launch.frontend.launch_extension"):
            extension.load()
        for module in _EXTENSIONS:
            import_module(module)
    if entity.tag not in TAGS:
        raise InvalidLaunchFileError(f"<{entity.tag}> is unknown; {nearest(entity.tag, TAGS)}")
    made = TAGS[entity.tag](entity)
    for name, kind in (("if", IfCondition), ("unless", UnlessCondition)):
        if name in entity.texts:
            made.condition = kind(entity.needed(name))
    return made
