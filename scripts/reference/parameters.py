"""The page of parameters, from the nodes' config dataclasses."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from arjuna_core.config import infos
from arjuna_core.plugins import NamedConfigs, PluginTypes, canonical
from bringup.parameters.files import for_node, shipped_parameters
from bringup.parameters.listing import bounds, described, scalar
from bringup.stack import ALL_GROUPS, ORIGINALS, PROGRAMS, NodeSpec, all_nodes, further_nodes
from scripts.reference import NOTE, cell, code

_INTRO = f"""# Parameters

Every parameter of every node, with the value that [params/](../../params/README.md) give it;
where the node's own default differs, it follows in brackets. The same as a file: `python -m
bringup params dump [NODE ...]`. What a plug-in has stands below the plug-in's name; the classes
that are not loaded follow at the end ([plugins.md](../plugins.md) says how to choose them).

{NOTE}
"""

_FURTHER = (
    *("filter_mask_server", "costmap_filter_info_server", "collision_detector"),
    "base_footprint_publisher",
)


def page() -> str:
    """Return the page."""
    nodes = [spec for group in ALL_GROUPS for spec in group.nodes]
    beside = [*further_nodes({name: {} for name in _FURTHER}), *PROGRAMS.values()]
    specs = {spec.name: spec for spec in (*nodes, *beside, *all_nodes())}
    lines = [_INTRO, *(line for spec in specs.values() for line in _node(spec))]
    lines += ["## Plug-ins that are not loaded there\n", "With their own defaults.\n"]
    lines += [line for spec in specs.values() for line in _not_loaded(spec)]
    return "\n".join(lines).rstrip("\n") + "\n"


def _node(spec: NodeSpec) -> Iterator[str]:
    yield f"## `{spec.name}`\n"
    yield from _table(spec, spec.config, for_node(shipped_parameters(), spec.name))


def _not_loaded(spec: NodeSpec) -> Iterator[str]:
    config, values = spec.config, for_node(shipped_parameters(), spec.name)
    rows = list(described(config, values))
    loaded = {(row.info.description, canonical(str(row.value))) for row in rows}
    for kind in dict.fromkeys(
        r.info.plugins for r in rows if isinstance(r.info.plugins, PluginTypes)
    ):
        for name in kind.types:
            if (f"Class of the {kind.what}, or module:Class.", name) not in loaded:
                yield f"### `{name}`\n\nA {kind.what} of `{spec.name}`.\n"
                primary = {"primary_controller": kind.default}
                made = kind.config_of(name, primary)
                given = primary if primary.keys() <= infos(made).keys() else {}
                yield from _table(spec, made, given)
    for row in rows:
        if isinstance(row.info.plugins, NamedConfigs) and not row.value:
            yield f"### Each of `{row.key}`\n\nOf `{spec.name}`.\n"
            yield from _table(spec, row.info.plugins.config, {})


def _table(spec: NodeSpec, config: type[Any], values: Mapping[str, Any]) -> Iterator[str]:
    yield "| parameter | value | valid | meaning |"
    yield "|---|---|---|---|"
    for one in described(config, values):
        value = code("" if one.value is None else scalar(one.value))
        own = "" if one.value == one.default else f" ({code(scalar(one.default))})"
        unit = f" [{one.info.unit}]" if one.info.unit else ""
        limits = (bounds(one.info).strip("()"), "fixed once it runs" * one.info.read_only)
        other = f"as {ORIGINALS[spec.original]}: `{scalar(one.info.theirs)}`"
        theirs = "" if one.info.theirs is None else other
        valid = cell("; ".join(filter(None, (*limits, theirs))))
        yield f"| `{one.key}` | {value}{own} | {valid} | {cell(one.info.description)}{unit} |"
    yield ""
