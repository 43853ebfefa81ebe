"""Sources of parameters, merged over the shipped ones and checked."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from arjuna_core.config import load
from arjuna_core.errors import ArjunaError, ConfigError, InputFileError
from arjuna_core.files.maps import load_map
from bringup.parameters.files import (
    EVERY_NODE,
    Parameters,
    Source,
    for_node,
    merged,
    node_of,
    of_file,
    shipped_parameters,
)
from bringup.parameters.foreign.nav2 import section_as_today
from bringup.parameters.foreign.understanding import understand
from bringup.parameters.remarks import Checked, Kind, Remark, lines
from bringup.parameters.robot_file import Driven, contradictions, of_robot, other_names
from bringup.parameters.sources import as_theirs, known_keys, of_words
from bringup.parameters.trees import lacking_for_trees, without_other_trees
from bringup.stack import (
    GLOBAL_COSTMAP,
    LOCAL_COSTMAP,
    PROGRAMS,
    SIM,
    SLAM_TOOLBOX,
    STACKS,
    VELOCITY_CHAIN,
    NodeSpec,
    all_nodes,
    further_nodes,
    program_of,
)

_SAFEGUARDS = "collision_monitor", "velocity_smoother"
_COMMANDS, _DRIVEN = "cmd_vel_nav", "cmd_vel"
_STAMPED = "enable_stamped_cmd_vel"
_TWICE = "it stands twice in one place of the file: the last alone holds"
_NAMED_FILES = {
    ("docking_server", "dock_database"): "no dock has a name",
    ("route_server", "graph_filepath"): "no graph is loaded",
    (SLAM_TOOLBOX.name, "map_file_name"): "a new map is begun",
}
_LATTICE_KEY = ".lattice_filepath"
_LATTICE = re.compile(r"/sample_primitives/.*/([\d.]+)m_turning_radius/(?!ackermann/)")
"""Nav2's own lattices, but a car's: what takes their place turns on the spot."""


def over_shipped(paths: Iterable[Path]) -> Parameters:
    """Return the shipped parameters under those of files; write what of each has no effect.

    Raises:
        ArjunaError: A file cannot be used.
    """
    read = merged_sources(paths)
    write_remarks(read.remarks)
    return read.parameters


def merged_sources(
    paths: Iterable[Path],
    words: Iterable[str] = (),
    namespace: str = "",
    strict: bool = False,
    originals: Collection[str] = (),
) -> Checked:
    """Return the shipped parameters under those of files, and these under the command line's words.

    Args:
        paths: The files; a later one's values win.
        words: `NAME:=VALUE` or `NODE:NAME:=VALUE`; no name of theirs may be unknown.
        namespace: Of the robot, which the files' nodes may stand below.
        strict: Whether an unknown name refuses a file.
        originals: Whose behaviour takes the place of shipped values and defaults in their nodes.

    Raises:
        ArjunaError: A file or a word cannot be used.
    """
    parameters, remarks = shipped_parameters(), list[Remark]()
    meant = [spec for spec in all_nodes() if spec.original in originals]
    parameters = base = as_theirs(parameters, meant, replaces=True)
    given = of_words(words)
    sources = ((path, strict) for path in paths)
    for source, strictly in [*((of_file(p), s) for p, s in sources), (given, True)]:
        read = checked(source, parameters, namespace, base=base)
        if problems := read.refused_by(strictly):
            raise ConfigError(*problems)
        parameters = read.parameters
        remarks += read.remarks
    parameters = as_theirs(parameters, meant, replaces=False)
    parameters = merged(_chained(parameters), parameters)
    return Checked(_of_one_type(parameters), [*remarks, *lacking_for_trees(parameters, base)], [])


def _chained(parameters: Parameters) -> Parameters:
    """Return where the velocity smoother takes its velocities from, and where they go.

    They go where the collision monitor takes them from. A monitor that takes the controllers' own
    stands before the smoother, which then has what the monitor lets pass: else it would answer
    itself. Nav2's launch files connect the two by remapping; no parameter of theirs does.
    """
    monitor, smoother = (parameters.get(name, {}) for name in _SAFEGUARDS)
    taken = monitor.get("cmd_vel_in_topic")
    if taken != smoother.get("cmd_vel_in_topic", _COMMANDS):
        return {"velocity_smoother": {"cmd_vel_out_topic": taken}} if taken else {}
    passed = monitor.get("cmd_vel_out_topic", _DRIVEN)
    smoothed = {} if passed == _DRIVEN else {"cmd_vel_out_topic": _DRIVEN}
    return {"velocity_smoother": {"cmd_vel_in_topic": passed, **smoothed}}


def checked(
    source: Source,
    below: Parameters,
    namespace: str = "",
    only: NodeSpec | None = None,
    base: Parameters | None = None,
) -> Checked:
    """Return parameters with a source's over those below, and remarks; `only` one node, or all.

    Args:
        base: What held before all sources; none: what is below.
    """
    if not source.values:
        return Checked(below, [], [])
    further = [only] if only else further_nodes(merged(below, source.values))
    nodes = list({spec.name: spec for spec in (*all_nodes(), *further)}.values())
    after, remarks, problems = understand(source.values, below, nodes, namespace, base)
    remarks += [Remark(Kind.UNKNOWN, where, _TWICE) for where in sorted(source.repeated)]
    remarks += _without_missing_masks(after, further)
    remarks += _without_missing_files(after, bool(source.lines))
    remarks += without_other_trees(after, problems)
    problems += problems_of(
        after, [one for one in nodes if after.get(one.name) != below.get(one.name)]
    )
    locate = _locator(source)
    located = [one._replace(location=locate(one.where)) for one in remarks]
    return Checked(after, located, [f"{locate(text)}: {text}" for text in problems])


def check_file(path: Path, robot: str = "") -> Checked:
    """Return the result of a file over the shipped parameters, with the files that both name.

    The robot that is driven by it is the shipped one if its file is empty.

    Raises:
        ArjunaError: The robot's file cannot be used.
    """
    from arjuna_sim.inputs import named_robot

    read_robot = cache(named_robot)
    try:
        source = of_file(path)
        read = checked(source, shipped_parameters())
    except InputFileError as error:
        return Checked({}, [], [str(error)])
    known = {spec.name for spec in (*all_nodes(), *further_nodes(read.parameters))}
    for name, given in source.values.items():
        program = program_of(name, () if name == EVERY_NODE else given)
        if program is None or not known.isdisjoint((name, PROGRAMS[program].name)):
            continue
        spec = PROGRAMS[program]
        if program_of(name) is None:
            spec = replace(spec, name=name.rpartition("/")[2])
        alone = checked(source._replace(values={spec.name: given}, repeated=()), {}, only=spec)
        read.remarks.extend(alone.remarks)
        read.problems.extend(alone.problems)
    if not read.problems:
        driven, locate = Driven({"robot": robot}, read_robot), _locator(source)
        groups = STACKS["nav"]
        parameters = merged(read.parameters, of_robot(read.parameters, driven, groups))
        others = other_names(parameters, driven, groups) if robot else ()
        uncalled = lacking_for_trees(read.parameters, shipped_parameters())
        for one in (*uncalled, *contradictions(parameters, driven), *others):
            read.remarks.append(one._replace(location=locate(one.where)))
    for spec in all_nodes():
        values = for_node(read.parameters, spec.name)
        lacking = _lacking_map(values) if spec.name == "map_server" else ""
        if lacking:
            reason = f"there is no {lacking}; 'nav --map FILE' takes its place"
            read.remarks.append(Remark(Kind.NO_EFFECT, f"{spec.name}: yaml_filename", reason))
            continue
        try:
            read_named_files(spec, values, read_robot)
        except ArjunaError as error:
            read.problems.append(f"{path}: {spec.name}: {error}")
    return read


def write_remarks(remarks: Iterable[Remark]) -> None:
    """Write what is to be said of files at a start to the standard error output."""
    for line in lines(remarks, (Kind.NO_EFFECT, Kind.NOT_NEEDED), "'params check -v FILE'"):
        sys.stderr.write(f"{line}\n")


def problems_of(parameters: Parameters, specs: Iterable[NodeSpec]) -> list[str]:
    """Return what these nodes would refuse: keys unknown, values not valid."""
    problems: list[str] = []
    for spec in specs:
        try:
            load(spec.config, for_node(parameters, spec.name), spec.name)
        except ConfigError as error:
            problems += error.problems
    return problems


def _of_one_type(parameters: Parameters) -> Parameters:
    """Return parameters in which the whole chain of velocities is stamped if one of it is."""
    if not any(parameters.get(name, {}).get(_STAMPED) for name in VELOCITY_CHAIN):
        return parameters
    stamped: Parameters = {name: {_STAMPED: True} for name in (*VELOCITY_CHAIN, SIM.name)}
    for spec in (LOCAL_COSTMAP, GLOBAL_COSTMAP):
        known = known_keys(spec, parameters.get(spec.name, {}))
        stamped[spec.name] = {key: True for key in known if key.endswith(f".{_STAMPED}")}
    return merged(stamped, parameters)


def _without_missing_masks(parameters: Parameters, further: Iterable[NodeSpec]) -> list[Remark]:
    """Leave out the masks that nobody has, as stock files name them; return a remark on each."""
    remarks = []
    for spec in further:
        if name := _lacking_map(parameters.get(spec.name, {})):
            parameters[spec.name]["yaml_filename"] = ""
            reason = f"there is no {name}: nothing is kept out or slowed down by it"
            where = f"{spec.name}: yaml_filename"
            remarks.append(Remark(Kind.NO_EFFECT, where, reason, safety=True))
    return remarks


def _without_missing_files(parameters: Parameters, of_file: bool) -> list[Remark]:
    """Leave out the files that nobody has: launch files fill them in, or they are Nav2's own.

    Args:
        of_file: Whether a file names them; a graph that the command line asks for must exist.
    """
    remarks = []
    for (node, key), reason in _NAMED_FILES.items():
        values = parameters.get(node, {})
        name, folder = str(values.get(key) or ""), Path(str(values.get("maps_folder") or "."))
        paths = Path(name), folder / name, folder / f"{name}.posegraph"
        asked = node == SLAM_TOOLBOX.name and not of_file
        if name and not asked and not any(path.exists() for path in paths):
            del values[key]
            where = f"{node}: {key}"
            remarks.append(Remark(Kind.NO_EFFECT, where, f"there is no {name}: {reason}"))
    values = parameters.get("planner_server", {})
    for key in [key for key in values if key.endswith(_LATTICE_KEY)]:
        name = str(values[key])
        if (own := _LATTICE.search(name)) and not Path(name).exists():
            del values[key]
            values.setdefault(
                f"{key.removesuffix(_LATTICE_KEY)}.minimum_turning_radius", float(own[1])
            )
            reason = f"pieces that bend by {own[1]} m, and turns on the spot, take its place"
            where = f"planner_server: {key}"
            remarks.append(Remark(Kind.NO_EFFECT, where, f"there is no {name}: {reason}"))
    return remarks


def _locator(source: Source) -> Callable[[str], str]:
    """Return what finds file and line of a sentence on `node: key...` or `node: 'key'...`."""
    nodes = {spec.name for spec in all_nodes()}
    numbers = dict(source.lines)
    for (name, key), line in source.lines.items():
        node = node_of(section_as_today(name), nodes)
        numbers.setdefault((node or name, key), line)

    def locate(sentence: str) -> str:
        node, _, rest = sentence.partition(": ")
        found = re.search(r"'([^']+)'", rest) or re.match(r"(\S+)", rest)
        line = numbers.get((node, found[1] if found else "")) or numbers.get((node, ""))
        return f"{source.name}:{line}" if line else source.name

    return locate


def _lacking_map(values: Mapping[str, Any]) -> str:
    """Return the map that stock files name and nobody has, or nothing."""
    name = str(values.get("yaml_filename") or "")
    return "" if Path(name).exists() else name


def read_named_files(
    spec: NodeSpec, values: Mapping[str, Any], read_robot: Callable[[str, str], object]
) -> None:
    """Read the files that a node's parameters name: a bad one is refused before anything starts.

    Raises:
        ArjunaError: One cannot be used.
    """
    from arjuna_sim.inputs import named_world

    robots = [values.get("robot")] if spec.name in ("sim", "robot_state_publisher") else []
    robots += values.get("robots") or [] if spec.name == "sim" else []
    for path in filter(None, robots):
        read_robot(path, values.get("robot_arguments", ""))
    if spec.name == "sim" and values.get("viewer"):
        from arjuna_sim.physics.viewer import need_screen

        need_screen()
    if spec.name == "sim" and values.get("world"):
        named_world(values["world"])
    if spec.name == "map_server" and values.get("yaml_filename"):
        load_map(values["yaml_filename"])
    for key, value in values.items() if spec.name == "planner_server" else ():
        if key.endswith(_LATTICE_KEY) and value:
            from arjuna_nav.planners.hybrid.lattice import read

            read(Path(value))
