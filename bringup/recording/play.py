"""The playing of a recording, until its end or until it is stopped."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from arjuna_core.bags.reader import Bag
from arjuna_core.errors import ArjunaError
from arjuna_core.ros.context import new_context
from bringup.recording.keys import Keys
from bringup.recording.playback import Playback
from bringup.recording.player import Player
from bringup.recording.selection import TopicSelection

_POLL = 0.05  # [s]
_CLOCK = "/clock"


@dataclass(frozen=True)
class PlayOptions:
    """How to play.

    Attributes:
        selection: Which topics.
        rate: Recorded seconds a second.
        offset: Where in the recording to begin [s].
        loop: Whether to begin again at the end.
        paused: Whether to begin with a pause.
        clock_hz: How often to publish the recorded time on /clock [Hz]; 0 for not.
        delay: How long to wait until those who listen have found the player [s].
        remap: New names of topics.
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
    """Play a recording until its end, SIGINT or SIGTERM; space pauses and goes on.

    Args:
        bag: The recording.
        options: How.
        show: Takes lines for the user.

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
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    context = new_context()
    player = Player(context, topics, options.remap, clock_hz > 0.0, show)
    try:
        with Keys() as keys:
            if keys.live:
                show("space pauses and goes on, Ctrl-C ends")
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
    playback: Playback, player: Player, keys: Keys, stop: threading.Event, clock_hz: float
) -> None:
    period = 1.0 / clock_hz if clock_hz > 0.0 else _POLL
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
        if keys.wait(min(playback.wait(), max(tick - time.monotonic(), 0.0), _POLL)) == " ":
            playback.paused = not playback.paused
