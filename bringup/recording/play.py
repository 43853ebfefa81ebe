"""The playing of a recording, until its end or until it is stopped."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from rclpy.context import Context
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import BagMessage, TopicInfo, offer_for
from arjuna_core.errors import ArjunaError
from arjuna_core.ros import qos
from arjuna_core.ros.context import class_of, new_context
from arjuna_core.timing import NANOSECONDS
from bringup.recording.listener import BARE_NODE, profile_of
from bringup.recording.playback import Playback
from bringup.recording.selection import TopicSelection
from bringup.terminal import Keys, stopped_by_signals

_CLOCK = "/clock"


class Player:
    """Publishers for the topics of a recording.

    Args:
        remap: New names of topics.
        clock: Whether it publishes `/clock` too.
        note: Takes a line about a topic that cannot be played.
    """

    def __init__(
        self,
        context: Context,
        topics: Iterable[TopicInfo],
        remap: Mapping[str, str],
        clock: bool = False,
        note: Callable[[str], None] = lambda line: None,
    ) -> None:
        self._node = Node("player", context=context, **BARE_NODE)
        self._publishers: dict[str, Any] = {}
        for topic in topics:
            self._publish(topic, remap.get(topic.name, topic.name), note)
        self._clock = self._node.create_publisher(Clock, "/clock", qos.LATEST) if clock else None
        self.published = 0

    def _publish(
        self, topic: TopicInfo, name: str, note: Callable[[str], None], static_publishers: int = 100
    ) -> None:
        """Advertise a topic; that of /tf_static latches a message of each of many publishers."""
        if topic.encoding != "cdr":
            note(f"{topic.name} is left out: it is encoded as '{topic.encoding}', not as cdr")
            return
        try:
            message_type = class_of(topic.type_name)
        except LookupError:
            note(f"{topic.name} is left out: its type {topic.type_name} is not installed")
            return
        offer = offer_for(
            topic.offers, static_publishers if topic.name.endswith("tf_static") else 1
        )
        publisher = self._node.create_publisher(message_type, name, profile_of(offer))
        self._publishers[topic.name] = publisher

    def publish(self, message: BagMessage) -> None:
        """Publish a message, unless its topic cannot be played."""
        publisher = self._publishers.get(message.topic.name)
        if publisher is not None:
            publisher.publish(bytes(message.data))
            self.published += 1

    def publish_clock(self, time: int) -> None:
        """Publish a time [ns] on `/clock`, where that was asked for."""
        if self._clock is not None:
            message = Clock()
            message.clock.sec, message.clock.nanosec = divmod(time, NANOSECONDS)
            self._clock.publish(message)

    def close(self) -> None:
        """Leave the graph."""
        self._node.destroy_node()


@dataclass(frozen=True)
class PlayOptions:
    """Options of playing.

    Attributes:
        rate: Recorded seconds a second.
        offset: Where in the recording to begin [s].
        paused: Whether to begin with a pause.
        clock_hz: How often to publish the recorded time on /clock [Hz]; 0 for not.
        delay: How long to wait until those who listen have found the player [s].
    """

    selection: TopicSelection = field(default_factory=TopicSelection)
    rate: float = 1.0
    offset: float = 0.0
    loop: bool = False
    paused: bool = False
    clock_hz: float = 0.0
    delay: float = 1.0
    remap: Mapping[str, str] = field(default_factory=dict)


def play(bag: Bag, options: PlayOptions, show: Callable[[str], None]) -> None:
    """Play a recording until its end, SIGINT or SIGTERM; space pauses and resumes.

    Raises:
        ArjunaError: No topic is left to play, or it begins behind the recording's end.
    """
    topics = [each for each in bag.topics.values() if options.selection.takes(each.name)]
    playback = Playback(bag, options.selection.takes, options.rate, options.offset, options.loop)
    if playback.finished:
        valid = ", ".join(sorted(bag.topics)) or "none"
        raise ArjunaError(f"nothing is left to play; the recording's topics: {valid}")
    clock_hz = options.clock_hz
    if clock_hz > 0.0 and bag.counts[_CLOCK] and options.selection.takes(_CLOCK):
        show("the recording has its own /clock, which is played instead of one made of its times")
        clock_hz = 0.0
    stop = stopped_by_signals()
    context = new_context()
    player = Player(context, topics, options.remap, clock_hz > 0.0, show)
    try:
        with Keys() as keys:
            if keys.live:
                show("space pauses and resumes, Ctrl-C ends")
            stop.wait(options.delay)
            playback.paused = options.paused
            _run(playback, player, keys, stop, clock_hz)
        show(f"{player.published} messages played")
        for line in bag.problems:
            show(f"note: {line}")
    finally:
        player.close()
        context.shutdown()


def _run(
    playback: Playback,
    player: Player,
    keys: Keys,
    stop: threading.Event,
    clock_hz: float,
    poll: float = 0.05,
) -> None:
    """Play until the end or a signal; keys and signals are looked at once a `poll` [s]."""
    period = 1.0 / clock_hz if clock_hz > 0.0 else poll
    tick = 0.0
    while not stop.is_set() and not playback.finished:
        now = time.monotonic()
        playback.advance(now)
        if now >= tick:
            tick = now + period
            if not playback.paused:
                player.publish_clock(playback.time)
        while (message := playback.due()) is not None:
            player.publish(message)
        if keys.wait(min(playback.wait(), max(tick - time.monotonic(), 0.0), poll)) == " ":
            playback.paused = not playback.paused
