"""The live table of nodes, as plain values and text."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from bringup.client.endpoint import Endpoint
from bringup.doctor.machine import HostProcess
from bringup.stack import STACKS

_MAIN = {"sim": "/scan", "amcl": "/amcl_pose", "slam_toolbox": "/map"}
_PLUMBING = ("/rosout", "/parameter_events", "/tf", "/tf_static")
_WIDTHS = (32, 13, 13, 6, 28, 9)
_HEADINGS = ("NODE", "STATE", "PROCESS", "CPU", "TOPIC", "RATE", "LAST WARNING")


@dataclass(frozen=True)
class Row:
    """A node.

    Attributes:
        state: Lifecycle state, "" for none.
        process: The process of ours that runs it, "" for none.
        cpu: Share of one core that the process uses; None where unknown.
        topic: Its main one, "" for nothing.
        rate: Of that [Hz]; None where not counted.
        warning: Its last, "" for none.
    """

    node: str
    state: str = ""
    process: str = ""
    cpu: float | None = None
    topic: str = ""
    rate: float | None = None
    warning: str = ""


def main_topic(node: str, endpoints: Iterable[Endpoint]) -> str:
    """Return the topic of a node's main work; "" where it has none."""
    topics = sorted({end.topic for end in endpoints if end.publishes and end.node == node})
    work = [
        topic
        for topic in topics
        if topic not in _PLUMBING and "/_action/" not in topic and "transition_event" not in topic
    ]
    wanted = _MAIN.get(node.rpartition("/")[2], "")
    named = [topic for topic in work if wanted and topic.endswith(wanted)]
    return next(iter([*named, *work]), "")


def groups_by_node() -> dict[str, str]:
    """Return the process that runs each node of ours, by the node's name without namespaces."""
    groups = {group.name: group for stack in STACKS.values() for group in stack}
    found = {
        spec.name.rpartition("/")[2]: group.name
        for group in groups.values()
        for spec in group.nodes
    }
    found |= {group.manager: group.name for group in groups.values()}
    return found | {f"{name}_host": name for name in groups}


def cpu_shares(
    before: Collection[HostProcess], after: Collection[HostProcess], passed: float
) -> dict[str, float]:
    """Return each group's share of one core, between two looks `passed` [s] apart."""
    used = {host.pid: host.cpu_time for host in before}
    return {
        host.group: (host.cpu_time - used[host.pid]) / passed
        for host in after
        if host.pid in used and passed > 0.0
    }


def rows(
    nodes: Iterable[str],
    states: Mapping[str, str],
    shares: Mapping[str, float],
    topics: Mapping[str, str],
    rates: Mapping[str, float],
    warnings: Mapping[str, str],
) -> list[Row]:
    """Return a row for each node, of values by its full name, topic or logger; rates in [Hz]."""
    groups, found = groups_by_node(), []
    for node in nodes:
        group = groups.get(node.rpartition("/")[2], "")
        topic = topics.get(node, "")
        state = (states[node] or "no answer") if node in states else ""
        warning = warnings.get(node.strip("/").replace("/", "."), "")
        cpu, rate = shares.get(group), rates.get(topic)
        process = "" if cpu is None else group
        found.append(Row(node, state, process, cpu, topic, rate, warning))
    return found


def table_text(found: Iterable[Row], width: int) -> str:
    """Return the table, no line longer than a width [characters]."""
    lines = [_line(_HEADINGS)]
    for row in found:
        cpu = "" if row.cpu is None else f"{row.cpu:.0%}"
        rate = "" if row.rate is None else f"{row.rate:.1f} Hz"
        lines.append(_line((row.node, row.state, row.process, cpu, row.topic, rate, row.warning)))
    return "\n".join(line[:width].rstrip() for line in lines)


def _line(cells: tuple[str, ...]) -> str:
    fixed = zip(cells[:-1], _WIDTHS, strict=True)
    return " ".join([*(f"{cell[:width]:<{width}}" for cell, width in fixed), cells[-1]])
