"""Whose parameters stand where in a ROS 1 file: sections, namespaces, and names without any."""

from __future__ import annotations

from collections.abc import Mapping
from fnmatch import fnmatchcase
from typing import Any

from bringup.parameters.foreign.ros1_names import SECTIONS, TABLES, targets
from bringup.parameters.foreign.ros1_others import STRANGERS

COSTMAPS = ("global_costmap", "local_costmap")


def nested(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a file with its names by path, `/amcl/min_particles`, put into sections."""
    found: dict[str, Any] = {}
    for path, value in document.items():
        *sections, key = str(path).strip("/").split("/")
        place = found
        for section in sections:
            inner = place.setdefault(section, {})
            place = inner if isinstance(inner, dict) else place
        value = nested(value) if isinstance(value, Mapping) else value
        before = place.get(key)
        if isinstance(before, dict) and isinstance(value, dict):
            value = {**before, **value}
        place[key] = value
    return found


def is_section(key: str, value: Any) -> bool:
    """Tell whether a name is that of a node or a plug-in with parameters of its own."""
    return key in SECTIONS and isinstance(value, Mapping)


def holds_sections(value: Any) -> bool:
    """Tell whether sections stand below: it is a namespace, or `move_base` by another name."""
    return isinstance(value, Mapping) and any(
        is_section(key, inner) or holds_sections(inner) for key, inner in value.items()
    )


def sections_of(values: Mapping[str, Any]) -> tuple[str, ...]:
    """Return whose names these are for the most part, nobody's if too few are known.

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


def stranger(values: Mapping[str, Any]) -> str:
    """Return which program that is not here these are of more than of any that is, or nothing."""
    counts = {
        name: sum(any(fnmatchcase(key, entry) for entry in names.split()) for key in values)
        for name, names in STRANGERS.items()
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
