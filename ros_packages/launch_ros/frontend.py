"""The nodes of XML and YAML launch files."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from typing import Any

from launch.action import Action
from launch.frontend import TAGS, Entity
from launch.tags import of_process
from launch.texts import Text, closing, parse_substitution

from launch_ros import actions
from launch_ros.descriptions import ComposableNode
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue


def node(entity: Entity, kind: Any = actions.Node) -> Action:
    given = {**of_process(entity), **_named(entity)}
    if "exec_name" in entity.texts:
        given["exec_name"] = entity.text("exec_name")
    for name, text in (("arguments", "args"), ("ros_arguments", "ros_args")):
        if text in entity.texts:
            given[name] = _words(entity.texts[text])
    found: Action = kind(package=entity.needed("pkg"), executable=entity.needed("exec"), **given)
    return found


def _words(text: str) -> list[Text]:
    """Return a text's words, where a substitution is part of one word."""
    held: list[str] = []
    parts, at = [], 0
    while (start := text.find("$(", at)) >= 0:
        parts += [text[at:start], f"\x00{len(held)}\x00"]
        at = closing(text, start + 2) + 1
        held.append(text[start:at])
    words = shlex.split("".join([*parts, text[at:]]))
    for index, inside in enumerate(held):
        words = [word.replace(f"\x00{index}\x00", inside) for word in words]
    return [parse_substitution(word) for word in words]


def _named(entity: Entity) -> dict[str, Any]:
    """Return name, namespace, parameters and remappings of a node."""
    given: dict[str, Any] = {}
    for name, others in (("name", ()), ("namespace", ("ns",))):
        if (text := entity.text(name, *others)) is not None:
            given[name] = text
    if parameters := [_parameter(one) for one in entity.all("param")]:
        given["parameters"] = parameters
    if remaps := [(one.needed("from"), one.needed("to")) for one in entity.all("remap")]:
        given["remappings"] = remaps
    return given


def _parameter(entity: Entity) -> Any:
    if "from" in entity.texts:
        substituted = entity.flag("allow_substs", False)
        return ParameterFile(entity.needed("from"), allow_substs=substituted)
    inner = [one for one in entity.all("param") if "from" not in one.texts]
    if inner:
        joined: dict[str, Any] = {}
        for one in inner:
            joined |= _parameter(one)
        return {entity.plain("name"): joined}
    return {entity.plain("name"): _value(entity)}


def _composable(entity: Entity) -> list[ComposableNode]:
    return [
        ComposableNode(package=one.needed("pkg"), plugin=one.needed("plugin"), **_named(one))
        for one in entity.all("composable_node")
    ]


def _value(entity: Entity) -> ParameterValue:
    value = entity.needed("value")
    if separator := entity.texts.get("value-sep", entity.texts.get("value_sep")):
        value = parse_substitution(f"[{entity.texts['value'].replace(separator, ', ')}]")
    return ParameterValue(value, value_type=entity.texts.get("type"))


def _nodes_of(kind: Any) -> Callable[[Entity], Action]:
    return lambda entity: kind(composable_node_descriptions=_composable(entity))


TAGS |= {
    "node": node,
    "lifecycle_node": lambda e: node(e, actions.LifecycleNode),
    "node_container": _nodes_of(actions.ComposableNodeContainer),
    "load_composable_node": _nodes_of(actions.LoadComposableNodes),
    "push_ros_namespace": lambda e: actions.PushRosNamespace(e.needed("namespace", "ns")),
    "set_parameter": lambda e: actions.SetParameter(e.needed("name"), _value(e)),
    "set_parameters_from_file": lambda e: actions.SetParametersFromFile(e.needed("filename")),
    "set_remap": lambda e: actions.SetRemap(e.needed("from"), e.needed("to")),
    "set_use_sim_time": lambda e: actions.SetUseSimTime(_value(e)),
}
