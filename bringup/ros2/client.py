"""The client of a running robot as a short-lived node of the `ros2` command."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from rclpy.exceptions import NameValidationException
from rclpy.executors import Executor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden
from rclpy.validate_full_topic_name import validate_full_topic_name

from arjuna_core.ros.context import full_names
from bringup.client.session import POLL, Connection
from bringup.interrupts import check_interrupts
from bringup.ros2.discovery import discover
from bringup.ros2.errors import Ros2Error
from bringup.ros2.verbs.forward import LAUNCHED

_STARTING = 20.0  # [s] in which a node of Python is there on a busy machine
Names = Sequence[tuple[str, Sequence[str]]]
"""Names of the graph, each with its types."""


class Client(Connection):
    """A hidden node that sees the graph; a context manager.

    Args:
        arguments: The command line's, if any; `spin_time` and `use_sim_time` count.
        name: The node's name; a hidden one, as ros2cli's, if None.
        words: Those that ROS reads its arguments from; the program's if None.
    """

    error = Ros2Error

    def __init__(
        self,
        arguments: argparse.Namespace | None = None,
        name: str | None = None,
        executor: type[Executor] = EventsExecutor,
        words: list[str] | None = None,
    ) -> None:
        use_sim_time = bool(getattr(arguments, "use_sim_time", False))
        name = name or f"_ros2cli_{os.getpid()}"
        super().__init__(
            name,
            use_sim_time=use_sim_time,
            executor=executor,
            words=words,
            parameter_services=arguments is None,  # a program's, whose node others look at
        )
        self.node = self.client
        self._limit = getattr(arguments, "spin_time", None)

    def __enter__(self) -> Client:
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        self.close()
        if isinstance(error, NameValidationException):
            raise Ros2Error(str(error)) from error

    def spin_once(self, timeout: float = POLL) -> None:
        """Handle what comes next, within a timeout [s]; an interrupt ends it."""
        super().spin_once(timeout)
        check_interrupts()

    def not_served(self, name: str, timeout: float) -> Exception:
        """Return the error of a service that nobody serves."""
        return Ros2Error(f"Wait for service timed out: {name}")

    def discover(self, found: Callable[[], bool] | None = None) -> bool:
        """Wait until the graph is known, or something is found in it; return whether it was."""
        return discover(self, found, self._limit)

    def nodes(self, hidden: bool = False) -> list[str]:
        """Return the full names of the nodes, sorted, a name that occurs twice twice."""
        return sorted(visible(full_names(self.node), hidden))

    def find_node(self, name: str, hidden: bool = False) -> str:
        """Wait for a node, in a launch file for one that starts; return its full name.

        Raises:
            Ros2Error: There is none.
        """
        full = absolute(name)
        starts = self._limit is None and LAUNCHED in os.environ
        patience = _STARTING if starts else self._limit
        if not discover(self, lambda: full in self.nodes(hidden), patience):
            raise Ros2Error("Node not found")
        return full

    def find_types(
        self, name: str, names_of: Callable[[Any], Names], hidden: bool = True
    ) -> Sequence[str]:
        """Wait for a name of the graph and for all nodes that have it; return its types, or none.

        `names_of` lists the names, of topics or the like, that a node sees.
        """

        def types() -> Sequence[str]:
            return dict(names_of(self.node)).get(name, ())

        if not visible([name], hidden):
            return ()
        if self.discover(lambda: bool(types())):
            self.discover()  # who else has it may give it another type
        return types()


def say_failed(node: str, error: Ros2Error) -> None:
    """Say on the error stream that one of many nodes did not answer."""
    sys.stderr.write(f"Exception while calling service of node '{node}': {error}\n")


def absolute(name: str) -> str:
    """Return a name that starts with a slash."""
    return name if name.startswith("/") else f"/{name}"


def full_name(topic: str) -> str:
    """Return the full name of a topic or action.

    Raises:
        Ros2Error: No topic can have such a name.
    """
    name = absolute(topic)
    try:
        validate_full_topic_name(name)
    except NameValidationException as error:
        raise Ros2Error(str(error)) from error
    return name


def visible(names: Iterable[str], hidden: bool) -> list[str]:
    """Return the names that are not hidden, or all of them."""
    return [name for name in names if hidden or not topic_or_service_is_hidden(name)]


def visible_types(pairs: Names, hidden: bool) -> Names:
    """Return the names and types whose names are not hidden, or all of them."""
    return [pair for pair in pairs if hidden or not topic_or_service_is_hidden(pair[0])]


def print_names(names: Sequence[str], count: bool) -> None:
    """Print a line for each name, or only how many there are."""
    if count:
        print(len(names))
    else:
        print("".join(f"{name}\n" for name in names), end="")


def with_types(pairs: Names, types: bool) -> list[str]:
    """Return the names, their types in brackets if asked for."""
    return [f"{name} [{', '.join(kinds)}]" if types else name for name, kinds in pairs]
