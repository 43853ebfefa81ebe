"""`ros2 topic echo` and `ros2 service echo`."""

from __future__ import annotations

import argparse
import math
import threading
from collections.abc import Callable
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.qos import qos_profile_services_default

from bringup.ros2.client import Client, full_name
from bringup.ros2.errors import Ros2Error
from bringup.ros2.qos import for_subscription
from bringup.ros2.types import interface_class
from bringup.ros2.values import Abridge, dump, is_message, to_csv, to_plain, to_yaml
from bringup.ros2.verbs.names import names_of

_OF_CLIENTS = ("REQUEST_SENT", "RESPONSE_RECEIVED")
_EVENTS = ("REQUEST_SENT", "REQUEST_RECEIVED", "RESPONSE_SENT", "RESPONSE_RECEIVED")
"""By their numbers in service_msgs/ServiceEventInfo."""


def echo(arguments: argparse.Namespace) -> None:
    """Print messages of a topic until interrupted, timed out, or after the first."""
    printer = Printer(arguments)
    name = full_name(arguments.topic_name)
    # rclpy's events executor cannot hand on a message's times: Fast DDS does not count messages
    executor = SingleThreadedExecutor if arguments.include_message_info else EventsExecutor
    with Client(arguments, executor=executor) as client:
        client.discover(lambda: client.node.count_publishers(name) > 0)
        client.discover()  # all of its publishers, for the quality of service
        message_type = topic_class(client, arguments.topic_name, arguments.message_type)
        client.node.create_subscription(
            message_type,
            name,
            printer.show if arguments.include_message_info else lambda m: printer.show(m, None),
            for_subscription(client.node, name, arguments),
            event_callbacks=SubscriptionEventCallbacks(
                message_lost=None if arguments.no_lost_messages else _lost
            ),
            raw=arguments.raw,
        )
        client.run_until(lambda: printer.finished, arguments.timeout or math.inf, required=False)
    if printer.problem:
        raise Ros2Error(printer.problem)


def topic_class(client: Client, topic: str, given: str | None = None) -> Any:
    """Return the message class of a topic, or the one whose name is given."""
    if given is not None:
        return interface_class(given, "msg")
    types = dict(names_of("topic")(client.node)).get(full_name(topic), ())
    if len(types) > 1:
        kinds = ", ".join(types)
        raise Ros2Error(
            f"Cannot echo topic '{topic}', as it contains more than one type: [{kinds}]"
        )
    if not types:
        print(f"WARNING: topic [{topic}] does not appear to be published yet")
        raise Ros2Error("Could not determine the type for the passed topic")
    return interface_class(types[0], "msg")


def condition(expression: str | None) -> Callable[[Any], bool]:
    """Return what a person's Python expression says of a message `m`."""
    if not expression:
        return lambda message: True
    code = compile(expression, "--filter", "eval")
    # the person who types it runs it with her own rights
    return lambda message: bool(eval(code, {}, {"m": message}))  # noqa: S307


def _lost(status: Any) -> None:
    print(
        f"A message was lost!!!\n\ttotal count change:{status.total_count_change}"
        f"\n\ttotal count: {status.total_count}",
        end="---\n",
    )


class Printer:
    """Prints messages as the options of `echo` ask for."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self._options = arguments
        length = None if arguments.full_length else arguments.truncate_length
        self._abridge = Abridge(length, arguments.no_arr, arguments.no_str)
        self._fields = [part for part in (arguments.field or "").split(".") if part]
        if arguments.field is not None and not self._fields:
            raise Ros2Error(f"Invalid field value '{arguments.field}'")
        self._wanted = condition(arguments.filter)
        self.finished = False
        self.problem = ""

    def show(self, message: Any, info: Any) -> None:
        """Print a message, and when it was sent and received if that is given."""
        try:
            if not self.finished:
                self._print(message, info)
        except BrokenPipeError:  # nobody reads any more: rclpy would log it as fatal
            self.finished = True

    def _print(self, message: Any, info: Any) -> None:
        value = message
        for field in self._fields:
            try:
                value = getattr(value, field)
            except AttributeError as error:
                self.problem = f"Invalid field '{'.'.join(self._fields)}': {error}"
                self.finished = True
                return
        if not self._wanted(value):
            return
        self.finished = self._options.once
        if not is_message(value):
            if info is not None:
                print("---Got new message, message info:---", info, "---Message data:---", sep="\n")
            print(value, end="\n---\n")
        elif self._options.csv:
            head = "".join(f"{item}," for item in (info or {}).values())
            print(head + to_csv(value, self._abridge))
        else:
            if info is not None:
                print(dump(dict(sorted(info.items()))), end="---\n")
            print(to_yaml(value, self._abridge, self._options.flow_style), end="---\n")


def service(arguments: argparse.Namespace) -> None:
    """Print what a service's clients and server publish of their calls until interrupted."""
    name = full_name(arguments.service_name)
    length = None if arguments.full_length else arguments.truncate_length
    abridge = Abridge(length, arguments.no_arr, arguments.no_str)
    unread = threading.Event()

    def show(event: Any) -> None:
        kind = _EVENTS[event.info.event_type]
        if arguments.client_only and kind not in _OF_CLIENTS:
            return
        if arguments.server_only and kind in _OF_CLIENTS:
            return
        shown = to_plain(event, abridge)
        shown["info"]["event_type"] = kind
        if arguments.exclude_message_info:
            shown.pop("info")
        text = (
            to_csv(event, abridge) if arguments.csv else dump(shown, arguments.flow_style) + "---"
        )
        try:
            print(text)
        except BrokenPipeError:
            unread.set()

    with Client(arguments) as client:
        given = arguments.service_type
        if given is None:
            services = names_of("service")
            client.discover(lambda: name in dict(services(client.node)))
            given = next(iter(dict(services(client.node)).get(name, ())), "")
            if not given:
                raise Ros2Error(f"Could not determine the type for the passed service: {name}")
        event = interface_class(given, "srv").Event
        client.node.create_subscription(
            event, f"{name}/_service_event", show, qos_profile_services_default
        )
        client.run_until(unread.is_set, required=False)
