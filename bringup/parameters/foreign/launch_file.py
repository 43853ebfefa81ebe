"""ROS 1's launch files: the parameters that their nodes get, as one document of sections.

The XML of roslaunch, http://wiki.ros.org/roslaunch/XML: `node`, `param`, `rosparam`, `remap`,
`arg`, `group` and `include`, with `$(arg)`, `$(find)`, `$(dirname)`, `$(env)` and `$(optenv)`.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element  # a type alone

import yaml

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.xml_text import parse_xml
from arjuna_core.files.yaml_file import plain, read_yaml
from bringup.parameters.foreign.ros1_names import SECTIONS

_SUBSTITUTION = re.compile(r"\$\((\w+)\s*([^()]*)\)")
# Among a node's arguments: a new name, a parameter (_), or what roslaunch itself means (__).
_GIVEN = re.compile(r"^/?(?P<private>_*)(?P<name>\w+):=(?P<value>\S+)$")
_OF_PACKAGE = re.compile(r"\$\(find (\w+)\)/.*?([^/]+\.launch)")
_FILES_MAX = 100
_NO = ("false", "0")


class Program(NamedTuple):
    """A node, or a launch file of a package that is not there.

    Attributes:
        name: Its executable, or the file's name.
        given: Its arguments: words of a node, NAME:=VALUE of a file.
        node: Its own name.
    """

    package: str
    name: str
    given: tuple[str, ...]
    node: str = ""


class LaunchFile:
    """The settings of a launch file and of those that it includes.

    Attributes:
        programs: What it starts, in order.
        description: Path of the robot's description, "" where it names none.
        document: Parameters by section: `{"amcl": {...}, "move_base": {"DWAPlannerROS": {...}}}`.
        topics: New names of topics by section: `{"amcl": {"scan": "robot/laser/scan"}}`.
        notes: What could not be followed, a line each.

    Raises:
        InputFileError: The file, or one that it includes or loads, cannot be used.
    """

    def __init__(self, path: Path) -> None:
        self.document: dict[str, Any] = {}
        self.topics: dict[str, dict[str, str]] = {}
        self.notes: list[str] = []
        self.programs: list[Program] = []
        self.description = ""
        self.files = 0
        _Reading(self, path, {}, ()).run()


class _Unknown(Exception):
    """A substitution whose value is not known; its text says which."""


class _Reading:
    def __init__(
        self, into: LaunchFile, path: Path, arguments: Mapping[str, str], above: tuple[Path, ...]
    ) -> None:
        self._into, self._path, self._above = into, path, above
        self._given, self._arguments = arguments, dict(arguments)

    def run(self, deepest: int = 10) -> None:
        """Read it; nesting of `deepest` files is refused: they include each other."""
        if len(self._above) >= deepest:
            raise InputFileError(self._path, f"is included {deepest} files deep")
        self._into.files += 1
        if self._into.files > _FILES_MAX:
            raise InputFileError(self._path, f"is one of more than {_FILES_MAX} that are included")
        root = parse_xml(self._path, read_bytes(self._path))
        if root.tag != "launch":
            raise InputFileError(self._path, f"is XML of <{root.tag}>; valid: <launch>, or YAML")
        self._take_all(root, ())

    def _take_all(self, parent: Element, inside: tuple[str, ...]) -> None:
        for child in parent:
            try:
                if self._chosen(child):
                    self._take(child, inside)
            except _Unknown as unknown:
                self._into.notes.append(f"{self._path.name}: <{child.tag}>: {unknown}")

    def _take(self, element: Element, inside: tuple[str, ...]) -> None:
        if element.tag == "arg":
            self._take_argument(element)
        elif element.tag == "group":
            self._take_all(element, (*inside, *self._section(element, "ns")))
        elif element.tag == "node":
            self._take_node(element)
        elif element.tag == "param" and "value" in element.attrib:
            name = (*inside, *self._words(element, "name"))
            self._put(name, _typed(self._value(element, "value"), element.get("type", "auto")))
        elif element.tag == "param" and element.get("name") == "robot_description":
            words = self._value(element, "textfile" if "textfile" in element.attrib else "command")
            paths = [word for word in words.split() if ":=" not in word]
            self._into.description = paths[-1] if paths else ""
        elif element.tag == "rosparam":
            self._take_file(element, (*inside, *self._words(element, "ns")))
        elif element.tag == "remap":
            self._take_new_name(element, inside)
        elif element.tag == "include":
            self._include(element)

    def _take_argument(self, element: Element) -> None:
        name = element.get("name", "")
        for key in ("value", "default"):
            if key in element.attrib and name not in self._given:
                self._arguments[name] = self._value(element, key)

    def _take_node(self, element: Element) -> None:
        section, given = element.get("type", ""), element.get("args", "")
        with suppress(_Unknown):
            given = self._replaced(given)
        program = Program(
            element.get("pkg", ""), section, tuple(given.split()), element.get("name", "")
        )
        self._into.programs.append(program)
        if section not in SECTIONS:
            return
        for word in self._value(element, "args").split():
            match = _GIVEN.match(word)
            if match and match["private"] == "_":
                self._put((section, match["name"]), _typed(match["value"], "auto"))
            elif match and not match["private"]:
                self._into.topics.setdefault(section, {})[match["name"]] = match["value"]
        self._take_all(element, (section,))

    def _take_new_name(self, element: Element, inside: tuple[str, ...]) -> None:
        old, new = self._value(element, "from"), self._value(element, "to")
        if inside:
            self._into.topics.setdefault(inside[0], {})[old] = new
        else:
            self._into.notes.append(f"{self._path.name}: <remap> of {old} to {new}, of no one node")

    def _take_file(self, element: Element, inside: tuple[str, ...]) -> None:
        if element.get("command", "load") != "load":
            return
        if "file" in element.attrib:
            path = self._named_file(element)
            content = read_yaml(path)
        else:
            path, text = self._path, element.text or ""
            subst = element.get("subst_value") in ("true", "True", "1")
            content = _yaml(self._path, self._replaced(text) if subst else text)
        inside = (*inside, *self._words(element, "param"))
        if content is None:
            return
        if not isinstance(content, Mapping) and "param" not in element.attrib:
            raise InputFileError(path, f"expected names and values, got {str(content)[:80]!r}")
        self._put(inside, content)

    def _include(self, element: Element) -> None:
        path, given = self._named_file(element), self._arguments_of(element)
        passed = {**self._arguments, **given} if element.get("pass_all_args") == "true" else given
        _Reading(self._into, path, passed, (*self._above, self._path)).run()

    def _arguments_of(self, element: Element) -> dict[str, str]:
        return {
            child.get("name", ""): self._value(
                child, "value" if "value" in child.attrib else "default"
            )
            for child in element
            if child.tag == "arg"
        }

    def _named_file(self, element: Element) -> Path:
        path = self._path.parent / self._value(element, "file")
        if not os.path.isfile(path):  # noqa: PTH113 - Path.is_file raises where a name is too long
            if (found := _OF_PACKAGE.fullmatch(element.get("file", ""))) is not None:
                words = (f"{k}:={v}" for k, v in self._arguments_of(element).items())
                self._into.programs.append(Program(found[1], found[2], tuple(words)))
            raise _Unknown(f"there is no file {path}")
        return path

    def _put(self, inside: tuple[str, ...], value: Any) -> None:
        """Put a value, or a mapping of them, where it belongs; later ones win."""
        deepest = 20
        if len(inside) > deepest:
            raise InputFileError(self._path, f"has a name of more than {deepest} parts")
        document = self._into.document
        for name in inside[:-1]:
            below = document.setdefault(name, {})
            if not isinstance(below, dict):
                below = document[name] = {}
            document = below
        if isinstance(value, Mapping):
            for key, item in value.items():
                self._put((*inside, *_split(str(key))), item)
        elif inside:
            document[inside[-1]] = value

    def _section(self, element: Element, attribute: str) -> tuple[str, ...]:
        """Return the sections in a name; those of a robot's namespace are none."""
        return tuple(word for word in self._words(element, attribute) if word in SECTIONS)

    def _words(self, element: Element, attribute: str) -> tuple[str, ...]:
        return _split(self._value(element, attribute))

    def _chosen(self, element: Element) -> bool:
        wanted = "if" not in element.attrib or self._value(element, "if").lower() not in _NO
        return wanted and (
            "unless" not in element.attrib or self._value(element, "unless").lower() in _NO
        )

    def _value(self, element: Element, attribute: str) -> str:
        return self._replaced(element.get(attribute, ""))

    def _replaced(self, text: str) -> str:
        longest, size = 100_000, len(text)  # a value may double with each argument

        def counted(match: re.Match[str]) -> str:
            nonlocal size
            value = self._substitute(match)
            size += len(value)
            if size > longest + len(text):
                raise InputFileError(self._path, f"has values of more than {longest} characters")
            return value

        return _SUBSTITUTION.sub(counted, text)

    def _substitute(self, match: re.Match[str]) -> str:
        kind, name = match[1], match[2].strip()
        variable, _, otherwise = name.partition(" ")
        if kind == "arg" and name in self._arguments:
            return self._arguments[name]
        if kind == "dirname":
            return str(self._path.parent)
        if kind == "optenv" or (kind == "env" and variable in os.environ):
            return os.environ.get(variable, otherwise.strip())
        if kind == "find" and (folder := _package(self._path, name)) is not None:
            return str(folder)
        raise _Unknown(f"the value of {match[0]} is not known")


def _package(beside: Path, name: str) -> Path | None:
    from arjuna_sim.files.search_path import SearchPath

    return SearchPath.of().package(beside.resolve(), name)


def _split(name: str) -> tuple[str, ...]:
    """Return the parts of a parameter's name, `~` and slashes left out."""
    return tuple(part for part in name.lstrip("~").split("/") if part)


def _typed(text: str, kind: str) -> Any:
    if kind in ("str", "string"):
        return text
    try:
        value = plain(text)
    except yaml.YAMLError:
        return text
    return value if isinstance(value, bool | int | float) else text


def _yaml(path: Path, text: str) -> Any:
    try:
        return plain(text)
    except yaml.YAMLError as error:
        raise InputFileError(path, f"holds a <rosparam> that is no YAML: {error}") from error
