"""The recording of a running robot, until it is stopped."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path

from rclpy.node import Node

from arjuna_core.bags.writer import BagFolder, SplitLimits
from arjuna_core.ros.context import new_context
from bringup.recording.recorder import OPTIONS, Recorder
from bringup.recording.selection import TopicSelection

_POLL = 0.02  # [s]
_DISCOVER = 0.5  # [s]
_FLUSH = 1.0  # [s]: what a recorder that is killed loses at most


def record(
    folder: Path, selection: TopicSelection, limits: SplitLimits, show: Callable[[str], None]
) -> None:
    """Record the chosen topics until SIGINT or SIGTERM.

    Args:
        folder: Where to; it must not exist.
        selection: Which topics.
        limits: When to go on in a new file.
        show: Takes lines for the user.

    Raises:
        RecordingError: The folder exists, or the disk refuses.
    """
    bag = BagFolder(folder, limits)
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    context = new_context()
    recorder = Recorder(Node("recorder", context=context, **OPTIONS), bag, show)
    show(f"records into {folder}; Ctrl-C ends it")
    try:
        _run(recorder, selection, stop)
    finally:
        recorder.close()
        context.shutdown()
        show(_summary(recorder))


def _run(recorder: Recorder, selection: TopicSelection, stop: threading.Event) -> None:
    discover = flush = time.monotonic()
    while not stop.is_set():
        now = time.monotonic()
        if now >= discover:
            recorder.listener.discover(selection.takes)
            discover = now + _DISCOVER
        recorder.poll()
        if now >= flush:
            recorder.flush()
            flush = now + _FLUSH
        stop.wait(_POLL)


def _summary(recorder: Recorder) -> str:
    listener = recorder.listener
    text = f"{recorder.messages} messages of {len(listener.topics)} topics, "
    lost = ", ".join(f"{topic}: {count}" for topic, count in listener.lost.items())
    return text + (f"of those published these were lost: {lost}" if lost else "none lost")
