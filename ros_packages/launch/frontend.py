"""Launch files of XML and YAML: https://design.ros2.org/articles/roslaunch_xml.html."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
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
from launch.substitution import Substitution, TextSubstitution

_LARGEST = 2**20  # [bytes] a bound on the memory that a foreign file can take
Text = list[Substitution]


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
    except (InvalidLaunchFileError, TypeError, ValueError) as error:
        raise InvalidLaunchFileError(f"launch file {path}: {error}") from error


def action_of(entity: Entity) -> Action:
    """Return the action of an element."""
    from launch_ros.frontend import ACTIONS

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


def parse_substitution(text: str) -> Text:
    """Return a text with `$(name words ...)` in it as substitutions."""
    found: Text = []
    at = 0
    while (start := text.find("$(", at)) >= 0:
        end = closing(text, start + 2)
        if start > at:
            found.append(TextSubstitution(text=text[at:start]))
        found.append(_substitution(text[start + 2 : end].strip()))
        at = end + 1
    if at < len(text) or not found:
        found.append(TextSubstitution(text=text[at:]))
    return found


def closing(text: str, at: int) -> int:
    """Return where the bracket is closed in which a position of a text is."""
    depth = 1
    for index in range(at, len(text)):
        depth += {"(": 1, ")": -1}.get(text[index], 0)
        if depth == 0:
            return index
    raise InvalidLaunchFileError(f"'{text}' lacks a ')'")


_WORD = re.compile(r"""\s*(?:'((?:[^'\\]|\\.)*)'|"((?:[^"\\]|\\.)*)"|(\S))""", re.DOTALL)


def _words(text: str) -> list[str]:
    """Return the words of a substitution: quoted ones, and those between blanks."""
    found, at = [], 0
    while (match := _WORD.match(text, at)) is not None:
        end = match.end()
        if match[3] is not None:
            end = match.start(3)
            while end < len(text) and not text[end].isspace():
                end = closing(text, end + 2) + 1 if text.startswith("$(", end) else end + 1
            found.append(text[match.start(3) : end])
        else:
            quoted = match[1] if match[1] is not None else match[2]
            found.append(re.sub(r"\\(.)", r"\1", quoted))
        at = end
    return found


def _substitution(inside: str) -> Substitution:
    name, _, rest = inside.partition(" ")
    if name not in _SUBSTITUTIONS:
        raise InvalidLaunchFileError(f"$({inside}) is unknown; {nearest(name, _SUBSTITUTIONS)}")
    words = [parse_substitution(word) for word in _words(rest)]
    if name in ("eval", "command") and len(words) > 2:  # without quotes
        words = [parse_substitution(rest.strip())]
    try:
        return _SUBSTITUTIONS[name](*words)
    except TypeError as error:
        raise InvalidLaunchFileError(f"$({inside}): {error}") from error


def _ros(name: str, *words: Text) -> Substitution:
    from launch_ros import substitutions as of_ros

    found: Substitution = getattr(of_ros, name)(*words)
    return found


_SUBSTITUTIONS: dict[str, Callable[..., Substitution]] = {
    "and": lambda *words: substitutions.AndSubstitution(*words),
    "anon": lambda name: substitutions.AnonName(name),
    "command": lambda c, e="fail": substitutions.Command(c, on_stderr=e),
    "dirname": lambda: substitutions.ThisLaunchFileDir(),
    "env": lambda name, usual=None: substitutions.EnvironmentVariable(name, default_value=usual),
    "equals": lambda *words: substitutions.EqualsSubstitution(*words),
    "eval": lambda text: substitutions.PythonExpression(text),
    "exec_in_package": lambda *words: _ros("ExecutableInPackage", *words),
    "filename": lambda: substitutions.ThisLaunchFile(),
    "file_content": lambda path: substitutions.FileContent(path),
    "find_exec": lambda name: substitutions.FindExecutable(name=name),
    "find_pkg_prefix": lambda name: _ros("FindPackagePrefix", name),
    "find_pkg_share": lambda name: _ros("FindPackageShare", name),
    "if": lambda *words: substitutions.IfElseSubstitution(*words),
    "log_dir": lambda: substitutions.LaunchLogDir(),
    "not": lambda word: substitutions.NotSubstitution(word),
    "not_equals": lambda *words: substitutions.NotEqualsSubstitution(*words),
    "or": lambda *words: substitutions.OrSubstitution(*words),
    "param": lambda name: _ros("Parameter", name),
    "var": lambda name, usual=None: substitutions.LaunchConfiguration(name, default=usual),
}
_SUBSTITUTIONS |= {name.replace("_", "-"): made for name, made in _SUBSTITUTIONS.items()}


def expose_substitution(name: str) -> Callable[[type[Any]], type[Any]]:
    """Return a decorator that has `$(NAME words)` be what a class's `parse` makes of the words."""

    def exposed(kind: type[Any]) -> type[Any]:
        def made(*words: Text) -> Substitution:
            chosen, given = kind.parse(words)
            return chosen(**given)  # type: ignore[no-any-return]

        _SUBSTITUTIONS[name] = made
        return kind

    return exposed
