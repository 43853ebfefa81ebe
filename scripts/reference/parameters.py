"""The page of parameters, from the nodes' config dataclasses."""

from __future__ import annotations

from collections.abc import Iterator

from bringup.parameters.composition import node_class
from bringup.parameters.files import for_node, shipped_parameters
from bringup.parameters.inputs import ALL_GROUPS
from bringup.parameters.listing import bounds, described, scalar
from bringup.stack import NodeSpec
from scripts.reference import NOTE, cell, code

_INTRO = f"""# Parameters

Every parameter of every node, with the value that [params/](../../params/README.md) give it;
where the node's own default differs, it follows in brackets. The same as a file: `python -m
bringup params dump [NODE ...]`. What a plug-in has stands below the plug-in's name;
[plugins.md](../plugins.md) lists the classes that are not loaded here.

{NOTE}
"""


def page() -> str:
    """Return the page."""
    specs = {spec.name: spec for group in ALL_GROUPS for spec in group.nodes}
    lines = [_INTRO, *(line for spec in specs.values() for line in _node(spec))]
    return "\n".join(lines).rstrip("\n") + "\n"


def _node(spec: NodeSpec) -> Iterator[str]:
    cls = node_class(spec)
    yield f"## `{spec.name}`\n"
    yield "| parameter | value | valid | meaning |"
    yield "|---|---|---|---|"
    for one in described(cls.Config, for_node(shipped_parameters(), spec.name)):
        value = code("" if one.value is None else scalar(one.value))
        own = "" if one.value == one.default else f" ({code(scalar(one.default))})"
        unit = f" [{one.info.unit}]" if one.info.unit else ""
        valid = cell(bounds(one.info).strip("()"))
        yield f"| `{one.key}` | {value}{own} | {valid} | {cell(one.info.description)}{unit} |"
    yield ""
