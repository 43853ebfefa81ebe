"""Parameter files read over the shipped parameters, with all that is to be said of them."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from arjuna_core.errors import ArjunaError, ConfigError, InputFileError
from arjuna_core.files.maps import load_map
from bringup.parameters.composition import problems_of_change
from bringup.parameters.files import (
    Parameters,
    for_node,
    lines_of,
    load_parameters,
    merged,
    node_of,
    shipped_parameters,
)
from bringup.parameters.foreign.older import section_as_today
from bringup.parameters.foreign.understanding import understand
from bringup.parameters.remarks import Kind, Remark, lines
from bringup.stack import SIM, VELOCITY_CHAIN, NodeSpec, all_nodes, further_nodes

_STAMPED = "enable_stamped_cmd_vel"


class ReadFile(NamedTuple):
    """A parameter file, read over what holds below it.

    Attributes:
        parameters: Of all nodes.
        remarks: The names without effect, with file and line.
        problems: What refuses the file, a sentence each, with file and line.
    """

    parameters: Parameters
    remarks: list[Remark]
    problems: list[str]

    def refused_by(self, strict: bool) -> list[str]:
        """Return what refuses the file; where it is strict, unknown names too."""
        unknown = [str(one) for one in self.remarks if one.kind is Kind.UNKNOWN]
        return [*self.problems, *(unknown if strict else ())]


def over_shipped(paths: Iterable[Path]) -> Parameters:
    """Return the shipped parameters under those of files; write what of each has no effect.

    Raises:
        ArjunaError: A file cannot be used.
    """
    read = read_files(paths)
    write_remarks(read.remarks)
    return read.parameters


def read_files(paths: Iterable[Path], namespace: str = "", strict: bool = False) -> ReadFile:
    """Read files over the shipped parameters.

    Args:
        paths: The files; what a later one says wins.
        namespace: Of the robot, which the files' nodes may stand below.
        strict: Whether an unknown name refuses a file.

    Raises:
        ArjunaError: A file cannot be used.
    """
    whole = ReadFile(shipped_parameters(), [], [])
    for path in paths:
        read = read_over(path, whole.parameters, namespace)
        if problems := read.refused_by(strict):
            raise ConfigError(*problems)
        whole = ReadFile(read.parameters, [*whole.remarks, *read.remarks], [])
    return whole._replace(parameters=_of_one_type(whole.parameters))


def write_remarks(remarks: Iterable[Remark]) -> None:
    """Write what is to be said of files at a start to the standard error output."""
    for line in lines(remarks, (Kind.NO_EFFECT, Kind.NOT_NEEDED), "'params check -v FILE'"):
        sys.stderr.write(f"{line}\n")


def _of_one_type(parameters: Parameters) -> Parameters:
    """Return parameters in which the whole chain of velocities is stamped if one of it is."""
    if not any(parameters.get(name, {}).get(_STAMPED) for name in VELOCITY_CHAIN):
        return parameters
    return merged({name: {_STAMPED: True} for name in (*VELOCITY_CHAIN, SIM.name)}, parameters)


def read_over(path: Path, below: Parameters, namespace: str = "") -> ReadFile:
    """Read a parameter file over what holds below it.

    Raises:
        InputFileError: The file cannot be read, is no YAML or of another form.
    """
    given = load_parameters([path])
    further = further_nodes([*below, *given])
    nodes = [*all_nodes(), *further]
    understood = understand(given, below, nodes, namespace)
    after = understood.parameters
    missing = _without_missing_masks(after, further)
    problems = [*understood.problems, *problems_of_change(below, after, nodes)]
    at = _Places(path, given)
    remarks = [one._replace(place=at(one.where)) for one in [*understood.remarks, *missing]]
    return ReadFile(after, remarks, [f"{at(text)}: {text}" for text in problems])


def _without_missing_masks(parameters: Parameters, further: Iterable[NodeSpec]) -> list[Remark]:
    """Take out the masks that nobody has, as stock files name them; return a remark on each."""
    remarks = []
    for spec in further:
        if name := _lacking_map(parameters.get(spec.name, {})):
            del parameters[spec.name]["yaml_filename"]
            reason = f"there is no {name}: nothing is kept out or slowed down by it"
            where = f"{spec.name}: yaml_filename"
            remarks.append(Remark(Kind.NO_EFFECT, where, reason, safety=True))
    return remarks


class _Places:
    """Finds file and line of what a sentence is about: `node: key...` or `node: 'key'...`."""

    def __init__(self, path: Path, given: Parameters) -> None:
        self._path, self._lines = path, lines_of(path)
        nodes = {spec.name for spec in all_nodes()}
        for (name, key), line in list(self._lines.items()):
            node = node_of(section_as_today(name), nodes)
            self._lines.setdefault((node or name, key), line)

    def __call__(self, sentence: str) -> str:
        node, _, rest = sentence.partition(": ")
        found = re.search(r"'([^']+)'", rest) or re.match(r"(\S+)", rest)
        line = self._lines.get((node, found[1] if found else "")) or self._lines.get((node, ""))
        return f"{self._path}:{line}" if line else str(self._path)


def check_file(path: Path) -> ReadFile:
    """Read a parameter file over the shipped ones, and the files that its parameters name."""
    try:
        read = read_over(path, shipped_parameters())
    except InputFileError as error:
        return ReadFile({}, [], [str(error)])
    for spec in all_nodes():
        values = for_node(read.parameters, spec.name)
        lacking = _lacking_map(values) if spec.name == "map_server" else ""
        if lacking:
            reason = f"there is no {lacking}; 'nav --map FILE' takes its place"
            read.remarks.append(Remark(Kind.NO_EFFECT, f"{spec.name}: yaml_filename", reason))
            continue
        try:
            read_named_files(spec, values)
        except ArjunaError as error:
            read.problems.append(f"{path}: {spec.name}: {error}")
    return read


def _lacking_map(values: Mapping[str, Any]) -> str:
    """Return the map that stock files name and nobody has, or nothing."""
    name = str(values.get("yaml_filename") or "")
    return "" if Path(name).exists() else name


def read_named_files(spec: NodeSpec, values: dict[str, Any]) -> None:
    """Read the files that a node's parameters name: a bad one is refused before anything starts."""
    if spec.name in ("sim", "robot_state_publisher") and values.get("robot"):
        from arjuna_sim.inputs import named_robot

        named_robot(values["robot"], values.get("robot_arguments", ""))
    if spec.name == "sim" and values.get("robots"):
        from arjuna_sim.inputs import named_robot

        for path in values["robots"]:
            named_robot(path, values.get("robot_arguments", ""))
    if spec.name == "sim" and values.get("viewer"):
        from arjuna_sim.physics.viewer import need_screen

        need_screen()
    if spec.name == "sim" and values.get("world"):
        from arjuna_sim.inputs import named_world

        named_world(values["world"])
    if spec.name == "map_server" and values.get("yaml_filename"):
        load_map(values["yaml_filename"])
