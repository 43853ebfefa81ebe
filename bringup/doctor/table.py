"""The live table of nodes, as plain values and text."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from bringup.client.endpoint import Endpoint
from bringup.doctor.machine import HostProcess
from bringup.stack import STACKS

_MAIN = {"sim": "/scan", "amcl": "/amcl_pose", "slam_toolbox": "/map"}
_PLUMBING = ("/rosout", "/parameter_events", "/tf", "/tf_static")
_WIDTHS = (32, 13, 13, 6, 28, 9)
_HEADINGS = ("NODE", "STATE", "PROCESS", "CPU", "TOPIC", "RATE", "LAST WARNING")


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
) -> list[tuple[str, ...]]:
    """Return the cells of each node, of values by its full name, topic or logger; rates in [Hz]."""
    groups, found = groups_by_node(), list[tuple[str, ...]]()
    for node in nodes:
        group, topic = groups.get(node.rpartition("/")[2], ""), topics.get(node, "")
        state = (states[node] or "no answer") if node in states else ""
        process = (group, f"{shares[group]:.0%}") if group in shares else ("", "")
        rate = f"{rates[topic]:.1f} Hz" if topic in rates else ""
        warning = warnings.get(node.strip("/").replace("/", "."), "")
        found.append((node, state, *process, topic, rate, warning))
    return found


def table_text(rows: Iterable[tuple[str, ...]], width: int) -> str:
    """Return the table, no line longer than a width [characters]."""
    return "\n".join(_line(cells)[:width].rstrip() for cells in (_HEADINGS, *rows))


def _line(cells: tuple[str, ...]) -> str:
    fixed = zip(cells[:-1], _WIDTHS, strict=True)
    return " ".join([*(f"{cell[:width]:<{width}}" for cell, width in fixed), cells[-1]])
