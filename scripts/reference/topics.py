"""The page of topics, services and actions, from what the nodes offer once they are up."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import closing
from typing import Any

from rclpy.action import get_action_server_names_and_types_by_node
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

from arjuna_core.files.shipped import shipped_file
from bringup.lockstep import LockStep
from bringup.parameters.files import merged, shipped_parameters
from bringup.stack import (
    EXPLORER_GROUP,
    LOCALIZATION_GROUP,
    NAVIGATION_GROUP,
    SIM_GROUP,
    SLAM_GROUP,
)
from scripts.reference import NOTE, code

_INTRO = f"""# Topics, services and actions

What each node offers and listens to, with the shipped parameters and the Arjuna robot. All names
are relative: a namespace goes before them. Every node has its parameter services and a lifecycle
too; every process publishes `/rosout` and `/diagnostics` and listens to `/tf`, `/tf_static` and,
in simulated time, `/clock`.

{NOTE}
"""
_GROUPS = (SIM_GROUP, SLAM_GROUP, LOCALIZATION_GROUP, NAVIGATION_GROUP, EXPLORER_GROUP)
_EVERYWHERE = ("/parameter_events", "/rosout", "/transition_event")
_OF_EVERY_NODE = (
    *("change_state", "get_available_states", "get_available_transitions", "get_state"),
    *("get_transition_graph", "describe_parameters", "get_parameter_types", "get_parameters"),
    *("list_parameters", "set_parameters", "set_parameters_atomically", "get_type_description"),
)


def page() -> str:
    """Return the page; it starts every node in this process for it."""
    room = {"map_server": {"yaml_filename": str(shipped_file("maps/arjuna_room.yaml"))}}
    with closing(LockStep(merged(shipped_parameters(), room), transport="dds")) as robot:
        robot.start(*_GROUPS)
        names = [spec.name for group in _GROUPS for spec in group.nodes]
        lines = [line for name in names for line in _node(robot.client, name)]
    return "\n".join([_INTRO, *lines]).rstrip("\n") + "\n"


def _node(client: Any, full_name: str) -> Iterator[str]:
    namespace, _, name = f"/{full_name}".rpartition("/")
    where = (name, namespace or "/")
    actions = get_action_server_names_and_types_by_node(client, *where)
    yield f"## `{full_name}`\n"
    yield "| | name | type |"
    yield "|---|---|---|"
    for topic, types in _topics(client.get_publisher_names_and_types_by_node(*where)):
        yield _row(f"publishes{_manner(client, topic, where)}", topic, types)
    for topic, types in _topics(client.get_subscriber_names_and_types_by_node(*where)):
        yield _row("listens to", topic, types)
    for service, types in _services(client.get_service_names_and_types_by_node(*where)):
        yield _row("service", service, types)
    for action, types in sorted(actions):
        yield _row("action", action, types)
    yield ""


def _row(what: str, name: str, types: Iterable[str]) -> str:
    return f"| {what} | {code(name)} | {', '.join(map(code, types))} |"


def _topics(found: Iterable[tuple[str, list[str]]]) -> list[tuple[str, list[str]]]:
    return sorted(
        (name, types)
        for name, types in found
        if "/_action/" not in name and not name.endswith(_EVERYWHERE)
    )


def _services(found: Iterable[tuple[str, list[str]]]) -> list[tuple[str, list[str]]]:
    return sorted(
        (name, types)
        for name, types in found
        if "/_action/" not in name and name.rpartition("/")[2] not in _OF_EVERY_NODE
    )


def _manner(client: Any, topic: str, where: tuple[str, str]) -> str:
    """Return in what a publisher differs from the ordinary: reliable, for those there now."""
    for one in client.get_publishers_info_by_topic(topic):
        if (one.node_name, one.node_namespace) == where:
            latched = one.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
            lossy = one.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
            return ", latched" if latched else ", best effort" if lossy else ""
    return ""
