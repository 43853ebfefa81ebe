"""Factories of a node's publishers, subscriptions, services and clients, local transport."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.topic_endpoint_info import TopicEndpointInfo, TopicEndpointTypeEnum

from arjuna_core.ros.local.services import DeferredService, LocalClient, LocalService
from arjuna_core.ros.local.topics import LocalPublisher, LocalSubscription
from arjuna_core.ros.local.transport import LocalTimer, Registry, TransportError
from arjuna_core.ros.messages import quicken


def _local(method: Callable[..., Any]) -> Callable[..., Any]:
    """Let rclpy's own method run in place of one where the node speaks through the middleware."""

    @functools.wraps(method)
    def run(node: Any, *arguments: Any, **named: Any) -> Any:
        kind = arguments[0] if arguments else named.get("msg_type", named.get("srv_type"))
        if hasattr(kind, "_TYPE_SUPPORT"):
            quicken(kind)
        if node.transport is None:
            return getattr(super(Doors, node), method.__name__)(*arguments, **named)
        return method(node, *arguments, **named)

    return run


class Doors:
    """A mixin that stands before rclpy's Node: with a transport, what the node makes is of it.

    Attributes:
        transport: The process's; None where the node speaks through the middleware. It is set
            before rclpy's `__init__` runs, which makes publishers and services.
        trusted: Whether what the node publishes is valid by its making.
    """

    transport: Any = None
    trusted = False

    @_local
    def create_publisher(
        self, msg_type: Any, topic: str, qos_profile: Any, *options: Any, **named: Any
    ) -> Any:
        """Create a publisher."""
        name = self._full_name(topic)
        made = LocalPublisher(self.transport, self, msg_type, name, _profile(qos_profile))
        self._publishers.append(made)  # type: ignore[attr-defined]
        return made

    @_local
    def create_subscription(
        self,
        msg_type: Any,
        topic: str,
        callback: Callable[[Any], Any],
        qos_profile: Any,
        *options: Any,
        raw: bool = False,
        **named: Any,
    ) -> Any:
        """Create a subscription."""
        name, profile = self._full_name(topic), _profile(qos_profile)
        made = LocalSubscription(self.transport, self, msg_type, name, callback, profile, raw)
        self._subscriptions.append(made)  # type: ignore[attr-defined]
        return made

    @_local
    def create_client(self, srv_type: Any, srv_name: str, *options: Any, **named: Any) -> Any:
        """Create a service's client."""
        name = self._full_name(srv_name, is_service=True)
        made = LocalClient(self.transport, self, srv_type, name)
        self._clients.append(made)  # type: ignore[attr-defined]
        return made

    @_local
    def create_service(
        self, srv_type: Any, srv_name: str, callback: Any, *options: Any, **named: Any
    ) -> Any:
        """Create a service."""
        return self._add_service(LocalService, srv_type, srv_name, callback)

    def create_deferred_service(self, srv_type: Any, srv_name: str, callback: Any) -> Any:
        """Create a service of the local transport that may answer later."""
        quicken(srv_type)
        return self._add_service(DeferredService, srv_type, srv_name, callback)

    def _add_service(
        self, cls: type[LocalService], srv_type: Any, srv_name: str, callback: Any
    ) -> LocalService:
        name = self._full_name(srv_name, is_service=True)
        made = cls(self.transport, self, srv_type, name, callback)
        self._services.append(made)  # type: ignore[attr-defined]
        return made

    @_local
    def create_timer(
        self,
        period: float,
        callback: Callable[[], Any],
        *options: Any,
        clock: Any = None,
        **named: Any,
    ) -> Any:
        """Create a timer; it fires where the process's clock has moved."""
        made = LocalTimer(self.transport, period, callback, clock or self.get_clock())  # type: ignore[attr-defined]
        self._timers.append(made)  # type: ignore[attr-defined]
        return made

    def add_waitable(self, waitable: Any) -> None:
        """Take in an end of an action of rclpy's own, which only the middleware has.

        Raises:
            TransportError: The node is of the local transport.
        """
        if self.transport is not None:
            raise TransportError(
                f"{type(waitable).__name__} goes through the middleware, where nobody answers: "
                "use action_client or GoalServer, or transport='dds'"
            )
        super().add_waitable(waitable)  # type: ignore[misc]

    def _full_name(self, name: str, is_service: bool = False) -> str:
        """Return a name with its namespace; rclpy says what is wrong with one that is not valid."""
        node: Any = self
        resolve = node.resolve_service_name if is_service else node.resolve_topic_name
        try:
            return str(resolve(name))
        except RuntimeError:
            node._validate_topic_or_service_name(name, is_service=is_service)
            raise

    @_local
    def get_topic_names_and_types(self, no_demangle: bool = False) -> list[tuple[str, list[str]]]:
        """Return every topic and its types."""
        return [
            (name, sorted({_type_name(end.msg_type) for end in ends}))
            for name, ends in self.transport.topics()
        ]

    @_local
    def get_service_names_and_types(self) -> list[tuple[str, list[str]]]:
        """Return every service and its types."""
        return [
            (name, sorted({_type_name(each.srv_type) for each in found}))
            for name, found in sorted(self.transport.services.items())
            if found
        ]

    @_local
    def count_publishers(self, topic_name: str) -> int:
        """Return how many publishers a topic has."""
        return len(self.transport.publishers[self._full_name(topic_name)])

    @_local
    def count_subscribers(self, topic_name: str) -> int:
        """Return how many subscriptions a topic has."""
        return len(self.transport.subscriptions[self._full_name(topic_name)])

    @_local
    def get_publishers_info_by_topic(self, topic_name: str, no_mangle: bool = False) -> list[Any]:
        """Return who publishes a topic, and with which QoS."""
        ends = self.transport.publishers[self._full_name(topic_name)]
        return [_info(end, TopicEndpointTypeEnum.PUBLISHER) for end in ends]

    @_local
    def get_publisher_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> list[tuple[str, list[str]]]:
        """Return what a node publishes, with the types."""
        asked = node_name, node_namespace
        found = {
            name: {_type_name(end.msg_type) for end in ends if _owner(end) == asked}
            for name, ends in self.transport.publishers.items()
        }
        return [(name, sorted(types)) for name, types in sorted(found.items()) if types]

    @_local
    def get_subscriptions_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[Any]:
        """Return who listens to a topic, and with which QoS."""
        ends = self.transport.subscriptions[self._full_name(topic_name)]
        return [_info(end, TopicEndpointTypeEnum.SUBSCRIPTION) for end in ends]


class PlainNode(Doors, Node):
    """A plain node of a process, for clients, listeners and tests; options are rclpy's."""

    def __init__(self, transport: Registry | None, name: str, **options: Any) -> None:
        self.transport = transport
        super().__init__(name, **{"enable_rosout": transport is None, **options})


def _profile(profile: Any) -> QoSProfile:
    return QoSProfile(depth=profile) if isinstance(profile, int) else profile


def _type_name(cls: Any) -> str:
    package, kind, *_ = cls.__module__.split(".")
    return f"{package}/{kind}/{cls.__name__}"


def _owner(end: Any) -> tuple[str, str]:
    return end.node.get_name(), end.node.get_namespace()


def _info(end: Any, kind: TopicEndpointTypeEnum) -> TopicEndpointInfo:
    name, namespace = _owner(end)
    return TopicEndpointInfo(
        node_name=name,
        node_namespace=namespace,
        topic_type=_type_name(end.msg_type),
        endpoint_type=kind,
        qos_profile=end.qos_profile,
    )
