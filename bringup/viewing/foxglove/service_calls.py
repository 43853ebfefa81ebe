"""ROS services as Foxglove's clients call them."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

from rclpy.node import Node
from rclpy.serialization import deserialize_message, serialize_message

from arjuna_core.ros.context import class_of
from bringup.viewing.foxglove.offers import Offers, encoding_of, visible
from bringup.viewing.foxglove.server import Client


def _described(name: str, type_name: str) -> dict[str, Any]:
    """Return what is sent of a service, in the forms of both subprotocols."""
    class_of(type_name)
    fields: dict[str, Any] = {"name": name, "type": type_name}
    for part in ("request", "response"):
        fields[part] = encoding_of(f"{type_name}_{part.capitalize()}")
        fields[f"{part}Schema"] = fields[part]["schema"]
    return fields


class ServiceCalls:
    """Offers each service of the graph, and passes calls on."""

    def __init__(self, node: Node, clients: Sequence[Client]) -> None:
        self._node = node
        words = ("advertiseServices", "services", "serviceIds")
        self._offers = Offers(node, clients, words, _described)
        self.greet = self._offers.greet
        self._callers: dict[int, Any] = {}

    def refresh(self) -> None:
        """Offer new services, take back those that are gone."""
        found = visible(self._node.get_service_names_and_types())  # and where clients alone are
        served = {name: kind for name, kind in found.items() if self._node.count_services(name)}
        for number in self._offers.refresh(served):
            if number in self._callers:
                self._node.destroy_client(self._callers.pop(number))

    def call(self, client: Client, data: bytes) -> None:
        """Call a service; the answer is sent when it comes, or why there is none."""
        number, call, length = struct.unpack_from("<III", data)
        encoding, payload = data[12 : 12 + length], data[12 + length :]
        service = self._offers.find(number)

        def answered(future: Any) -> None:
            answer = encoding + serialize_message(future.result())
            client.send_binary(3, "III", number, call, length, data=answer)

        problem = "Unknown service" if service is None else ""
        if service and encoding != b"cdr":
            problem = "Unknown encoding; valid: cdr"
        elif service:
            kind = class_of(service["type"])
            if number not in self._callers:
                self._callers[number] = self._node.create_client(kind, service["name"])
            try:
                request = deserialize_message(payload, kind.Request)
                if self._callers[number].wait_for_service(timeout_sec=1.0):
                    self._callers[number].call_async(request).add_done_callback(answered)
                else:
                    problem = "Nobody serves it"
            except RuntimeError as error:
                problem = str(error)
        if problem:
            fields = {"serviceId": number, "callId": call, "message": problem}
            client.send_message("serviceCallFailure", **fields)
