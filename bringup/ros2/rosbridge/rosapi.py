"""Answers of rosapi's services: the graph, its types, parameters and the time."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter as RclpyParameter
from rclpy.parameter import parameter_value_to_python

from arjuna_core.ros.context import full_name, full_names
from bringup.recording.message_definitions import installed_type
from bringup.ros2.errors import Ros2Error
from bringup.ros2.rosbridge.topics import absolute
from bringup.ros2.rosbridge.values import to_json

_STATUS = "/_action/status"
Answered = Callable[[Any], None]


class RosApi:
    """Answers for rosapi.

    Args:
        send: Calls a service with a request's fields and hands the response on.
    """

    def __init__(self, node: Node, send: Callable[[str, Any, Answered], None]) -> None:
        self._node, self._send = node, send
        self._answers: dict[str, Callable[[Any], dict[str, Any]]] = {
            "topics": self._topics,
            "topics_and_raw_types": self._topics_and_raw_types,
            "topic_type": lambda a: {"type": self._type(self._seen("topic"), a["topic"])},
            "topics_for_type": lambda a: {"topics": _of_type(self._seen("topic"), a["type"])},
            "services": lambda _: {"services": sorted(self._seen("service"))},
            "service_type": lambda a: {"type": self._type(self._seen("service"), a["service"])},
            "services_for_type": lambda a: {"services": _of_type(self._seen("service"), a["type"])},
            "nodes": lambda _: {"nodes": full_names(self._node)},
            "node_details": self._node_details,
            "publishers": lambda a: {"publishers": self._ends("publishers", a["topic"])},
            "subscribers": lambda a: {"subscribers": self._ends("subscriptions", a["topic"])},
            "action_servers": lambda _: {"action_servers": self._actions()},
            "get_time": lambda _: {"time": to_json(self._node.get_clock().now().to_msg())},
            "get_ros_version": lambda _: {"version": 2, "distro": "jazzy"},
        }
        self._asks = {"get_param": self._get_param, "set_param": self._set_param}

    def answers(self, service: str) -> bool:
        """Return whether a service is one of rosapi's."""
        return service.startswith("/rosapi/")

    def call(self, service: str, args: Any, then: Answered) -> None:
        """Answer.

        Raises:
            Ros2Error: It is none that is answered, or lacks something.
        """
        name = service.removeprefix("/rosapi/")
        if name in self._asks:
            self._asks[name](args, then)
        elif name in self._answers:
            then(self._answers[name](args))
        else:
            valid = ", ".join(sorted([*self._answers, *self._asks]))
            raise Ros2Error(f"Service {service} does not exist; valid: {valid}")

    def _seen(self, what: str) -> dict[str, str]:
        found = getattr(self._node, f"get_{what}_names_and_types")()
        return {name: types[0] for name, types in found if types and "/_" not in name}

    def _type(self, found: dict[str, str], name: str) -> str:
        return found.get(absolute(name), "")

    def _topics(self, _: Any) -> dict[str, Any]:
        found = self._seen("topic")
        return {"topics": list(found), "types": list(found.values())}

    def _topics_and_raw_types(self, _: Any) -> dict[str, Any]:
        found = self._topics(None)
        return {**found, "typedefs_full_text": [installed_type(one)[0] for one in found["types"]]}

    def _node_details(self, args: Any) -> dict[str, Any]:
        namespace, _, name = absolute(args["node"]).rpartition("/")
        node, where = self._node, (name, namespace or "/")
        return {
            "subscribing": [n for n, _ in node.get_subscriber_names_and_types_by_node(*where)],
            "publishing": [n for n, _ in node.get_publisher_names_and_types_by_node(*where)],
            "services": [n for n, _ in node.get_service_names_and_types_by_node(*where)],
        }

    def _ends(self, what: str, topic: str) -> list[str]:
        found = getattr(self._node, f"get_{what}_info_by_topic")(absolute(topic))
        return sorted({full_name(each.node_name, each.node_namespace) for each in found})

    def _actions(self) -> list[str]:
        found = self._node.get_topic_names_and_types()
        return [name.removesuffix(_STATUS) for name, _ in found if name.endswith(_STATUS)]

    def _get_param(self, args: Any, then: Answered) -> None:
        node, name = _parameter(args)

        def got(response: GetParameters.Response) -> None:
            values = [parameter_value_to_python(each) for each in response.values]
            unknown = values in ([], [None])
            value = args.get("default_value", "") if unknown else json.dumps(to_json(values[0]))
            then({"value": value})

        self._send(f"{node}/get_parameters", {"names": [name]}, got)

    def _set_param(self, args: Any, then: Answered) -> None:
        node, name = _parameter(args)
        value = RclpyParameter(name, value=json.loads(args["value"])).to_parameter_msg()
        fields = to_json(value)

        def was_set(response: SetParameters.Response) -> None:
            then({"successful": all(each.successful for each in response.results)})

        self._send(f"{node}/set_parameters", {"parameters": [fields]}, was_set)


def _of_type(found: dict[str, str], type_name: str) -> list[str]:
    return [name for name, one in found.items() if one == type_name]


def _parameter(args: Any) -> tuple[str, str]:
    """Return the node and the name of a parameter, `/node:name`."""
    node, sign, name = str(args["name"]).partition(":")
    if not sign or not name:
        raise Ros2Error(f"'{node}' is no parameter; valid: /NODE:NAME")
    return absolute(node), name
