"""The graph: nodes, ends of topics, lifecycle states."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from lifecycle_msgs.srv import GetState
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.srv import GetParameters

from arjuna_core.ros.context import full_name, full_names
from arjuna_core.ros.local.actions import served_actions
from arjuna_core.ros.qos import qos_of
from bringup.client.endpoint import Endpoint
from bringup.client.session import Session

_TYPE = "lifecycle_msgs/srv/GetState"
_SERVICE = "/get_state"


def nodes(session: Session) -> list[str]:
    """Return the full names of all nodes but the session's own, one for each."""
    own = session.client.get_fully_qualified_name()
    return sorted(name for name in full_names(session.client) if name != own)


def lifecycle_states(session: Session, timeout: float) -> dict[str, str]:
    """Return the state of each managed node, "" of those that do not answer in time [s]."""
    found = session.client.get_service_names_and_types()
    services = [name for name, types in found if _TYPE in types]
    answers = _ask_all(session, GetState, services, GetState.Request(), timeout)
    return {
        name.removesuffix(_SERVICE): answers[name].current_state.label if name in answers else ""
        for name in services
    }


def on_system_time(session: Session, names: Collection[str], timeout: float) -> list[str]:
    """Return those of the nodes that say, within a time [s], that they do not use /clock."""
    services = {f"{name}/get_parameters": name for name in names}
    there = dict(session.client.get_service_names_and_types())
    request = GetParameters.Request(names=["use_sim_time"])
    asked = [service for service in services if service in there]
    answers = _ask_all(session, GetParameters, asked, request, timeout)
    return [
        services[service]
        for service, answer in answers.items()
        if answer.values
        and answer.values[0].type == ParameterType.PARAMETER_BOOL
        and not answer.values[0].bool_value
    ]


def _ask_all(
    session: Session, kind: Any, services: Collection[str], request: Any, timeout: float
) -> dict[str, Any]:
    """Return the answers, by name, of the services of a type that respond within a time [s]."""
    client = session.client
    clients = {name: client.create_client(kind, name) for name in services}
    session.run_until(
        lambda: all(each.service_is_ready() for each in clients.values()), timeout, required=False
    )
    calls = {n: each.call_async(request) for n, each in clients.items() if each.service_is_ready()}
    session.run_until(lambda: all(each.done() for each in calls.values()), timeout, required=False)
    for each in clients.values():
        client.destroy_client(each)
    return {name: call.result() for name, call in calls.items() if call.done()}


def action_server_state(session: Session, name: str) -> str:
    """Return the lifecycle state of the node that serves an action; "" where it has none."""
    client = session.client
    action = client.resolve_service_name(name)
    for node, namespace in client.get_node_names_and_namespaces():
        if action in served_actions(client, node, namespace):
            service = f"{full_name(node, namespace)}{_SERVICE}"
            if service not in dict(client.get_service_names_and_types()):
                return ""
            return str(session.call(GetState, service, GetState.Request()).current_state.label)
    return ""


def endpoints(session: Session) -> tuple[Endpoint, ...]:
    """Return who publishes and who listens, the session's own node left out."""
    client, found = session.client, []
    for topic, _ in client.get_topic_names_and_types():
        found += [(True, topic, info) for info in client.get_publishers_info_by_topic(topic)] + [
            (False, topic, info) for info in client.get_subscriptions_info_by_topic(topic)
        ]
    ends = []
    for publishes, topic, info in found:
        if (info.node_name, info.node_namespace) != (client.get_name(), client.get_namespace()):
            node, qos = full_name(info.node_name, info.node_namespace), qos_of(info.qos_profile)
            ends.append(
                Endpoint(node, topic, info.topic_type, publishes, qos.reliable, qos.latched)
            )
    return tuple(ends)
