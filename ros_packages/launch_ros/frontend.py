"""The nodes of XML and YAML launch files."""

from __future__ import annotations

import shlex
from typing import Any

from launch.action import Action
from launch.frontend import Entity, Text, of_process, parse_substitution

from launch_ros import actions
from launch_ros.descriptions import ComposableNode
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue


def node(entity: Entity, kind: Any = actions.Node) -> Action:
    """Return a node."""
    given = {**of_process(entity), **_named(entity)}
    if "exec_name" in entity.texts:
        given["exec_name"] = entity.text("exec_name")
    for name, text in (("arguments", "args"), ("ros_arguments", "ros_args")):
        if text in entity.texts:
            given[name] = _words(entity.texts[text])
    found: Action = kind(package=entity.needed("pkg"), executable=entity.needed("exec"), **given)
    return found


def lifecycle_node(entity: Entity) -> Action:
    """Return a node with a lifecycle."""
    return node(entity, actions.LifecycleNode)


def _words(text: str) -> list[Text]:
    """Return a text's words, where a substitution is part of one word."""
    held: list[str] = []
    parts, at = [], 0
    while (start := text.find("$(", at)) >= 0:
        depth, end = 1, start + 2
        while end < len(text) and depth:
            depth += {"(": 1, ")": -1}.get(text[end], 0)
            end += 1
        parts += [text[at:start], f"\x00{len(held)}\x00"]
        held.append(text[start:end])
        at = end
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
        return {entity.texts["name"]: joined}
    kind = entity.texts.get("type")
    return {entity.texts["name"]: ParameterValue(entity.needed("value"), value_type=kind)}


def _composable(entity: Entity) -> list[ComposableNode]:
    return [
        ComposableNode(package=one.needed("pkg"), plugin=one.needed("plugin"), **_named(one))
        for one in entity.all("composable_node")
    ]


def node_container(entity: Entity) -> Action:
    """Return a container's nodes."""
    return actions.ComposableNodeContainer(composable_node_descriptions=_composable(entity))


def load_composable_node(entity: Entity) -> Action:
    """Return a container's nodes."""
    return actions.LoadComposableNodes(composable_node_descriptions=_composable(entity))


def push_ros_namespace(entity: Entity) -> Action:
    """Return what puts nodes below a namespace."""
    return actions.PushRosNamespace(entity.needed("namespace", "ns"))


def set_parameter(entity: Entity) -> Action:
    """Return what sets a parameter of all nodes."""
    kind = entity.texts.get("type")
    value = ParameterValue(entity.needed("value"), value_type=kind)
    return actions.SetParameter(entity.needed("name"), value)


def set_parameters_from_file(entity: Entity) -> Action:
    """Return what gives a file of parameters to all nodes."""
    return actions.SetParametersFromFile(entity.needed("filename"))


def set_use_sim_time(entity: Entity) -> Action:
    """Return what sets `use_sim_time` of all nodes."""
    return actions.SetUseSimTime(ParameterValue(entity.needed("value")))


def set_remap(entity: Entity) -> Action:
    """Return what gives a name another name in all nodes."""
    return actions.SetRemap(entity.needed("from"), entity.needed("to"))
