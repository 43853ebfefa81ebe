"""The playing of recordings, until their end or until it is stopped."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

from rclpy.node import Node

from arjuna_core.bags.reader import Bag
from arjuna_core.errors import ArjunaError
from arjuna_core.ros.context import new_context
from arjuna_core.timing import NANOSECONDS
from bringup.recording.controls import Controls
from bringup.recording.listener import BARE_NODE
from bringup.recording.playback import Playback, PlayOptions
from bringup.recording.player import CLOCK, Player
from bringup.terminal import DOWN, RIGHT, UP, Keys, stopped_by_signals


class Playing:
    """Recordings that a player publishes as their messages fall due; `step` it often.

    Attributes:
        on_split: Called with the paths of a file that has been read and of the next one.

    Raises:
        ArjunaError: No topic is left to play, or it begins behind the recording's end.
    """

    def __init__(
        self,
        bags: Sequence[Bag],
        node: Node,
        options: PlayOptions,
        note: Callable[[str], None] = lambda line: None,
    ) -> None:
        self.bags, self.options = bags, options
        self._note = note
        self.on_split: Callable[[Path, Path], None] = lambda closed, opened: None
        known = {name: topic for bag in bags for name, topic in bag.topics.items()}
        recorded = options.recorded_clock and options.takes(CLOCK)
        if options.makes_clock and recorded and any(bag.counts[CLOCK] for bag in bags):
            note("the recording has its own /clock, which is played instead of one of its times")
            options = replace(options, clock_hz=0.0, clock_topics=())

        def takes(topic: str) -> bool:
            return options.takes(topic) and not (options.makes_clock and topic == CLOCK)

        self.playback = Playback(bags, replace(options, takes=takes))
        if self.playback.finished and options.until is None:
            valid = ", ".join(sorted(known)) or "none"
            raise ArjunaError(f"nothing is left to play; the recording's topics: {valid}")
        self.player = Player(node, [t for n, t in known.items() if takes(n)], options, note)
        self._clock_period = 1.0 / options.clock_hz if options.clock_hz > 0.0 else float("inf")
        self._tick = 0.0
        self._stopped = False
        self._files = [bag.current_file for bag in bags]

    @property
    def done(self) -> bool:
        """Return whether all is played; a paused one may seek back."""
        return self._stopped or (self.playback.finished and not self.playback.paused)

    def stop(self) -> None:
        """Play no more."""
        self._stopped = True

    def step(self, wall: float) -> float:
        """Publish what is due at a wall time [s]; return how long to wait for the next [s]."""
        self.playback.advance(wall)
        if self._clock_period < float("inf") and wall >= self._tick:
            self._tick = wall + self._clock_period
            self.player.publish_clock(self.playback.time)
        while not self._stopped and (message := self.playback.due()) is not None:
            self.player.publish(message)
        for number, bag in enumerate(self.bags):
            before, self._files[number] = self._files[number], bag.current_file
            if before != bag.current_file:
                self.on_split(before, bag.current_file)
        return min(self.playback.wait(), self._tick - wall if self._tick else float("inf"))

    def burst(self, count: int) -> int:
        """Publish the next messages of a paused playback, 0 for all; return how many."""
        if self.playback.paused:
            self._note("Playing next message." if count == 1 else f"Burst {count} messages.")
        done = 0
        while not count or done < count:
            message = self.playback.play_next()
            if message is None:
                break
            done += self.player.publish(message)
        return done

    def set_rate(self, rate: float) -> bool:
        """Set the rate; return whether it is one."""
        if rate > 0.0:
            self.playback.rate = rate
            self._note(f"Set rate to {rate:g}")
        return rate > 0.0

    def pause(self, paused: bool) -> None:
        """Pause or resume."""
        self.playback.paused = paused
        self._note("Pausing play." if paused else "Resuming play.")

    def press(self, key: str) -> None:
        """Do what a key means."""
        playback = self.playback
        if key == " ":
            self.pause(not playback.paused)
        elif key == RIGHT:
            self.burst(1)
        elif key in (UP, DOWN):
            self.set_rate(playback.rate * (1.1 if key == UP else 0.9))


def control(playing: Playing, node: Node) -> Controls:
    """Offer rosbag2's services of a player and announce the files that it comes to."""
    from rosbag2_interfaces import srv
    from rosbag2_interfaces.msg import ReadSplitEvent

    def seek(request: Any) -> dict[str, bool]:
        playback.seek(request.time.sec * NANOSECONDS + request.time.nanosec)
        return {"success": True}

    playback = playing.playback
    controls = Controls(node)
    playing.on_split = controls.announcing(ReadSplitEvent, "events/read_split")
    controls.add(srv.Pause, "pause", lambda _: playing.pause(True))
    controls.add(srv.Resume, "resume", lambda _: playing.pause(False))
    controls.add(srv.TogglePaused, "toggle_paused", lambda _: playing.pause(not playback.paused))
    controls.add(srv.IsPaused, "is_paused", lambda _: {"paused": playback.paused})
    controls.add(srv.GetRate, "get_rate", lambda _: {"rate": playback.rate})
    controls.add(srv.SetRate, "set_rate", lambda each: {"success": playing.set_rate(each.rate)})
    controls.add(srv.PlayNext, "play_next", lambda _: {"success": bool(playing.burst(1))})
    controls.add(
        srv.Burst, "burst", lambda each: {"actually_burst": playing.burst(each.num_messages)}
    )
    controls.add(srv.Seek, "seek", seek)
    controls.add(srv.Stop, "stop", lambda _: playing.stop())
    controls.add(srv.Play, "play", lambda _: {"success": False})  # it plays already
    return controls


_KEYS = (
    "Adding keyboard callbacks.",
    "Press SPACE for Pause/Resume",
    "Press CURSOR_RIGHT for Play Next Message",
    "Press CURSOR_UP for Increase Rate 10%",
    "Press CURSOR_DOWN for Decrease Rate 10%",
)


def _opening(options: PlayOptions, live: bool) -> Iterator[str]:
    """Yield what is said first; rosbag2's sentences, which scripts wait for, where it is its."""
    if options.controlled:
        yield f"Set rate to {options.rate:g}"
    if live or (options.controlled and options.keys):
        yield from _KEYS
    if options.controlled and options.delay:
        yield f"Sleep {round(options.delay * NANOSECONDS)} ns"
    if options.controlled:
        yield f"Playback until timestamp: {-1 if options.until is None else options.until}"


def play(
    bags: Sequence[Bag],
    options: PlayOptions,
    show: Callable[[str], None],
    stop: threading.Event | None = None,
    poll: float = 0.05,
) -> None:
    """Play recordings until their end, or until an event is set.

    Args:
        stop: That event; SIGINT and SIGTERM if None.
        poll: From one look at keys and signals to the next, at most [s].

    Raises:
        ArjunaError: No topic is left to play, or it begins behind the recording's end.
    """
    stop = stop or stopped_by_signals()
    context = new_context(words=[])  # the command line's `--remap` is for the recording's topics
    bare = {**BARE_NODE, "enable_rosout": options.controlled}
    node = Node(options.node_name, context=context, **bare)
    try:
        playing = Playing(bags, node, options, show)
        controls = control(playing, node) if options.controlled else None
        with Keys() if options.keys else nullcontext() as keys:
            for line in _opening(options, keys is not None and keys.live):
                show(line)
            if options.burst is not None:
                playing.burst(options.burst)
            while not stop.is_set() and not playing.done:
                pause = min(playing.step(time.monotonic()), poll)
                if controls is not None:
                    controls.poll()
                if keys is None:
                    stop.wait(pause)
                else:
                    playing.press(keys.wait(pause))
        if options.acked_timeout is not None:
            playing.player.wait_for_acknowledgement(options.acked_timeout)
        show(f"{playing.player.published} messages played")
        for line in (problem for bag in bags for problem in bag.problems):
            show(f"note: {line}")
    finally:
        node.destroy_node()
        context.shutdown()
