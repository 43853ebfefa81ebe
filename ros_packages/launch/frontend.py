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

from arjuna_core.errors import nearest
from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.xml_text import parse_xml
from arjuna_core.files.yaml_file import read_yaml
from launch import actions, substitutions
from launch.action import Action
from launch.conditions import IfCondition, UnlessCondition
from launch.launch_description import LaunchDescription
from launch.launch_description_source import InvalidLaunchFileError
from launch.launch_description_sources import AnyLaunchDescriptionSource
from launch.texts import Text, closing, expose_substitution, parse_substitution

__all__ = ["Entity", "Parser", "closing", "expose_action", "expose_substitution"]
__all__ += ["parse_substitution"]

_EXTENSIONS = ("ros_gz_bridge.actions", "ros_gz_sim.actions")
_LARGEST = 2**20  # [bytes] a bound on the memory that a foreign file can take


@dataclass
class Entity:
    """An element: a tag, texts by name, and what is in it."""

    tag: str
    texts: dict[str, str] = field(default_factory=dict)
    children: list[Entity] = field(default_factory=list)

    def all(self, tag: str) -> Iterator[Entity]:
        """Yield the children of a tag."""
        return (child for child in self.children if child.tag == tag)

    def text(self, name: str, *others: str) -> Text | None:
        """Return a text as substitutions, under the first of some names that it has."""
        found = next((self.texts[one] for one in (name, *others) if one in self.texts), None)
        return None if found is None else parse_substitution(found)

    def needed(self, name: str, *others: str) -> Text:
        """Return a text that must be there."""
        found = self.text(name, *others)
        if found is None:
            has = ", ".join(self.texts) or "nothing"
            raise InvalidLaunchFileError(f"<{self.tag}> lacks '{name}', it has: {has}")
        return found

    def flag(self, name: str, usual: bool) -> bool:
        """Return a text that is true or false."""
        return substitutions.is_true(self.texts.get(name, str(usual)))

    @property
    def type_name(self) -> str:
        """Its tag."""
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


class Parser:
    """The parser that an action's own `parse` gets: texts and actions of its entity."""

    parse_substitution = staticmethod(parse_substitution)

    @staticmethod
    def parse_if_substitutions(value: Any) -> Any:
        """Return a text as substitutions, any other value as it is."""
        return parse_substitution(value) if isinstance(value, str) else value

    @staticmethod
    def parse_action(entity: Entity) -> Action:
        """Return the action of an element."""
        return action_of(entity)


def expose_action(name: str) -> Callable[[type[Any]], type[Any]]:
    """Return a decorator that has `<NAME ...>` be the action that a class's `parse` describes."""

    def exposed(kind: type[Any]) -> type[Any]:
        def made(entity: Entity) -> Action:
            chosen, given = kind.parse(entity, Parser())
            found: Action = chosen(**given)
            return found

        _ACTIONS[name] = made
        return kind

    return exposed


def of_xml(path: Path) -> LaunchDescription:
    """Read an XML launch file."""
    return _description(path, _of_xml(parse_xml(path, read_bytes(path, _LARGEST))))


def _of_xml(element: XmlElement) -> Entity:
    children = [_of_xml(child) for child in element]
    return Entity(element.tag.replace("-", "_"), dict(element.attrib), children)


def of_yaml(path: Path) -> LaunchDescription:
    """Read a YAML launch file."""
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
    except (InvalidLaunchFileError, AttributeError, TypeError, ValueError) as error:
        raise InvalidLaunchFileError(f"launch file {path}: {error}") from error


def action_of(entity: Entity) -> Action:
    """Return the action of an element."""
    from launch_ros.frontend import ACTIONS

    if entity.tag not in {**_ACTIONS, **ACTIONS}:
        for extension in entry_points(group="launch.frontend.launch_extension"):
            extension.load()
        for module in _EXTENSIONS:
            import_module(module)
    known = {**_ACTIONS, **ACTIONS}
    if entity.tag not in known:
        raise InvalidLaunchFileError(f"<{entity.tag}> is unknown; {nearest(entity.tag, known)}")
    made = known[entity.tag](entity)
    for name, kind in (("if", IfCondition), ("unless", UnlessCondition)):
        if name in entity.texts:
            made.condition = kind(entity.needed(name))
    return made


def _inside(entity: Entity, *without: str) -> list[Action]:
    return [action_of(child) for child in entity.children if child.tag not in without]


def _argument(entity: Entity) -> Action:
    if "value" in entity.texts:  # as ROS 1 has it
        return _let(entity)
    choices = [child.texts["value"] for child in entity.all("choice")]
    return actions.DeclareLaunchArgument(
        entity.texts["name"],
        default_value=entity.text("default"),
        description=entity.texts.get("description", ""),
        choices=choices or None,
    )


def _let(entity: Entity) -> Action:
    return actions.SetLaunchConfiguration(entity.needed("name"), entity.needed("value"))


def _include(entity: Entity) -> Action:
    pairs = [
        (one.needed("name"), one.needed("value", "default"))
        for one in (*entity.all("arg"), *entity.all("let"))
    ]
    source = AnyLaunchDescriptionSource(entity.needed("file"))
    return actions.IncludeLaunchDescription(source, launch_arguments=pairs)


def _group(entity: Entity) -> Action:
    kept = {str(i): one for i, one in enumerate(entity.all("keep"))}
    return actions.GroupAction(
        _inside(entity, "keep"),
        scoped=entity.flag("scoped", True),
        forwarding=entity.flag("forwarding", True),
        launch_configurations={one.texts["name"]: one.needed("value") for one in kept.values()},
    )


def of_process(entity: Entity) -> dict[str, Any]:
    """Return what a process and a node have in common."""
    usual = {
        name: entity.text(given)
        for name, given in (
            *(("output", "output"), ("cwd", "cwd"), ("respawn", "respawn")),
            *(("sigterm_timeout", "sigterm_timeout"), ("sigkill_timeout", "sigkill_timeout")),
            ("prefix", "launch-prefix" if "launch-prefix" in entity.texts else "launch_prefix"),
        )
    }
    found: dict[str, Any] = {name: text for name, text in usual.items() if text is not None}
    if "respawn_delay" in entity.texts:
        found["respawn_delay"] = float(entity.texts["respawn_delay"])
    if entity.texts.get("on_exit") == "shutdown":
        found["on_exit"] = actions.Shutdown()
    variables = {"".join(e.texts["name"]): e.needed("value") for e in entity.all("env")}
    return {**found, **({"additional_env": variables} if variables else {})}


def _executable(entity: Entity) -> Action:
    given = of_process(entity)
    if (name := entity.text("name")) is not None:
        given["name"] = name
    words = [entity.needed("cmd"), *([entity.needed("args")] if "args" in entity.texts else [])]
    command: Any = [words[0]] if len(words) == 1 else [[*words[0], " ", *words[1]]]
    return actions.ExecuteProcess(cmd=command, shell=True, **given)  # noqa: S604 - its own words


def _environment(kind: type[Any]) -> Callable[[Entity], Action]:
    def of(entity: Entity) -> Action:
        rest = {"prepend": True} if entity.texts.get("prepend") == "true" else {}
        return kind(entity.needed("name"), entity.needed("value"), **rest)  # type: ignore[no-any-return]

    return of


_ACTIONS: dict[str, Callable[[Entity], Action]] = {
    "append_env": _environment(actions.AppendEnvironmentVariable),
    "arg": _argument,
    "executable": _executable,
    "group": _group,
    "include": _include,
    "let": _let,
    "log": lambda e: actions.LogInfo(msg=e.needed("message")),
    "set_env": _environment(actions.SetEnvironmentVariable),
    "shutdown": lambda e: actions.Shutdown(reason=e.texts.get("reason", "reason not given")),
    "timer": lambda e: actions.TimerAction(period=e.needed("period"), actions=_inside(e)),
    "unset_env": lambda e: actions.UnsetEnvironmentVariable(e.needed("name")),
}
