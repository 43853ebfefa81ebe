"""`ros2 service list`, `type`, `find`, `info`, `call`."""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence

from bringup.ros2.client import Client, absolute, print_names_and_types, visible_types
from bringup.ros2.errors import Ros2Error
from bringup.ros2.types import interface_class
from bringup.ros2.values import fill
from bringup.ros2.verbs.pub import values_of


def list_services(arguments: argparse.Namespace) -> int:
    """List the services."""
    pairs = _services(arguments)
    if arguments.count_services:
        print(len(pairs))
    else:
        print_names_and_types(pairs, arguments.show_types)
    return 0


def find(arguments: argparse.Namespace) -> int:
    """List the services of a type."""
    pairs = [pair for pair in _services(arguments) if arguments.service_type in pair[1]]
    if arguments.count_services:
        print(len(pairs))
    else:
        print_names_and_types(pairs, types=False)
    return 0


def _services(arguments: argparse.Namespace) -> list[tuple[str, Sequence[str]]]:
    with Client(arguments) as client:
        client.discover()
        pairs = client.node.get_service_names_and_types()
    return visible_types(pairs, arguments.include_hidden_services)


def _types(client: Client, name: str) -> Sequence[str]:
    types: Sequence[str] = dict(client.node.get_service_names_and_types()).get(name, [])
    return types


def type_of(arguments: argparse.Namespace) -> int:
    """Print a service's types; 1 if there is no such service."""
    name = absolute(arguments.service_name)
    with Client(arguments) as client:
        if not client.discover(lambda: bool(_types(client, name))):
            return 1
        print("\n".join(_types(client, name)))
    return 0


def info(arguments: argparse.Namespace) -> int:
    """Print a service's type and how many serve and call it.

    Raises:
        Ros2Error: There is no such service.
    """
    name = absolute(arguments.service_name)
    with Client(arguments) as client:
        client.discover(lambda: bool(_types(client, name)))
        client.discover()
        types = _types(client, name)
        if not types:
            raise Ros2Error(f"Unknown service '{arguments.service_name}'")
        print(f"Type: {types[0] if len(types) == 1 else types}")
        print(f"Clients count: {client.node.count_clients(name)}")
        print(f"Services count: {client.node.count_services(name)}")
    return 0


def call(arguments: argparse.Namespace) -> int:
    """Call a service once, or at a rate until interrupted.

    Raises:
        Ros2Error: The type or a field does not exist.
    """
    service_type = interface_class(arguments.service_type, "srv")
    request = service_type.Request()
    fill(request, values_of(arguments.values, arguments.stdin))
    with Client(arguments) as client:
        service = client.node.create_client(service_type, arguments.service_name)
        if not client.spin(service.service_is_ready, 0.1):
            print("waiting for service to become available...")
            client.spin(service.service_is_ready)
        while True:
            print(f"requester: making request: {request!r}\n")
            sent = time.monotonic()
            response = client.result(service.call_async(request), None, arguments.service_name)
            print(f"response:\n{response!r}\n")
            if arguments.rate is None:
                return 0
            client.spin(lambda: False, max(sent + 1.0 / arguments.rate - time.monotonic(), 0.0))
