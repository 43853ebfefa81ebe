"""The behavior trees that parameters name, and the plug-ins that these call."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fnmatch import fnmatchcase
from typing import Any

from bringup.parameters.files import Parameters, for_node
from bringup.parameters.listing import values_of
from bringup.parameters.remarks import Kind, Remark
from bringup.stack import all_nodes

_NAVIGATOR, _TREES = "bt_navigator", "default_nav_*_bt_xml"
_BEHAVIORS = ("Spin", "Wait", "BackUp", "DriveOnHeading", "AssistedTeleop")
_IDS = {
    "controller_id": ("controller_server", "controller_plugins"),
    "goal_checker_id": ("controller_server", "goal_checker_plugins"),
    "progress_checker_id": ("controller_server", "progress_checker_plugins"),
    "planner_id": ("planner_server", "planner_plugins"),
    "smoother_id": ("smoother_server", "smoother_plugins"),
}
"""Ports that name a plug-in: its server, and the parameter that lists it."""
_LISTS = (("behavior_server", "behavior_plugins"), *_IDS.values())


def without_other_trees(parameters: Parameters, problems: list[str]) -> list[Remark]:
    """Leave out the behavior trees that nobody has, and those with nodes of someone's C++."""
    from arjuna_nav.trees.blackboard import TreeError
    from arjuna_nav.trees.files import default_tree
    from arjuna_nav.trees.xml_file import UnknownNodeError, read_tree, with_own_nodes

    remarks, values = [], parameters.get(_NAVIGATOR, {})
    folders = (".", *values.get("bt_search_directories", ()))
    for key in [key for key in values if fnmatchcase(key, _TREES) and values[key]]:
        name, where = values[key], f"{_NAVIGATOR}: {key}"
        try:
            path = default_tree(str(name), folders)
        except TreeError:
            del values[key]
            reason = f"there is no behavior tree '{name}'; the default one runs"
            remarks.append(Remark(Kind.UNKNOWN, where, reason))
            continue
        nodes, others = with_own_nodes(map(str, values.get("plugin_lib_names", ())))
        try:
            read_tree(path, nodes)
        except TreeError as error:
            if not (others and isinstance(error, UnknownNodeError)):
                problems.append(f"{where}: {error}")
                continue
            del values[key]
            remarks.append(Remark(Kind.UNKNOWN, where, f"{error}; the default tree runs"))
    return remarks


def lacking_for_trees(parameters: Parameters, base: Parameters) -> list[Remark]:
    """Return a remark on each plug-in that a tree calls and its server's list leaves out.

    Args:
        parameters: Valid ones; the trees that they name are there.
        base: Those of which nothing is to be said.
    """
    if _chosen(parameters) == _chosen(base):  # spares a start 0.3 s of reading trees
        return []
    servers = {_NAVIGATOR, *(server for server, _ in _LISTS)}
    configs = {spec.name: spec.config for spec in all_nodes()}
    whole = {name: values_of(configs[name], for_node(parameters, name)) for name in servers}
    navigator, found = whole[_NAVIGATOR], dict[tuple[str, str], Remark]()
    for key in [key for key in navigator if fnmatchcase(key, _TREES)]:
        default = getattr(configs[_NAVIGATOR], key)
        for node, server, listed, name in _called(navigator, navigator[key] or default, default):
            valid = whole[server][listed]
            if name not in valid:
                calls = f"<{node}> of {navigator[key] or default} calls '{name}'"
                reason = (
                    f"{calls}, which it leaves out ({', '.join(valid)}): that fails, as in Nav2"
                )
                where = f"{server}: {listed}"
                found.setdefault((where, name), Remark(Kind.UNKNOWN, where, reason))
    return list(found.values())


def _chosen(parameters: Parameters) -> Any:
    """Return what decides which plug-ins trees call and which there are."""
    lists = [parameters.get(server, {}).get(listed) for server, listed in _LISTS]
    return parameters.get(_NAVIGATOR), lists


def _called(
    navigator: Mapping[str, Any], tree: str, own: str
) -> Iterator[tuple[str, str, str, str]]:
    """Yield node, server, list and name of each plug-in that a tree calls by itself.

    Args:
        own: The name of Arjuna's, whatever lies in the working folder by that name.
    """
    from arjuna_core.files.shipped import shipped_file
    from arjuna_nav.trees.asking import Asking
    from arjuna_nav.trees.files import default_tree
    from arjuna_nav.trees.xml_file import read_tree, with_own_nodes

    folders = (".", *navigator["bt_search_directories"])
    ours = shipped_file("behavior_trees") / own
    path = ours if tree == own else default_tree(tree, folders)
    nodes, _ = with_own_nodes(navigator["plugin_lib_names"])
    for node in read_tree(path, nodes).nodes():
        kind = type(node).__name__
        if isinstance(node, Asking) and kind in _BEHAVIORS:
            asked = node.fixed(node.NAMED_BY)
            if asked is not None:
                yield kind, *_LISTS[0], asked or node.SERVER
        for port, (server, listed) in _IDS.items():
            for given in (port, f"default_{port.removesuffix('_id')}"):
                if name := node.fixed(given):
                    yield kind, server, listed, name
