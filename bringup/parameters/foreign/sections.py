"""The sections of a parameter file by our nodes, and what launch files fill in them."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from typing import Any

from arjuna_core.errors import closest
from bringup.parameters.files import EVERY_NODE, Parameters, namespace_of, node_of
from bringup.parameters.foreign import nav2
from bringup.parameters.foreign.earlier import as_since_foxy
from bringup.parameters.remarks import Kind, Remark
from bringup.stack import NAV2_PROGRAMS, NodeSpec, program_of

FILLED = "a launch file fills '{}'; the default holds"
_NAMESPACE = "<robot_namespace>"
_PLACEHOLDER = re.compile(r".*(<\w+>|\$\{.+\}|\{\{.+\}\}|\$\((?!find-pkg-share).+\)).*")
_MANAGER = "controller_manager"
_XML = re.compile(r"/>|</\w")


def sections_by_node(
    given: Parameters, nodes: Mapping[str, NodeSpec], namespace: str
) -> tuple[Parameters, list[Remark]]:
    """Return a file's values by our nodes, placeholders filled, and remarks on other nodes."""
    found: Parameters = {}
    remarks: list[Remark] = []
    first = ""
    managers = [values for name, values in given.items() if name.endswith(_MANAGER)]
    managed = {key.removesuffix(".type") for values in managers for key in values}
    for name, values in given.items():
        if name == EVERY_NODE:
            continue
        today = nav2.section_as_today(name)
        node = node_of(today, nodes, namespace)
        if node is None:
            remarks.append(_of_other_node(name, today, values, nodes, managed))
            continue
        robot = namespace_of(today, node)
        first = first or robot
        if not namespace and robot not in ("", first):
            reason = f"of a robot beside '{first}', whose sections hold; --namespace chooses one"
            remarks.append(Remark(Kind.UNKNOWN, name, reason))
            continue
        kept = found.setdefault(node, {})
        for key, value in as_since_foxy(name, values).items():
            filled = _filled(value, namespace)
            if isinstance(filled, str) and _is_placeholder(key, filled):
                remarks.append(Remark(Kind.NO_EFFECT, f"{node}: {key}", FILLED.format(value)))
            elif filled is not None:  # a name without a value says nothing
                kept[key] = filled
    return found, remarks


def _filled(value: Any, namespace: str) -> Any:
    """Return a value with the placeholder of Nav2's launch files for the robot's namespace filled.

    Nav2's `bringup_launch.py` replaces it by `/` and the namespace.
    """
    if not isinstance(value, str):
        return value
    return value.replace(_NAMESPACE, f"/{namespace}" if namespace else "")


def _is_placeholder(key: str, value: str) -> bool:
    """Return whether a launch file is to fill a value: `<name>`, `$(...)`, corners' names."""
    if _XML.search(value):  # a robot's description in one line
        return False
    named = key.rpartition(".")[2] == "footprint" and re.search("[A-Za-z]{2}", value)
    return bool(named or _PLACEHOLDER.fullmatch(value))


def of_program(where: str, program: tuple[str, str], name: str = "") -> Remark:
    """Return that what is named is of a program's node, which runs alone, by a name if given."""
    renamed = f"-r __node:={name} " if name else ""
    command = f"ros2 run {' '.join(program)} --ros-args {renamed}--params-file FILE"
    return Remark(Kind.NOT_NEEDED, where, f"a node that '{command}' runs")


def _of_other_node(
    name: str,
    today: str,
    values: Mapping[str, Any],
    nodes: Mapping[str, NodeSpec],
    managed: Collection[str],
) -> Remark:
    """Return a remark on a node that is none of ours; `managed` are a robot's controllers."""
    if (node := node_of(today, nodes)) is not None:
        return Remark(Kind.NOT_NEEDED, name, f"'{node}' of another namespace")
    if (program := program_of(today)) is not None:
        return of_program(name, program)
    last = name.rpartition("/")[2]
    if (program := program_of(today, values)) is not None:
        return of_program(name, program, last)
    for package, executable in NAV2_PROGRAMS:
        if last.endswith(f"_{executable}"):
            words = f"{package} {executable} --ros-args -r __node:={last} --params-file FILE"
            reason = f"no node of a stack has this name; 'ros2 run {words}' runs one"
            return Remark(Kind.UNKNOWN, name, reason)
    known = nav2.of_node(_MANAGER if last in managed else name)
    if known is not None:
        kind, reason = known
        safety = nav2.is_safety("nodes", name.rpartition("/")[2])
        return Remark(kind, name, f"there is no such node here: {reason}", safety)
    return Remark(Kind.UNKNOWN, name, f"no node has this name{closest(name, nodes)}")
