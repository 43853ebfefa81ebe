"""`ros2 service list`, `type`, `find`, `info`, `call`."""

from __future__ import annotations

import argparse
import time
from operator import methodcaller

from bringup.ros2.client import (
    Client,
    Names,
    absolute,
    print_names,
    print_types,
    visible_types,
    with_types,
)
from bringup.ros2.errors import Ros2Error
from bringup.ros2.filling import fill
from bringup.ros2.types import interface_class
from bringup.ros2.verbs.pub import values_of

_names = methodcaller("get_service_names_and_types")


def list_services(arguments: argparse.Namespace) -> None:
    """List the services."""
    names = with_types(_services(arguments), arguments.show_types)
    print_names(names, arguments.count_services)


def find(arguments: argparse.Namespace) -> None:
    """List the services of a type."""
    names = [name for name, types in _services(arguments) if arguments.service_type in types]
    print_names(names, arguments.count_services)


def _services(arguments: argparse.Namespace) -> Names:
    with Client(arguments) as client:
        client.discover()
        return visible_types(_names(client.node), arguments.include_hidden_services)


def type_of(arguments: argparse.Namespace) -> int:
    """Print a service's types; 1 if there is no such service."""
    hidden = arguments.include_hidden_services
    return print_types(arguments, arguments.service_name, _names, hidden)


def info(arguments: argparse.Namespace) -> None:
    """Print a service's type and how many serve and call it.

    Raises:
        Ros2Error: There is no such service.
    """
    name = absolute(arguments.service_name)
    with Client(arguments) as client:
        types = client.find_types(name, _names, arguments.include_hidden_services)
        if not types:
            raise Ros2Error(f"Unknown service '{arguments.service_name}'")
        print(f"Type: {types[0] if len(types) == 1 else types}")
        print(f"Clients count: {client.node.count_clients(name)}")
        print(f"Services count: {client.node.count_services(name)}")


def call(arguments: argparse.Namespace) -> None:
    """Call a service once, or at a rate until interrupted.

    Raises:
        Ros2Error: The type or a field does not exist, or the rate is none.
    """
    if arguments.rate is not None and not arguments.rate > 0.0:
        raise Ros2Error("rate must be greater than zero")
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
            response = client.result(service.call_async(request))
            print(f"response:\n{response!r}\n")
            if arguments.rate is None:
                return
            client.spin(lambda: False, max(sent + 1.0 / arguments.rate - time.monotonic(), 0.0))
