"""ROS 1's names, ours for each, and the sections of a file that they are of: `ros1_names.yaml`."""

from __future__ import annotations

from collections.abc import Mapping
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path
from typing import Any

from arjuna_core.files.yaml_file import read_yaml

_DATA: dict[str, Any] = read_yaml(Path(__file__).with_suffix(".yaml"))
TABLES: dict[str, dict[str, Any]] = _DATA["tables"]
"""Names by section: amcl, gmapping, move_base and its parts."""
SECTIONS: dict[str, str] = {**_DATA["sections"], **{name: name for name in TABLES}}
"""The table of each section of a file."""
TOPICS: dict[str, str] = _DATA["topics"]
"""Our parameters of topics that a launch file renames, `NODE:NAME`, by `section/topic`."""
CLASSES: dict[str, str] = _DATA["classes"]
WITHOUT = frozenset(_DATA["without"].split())
"""Sections without a counterpart."""
REASONS: dict[str, str] = _DATA["reasons"]
"""Why a name has no effect, or none at a value."""
PROGRAMS: dict[str, dict[str, str]] = _DATA["programs"]
"""Programs without a counterpart: names of their parameters, and a remedy."""
LAYERS: dict[str, str] = _DATA["layers"]
"""Our layer of a costmap for each class of one."""
COSTMAPS = ("global_costmap", "local_costmap")


@cache
def targets(section: str, node: str = "") -> dict[str, list[tuple[str, str]]]:
    """Return our nodes and names for each of a section's names, none where it has no meaning here.

    Args:
        section: One of `TABLES`.
        node: The node of names that say none; the table's own if empty.
    """
    table = {**TABLES, **_DATA["parts"]}[section]
    node, below = node or table.get("of", ""), table.get("below", "")
    found = dict(targets(table["with"], node)) if "with" in table else {}
    found |= {name: [(node, name)] for name in table.get("same", "").split()}
    for name, ours in table.get("names", {}).items():
        whole = (f"{below}{one}" if one.startswith(".") else one for one in ours.split())
        parts = (one.rpartition(":")[::2] for one in whole)
        found[name] = [(given or node, key) for given, key in parts]
    return found | {name: [] for name in table.get("unused", "").split()}


def nested(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a file with its names by path, `/amcl/min_particles`, put into sections."""
    found: dict[str, Any] = {}
    for path, value in document.items():
        *sections, key = str(path).strip("/").split("/")
        inside = found
        for section in sections:
            inner = inside.setdefault(section, {})
            inside = inner if isinstance(inner, dict) else inside
        value = nested(value) if isinstance(value, Mapping) else value
        before = inside.get(key)
        if isinstance(before, dict) and isinstance(value, dict):
            value = {**before, **value}
        inside[key] = value
    return found


def is_section(key: str, value: Any) -> bool:
    """Return whether a name is that of a node or a plug-in with parameters of its own."""
    return key in SECTIONS and isinstance(value, Mapping)


def holds_sections(value: Any) -> bool:
    """Return whether sections stand below: it is a namespace, or `move_base` by another name."""
    return isinstance(value, Mapping) and any(
        is_section(key, inner) or holds_sections(inner) for key, inner in value.items()
    )


def sections_of(values: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the sections of most of these names, none if too few are known.

    Those of a costmap alone are both costmaps'; what a layer of it holds counts too.
    """
    known = {name: _known(values, name) for name in TABLES}
    best = max(known, key=lambda name: known[name])
    if not known[best]:
        return ()
    return COSTMAPS if best in COSTMAPS else (best,)


def renamed_section(value: Any) -> str:
    """Return which node's parameters these are under a name of somebody's own, or nothing."""
    if not isinstance(value, Mapping):
        return ""
    sections = sections_of(value)
    if len(sections) != 1 or 2 * _known(value, sections[0]) < len(value):
        return ""
    return sections[0]


def other_program(values: Mapping[str, Any]) -> str:
    """Return the program without a counterpart that has the most of these names, or nothing."""
    counts = {
        name: sum(any(fnmatchcase(key, one) for one in program["names"].split()) for key in values)
        for name, program in PROGRAMS.items()
    }
    best = max(counts, key=lambda name: counts[name])
    return best if counts[best] > max(_known(values, name) for name in TABLES) else ""


def _known(values: Mapping[str, Any], section: str) -> int:
    table = targets(section)
    layers = section in COSTMAPS
    return sum(
        key in table or (layers and isinstance(value, Mapping) and _known(value, section) > 0)
        for key, value in values.items()
    )
