"""How a node gets its publishers, subscriptions, services and clients of the local transport."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.topic_endpoint_info import TopicEndpointInfo, TopicEndpointTypeEnum

from arjuna_core.ros.local.services import DeferredService, LocalClient, LocalService
from arjuna_core.ros.local.topics import LocalPublisher, LocalSubscription
from arjuna_core.ros.local.transport import LocalTimer, Registry, TransportError
from arjuna_core.ros.messages import quicken


class Doors:
    """A mixin that stands before rclpy's Node: with a transport, what the node makes is of it.

    Attributes:
        transport: The process's; None where the node speaks through the middleware. It is set
            before rclpy's `__init__` runs, which makes publishers and services.
        trusted: Whether what the node publishes is valid by its making.
    """

    transport: Registry | None = None
    trusted = False

    def create_publisher(
        self, msg_type: Any, topic: str, qos_profile: Any, *options: Any, **named: Any
    ) -> Any:
        """Create a publisher."""
        quicken(msg_type)
        if self.transport is None:
            return super().create_publisher(msg_type, topic, qos_profile, *options, **named)  # type: ignore[misc]
        name = self._full_name(topic)
        made = LocalPublisher(self.transport, self, msg_type, name, _profile(qos_profile))
        self._publishers.append(made)  # type: ignore[attr-defined]
        return made

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
        quicken(msg_type)
        if self.transport is None:
            return super().create_subscription(  # type: ignore[misc]
                msg_type, topic, callback, qos_profile, *options, raw=raw, **named
            )
        name, profile = self._full_name(topic), _profile(qos_profile)
        made = LocalSubscription(self.transport, self, msg_type, name, callback, profile, raw)
        self._subscriptions.append(made)  # type: ignore[attr-defined]
        return made

    def create_client(self, srv_type: Any, srv_name: str, *options: Any, **named: Any) -> Any:
        """Create a service's client."""
        quicken(srv_type.Request, srv_type.Response)
        if self.transport is None:
            return super().create_client(srv_type, srv_name, *options, **named)  # type: ignore[misc]
        name = self._full_name(srv_name, is_service=True)
        made = LocalClient(self.transport, self, srv_type, name)
        self._clients.append(made)  # type: ignore[attr-defined]
        return made

    def create_service(
        self, srv_type: Any, srv_name: str, callback: Any, *options: Any, **named: Any
    ) -> Any:
        """Create a service."""
        quicken(srv_type.Request, srv_type.Response)
        if self.transport is None:
            return super().create_service(srv_type, srv_name, callback, *options, **named)  # type: ignore[misc]
        return self._add_service(LocalService, srv_type, srv_name, callback)

    def create_deferred_service(self, srv_type: Any, srv_name: str, callback: Any) -> Any:
        """Create a service of the local transport that may answer later."""
        quicken(srv_type.Request, srv_type.Response)
        return self._add_service(DeferredService, srv_type, srv_name, callback)

    def adopt(self, service: Any) -> None:
        """Serve by the transport what rclpy made of the middleware, where nobody asks."""
        if self.transport is not None:
            name = service.service_name
            self._add_service(LocalService, service.srv_type, name, service.callback)

    def _add_service(
        self, cls: type[LocalService], srv_type: Any, srv_name: str, callback: Any
    ) -> LocalService:
        assert self.transport is not None
        name = self._full_name(srv_name, is_service=True)
        made = cls(self.transport, self, srv_type, name, callback)
        self._services.append(made)  # type: ignore[attr-defined]
        return made

    def create_timer(
        self,
        period: float,
        callback: Callable[[], Any],
        *options: Any,
        clock: Any = None,
        **named: Any,
    ) -> Any:
        """Create a timer; it fires where the process's clock has moved."""
        if self.transport is None:
            return super().create_timer(period, callback, *options, clock=clock, **named)  # type: ignore[misc]
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

    def get_topic_names_and_types(self, no_demangle: bool = False) -> list[tuple[str, list[str]]]:
        """Return every topic and its types."""
        if self.transport is None:
            return super().get_topic_names_and_types(no_demangle)  # type: ignore[misc,no-any-return]
        return [
            (name, sorted({_type_name(end.msg_type) for end in ends}))
            for name, ends in self.transport.topics()
        ]

    def get_service_names_and_types(self) -> list[tuple[str, list[str]]]:
        """Return every service and its types."""
        if self.transport is None:
            return super().get_service_names_and_types()  # type: ignore[misc,no-any-return]
        return [
            (name, sorted({_type_name(each.srv_type) for each in found}))
            for name, found in sorted(self.transport.services.items())
            if found
        ]

    def count_publishers(self, topic_name: str) -> int:
        """Return how many publishers a topic has."""
        if self.transport is None:
            return super().count_publishers(topic_name)  # type: ignore[misc,no-any-return]
        return len(self.transport.publishers[self._full_name(topic_name)])

    def count_subscribers(self, topic_name: str) -> int:
        """Return how many subscriptions a topic has."""
        if self.transport is None:
            return super().count_subscribers(topic_name)  # type: ignore[misc,no-any-return]
        return len(self.transport.subscriptions[self._full_name(topic_name)])

    def get_publishers_info_by_topic(self, topic_name: str, no_mangle: bool = False) -> list[Any]:
        """Return who publishes a topic, and with which QoS."""
        if self.transport is None:
            return super().get_publishers_info_by_topic(topic_name, no_mangle)  # type: ignore[misc,no-any-return]
        ends = self.transport.publishers[self._full_name(topic_name)]
        return [_info(end, TopicEndpointTypeEnum.PUBLISHER) for end in ends]

    def get_subscriptions_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[Any]:
        """Return who listens to a topic, and with which QoS."""
        if self.transport is None:
            return super().get_subscriptions_info_by_topic(topic_name, no_mangle)  # type: ignore[misc,no-any-return]
        ends = self.transport.subscriptions[self._full_name(topic_name)]
        return [_info(end, TopicEndpointTypeEnum.SUBSCRIPTION) for end in ends]


class PlainNode(Doors, Node):
    """A plain node of a process, for clients, listeners and tests.

    Args:
        transport: The process's; None for the middleware.
        name: The node's name.
        options: As rclpy's Node takes them.
    """

    def __init__(self, transport: Registry | None, name: str, **options: Any) -> None:
        self.transport = transport
        super().__init__(name, **options)


def _profile(profile: Any) -> QoSProfile:
    return QoSProfile(depth=profile) if isinstance(profile, int) else profile


def _type_name(cls: Any) -> str:
    package, kind, *_ = cls.__module__.split(".")
    return f"{package}/{kind}/{cls.__name__}"


def _info(end: Any, kind: TopicEndpointTypeEnum) -> TopicEndpointInfo:
    return TopicEndpointInfo(
        node_name=end.node.get_name(),
        node_namespace=end.node.get_namespace(),
        topic_type=_type_name(end.msg_type),
        endpoint_type=kind,
        qos_profile=end.qos_profile,
    )
