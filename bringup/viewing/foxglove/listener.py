"""What Foxglove's clients ask for, handed from the server's threads to the one that runs ROS."""

from __future__ import annotations

import queue
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from concurrent.futures import TimeoutError as TimedOut
from dataclasses import dataclass, field
from typing import Any

from foxglove.websocket import ChannelView, Client, ClientChannel, Parameter, ServerListener

_PARAMETERS_DEADLINE = 5.0


@dataclass(frozen=True)
class Subscribed:
    """A client wants a topic's messages."""

    topic: str


@dataclass(frozen=True)
class Unsubscribed:
    """A client no longer wants a topic's messages."""

    topic: str


@dataclass(frozen=True)
class Advertised:
    """A client is going to publish.

    Attributes:
        key: Names the client's channel.
        topic: Where to.
        type_name: The messages' type, `package/msg/Name`.
        encoding: The messages' encoding.
    """

    key: tuple[int, int]
    topic: str
    type_name: str
    encoding: str


@dataclass(frozen=True)
class Unadvertised:
    """A client has published its last on a channel."""

    key: tuple[int, int]


@dataclass(frozen=True)
class Published:
    """A client publishes a serialized message."""

    key: tuple[int, int]
    data: bytes


@dataclass(frozen=True)
class ParametersWanted:
    """A client wants parameters, all where it names none, perhaps after setting them.

    Attributes:
        names: `/node.parameter`.
        values: What to set before, by name.
        answer: Takes the values, by name.
    """

    names: tuple[str, ...]
    values: dict[str, Any]
    answer: Future[dict[str, Any]] = field(default_factory=Future)


Event = Subscribed | Unsubscribed | Advertised | Unadvertised | Published | ParametersWanted


class Listener(ServerListener):
    """Puts everything into a queue; only questions for parameters wait for their answer.

    Args:
        events: The queue.
    """

    def __init__(self, events: queue.SimpleQueue[Event]) -> None:
        self._put: Callable[[Event], None] = events.put

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        """Hand over a subscription."""
        self._put(Subscribed(channel.topic))

    def on_unsubscribe(self, client: Client, channel: ChannelView) -> None:
        """Hand over its end."""
        self._put(Unsubscribed(channel.topic))

    def on_client_advertise(self, client: Client, channel: ClientChannel) -> None:
        """Hand over an advertisement."""
        key = (client.id, channel.id)
        self._put(Advertised(key, channel.topic, channel.schema_name, channel.encoding))

    def on_client_unadvertise(self, client: Client, client_channel_id: int) -> None:
        """Hand over its end."""
        self._put(Unadvertised((client.id, client_channel_id)))

    def on_message_data(self, client: Client, client_channel_id: int, data: bytes) -> None:
        """Hand over a message."""
        self._put(Published((client.id, client_channel_id), data))

    def on_get_parameters(
        self, client: Client, param_names: list[str], request_id: str | None = None
    ) -> list[Parameter]:
        """Return parameters' values; those that do not come in time are left out."""
        return self._ask(ParametersWanted(tuple(param_names), {}))

    def on_set_parameters(
        self, client: Client, parameters: list[Parameter], request_id: str | None = None
    ) -> list[Parameter]:
        """Set parameters; return what their nodes have made of them."""
        values = {item.name: item.get_value() for item in parameters}
        return self._ask(ParametersWanted(tuple(values), values))

    def _ask(self, wanted: ParametersWanted) -> list[Parameter]:
        self._put(wanted)
        try:
            found = wanted.answer.result(timeout=_PARAMETERS_DEADLINE)
        except TimedOut:
            return []
        return [Parameter(name, value=_native(value)) for name, value in found.items()]


def _native(value: Any) -> Any:
    """Return a parameter's value as Foxglove takes it."""
    return (
        list(value) if isinstance(value, Sequence) and not isinstance(value, str | bytes) else value
    )
