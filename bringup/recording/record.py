"""The recording of topics, until it is stopped."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import nullcontext

from rclpy.node import Node

from arjuna_core.bags.writer import BagFolder
from arjuna_core.ros.context import new_context
from bringup.recording.controls import Controls
from bringup.recording.listener import BARE_NODE
from bringup.recording.recorder import Recorder, RecordOptions
from bringup.terminal import Keys, stopped_by_signals


def control(recorder: Recorder, node: Node, bag: BagFolder, options: RecordOptions) -> Controls:
    """Offer rosbag2's services of a recorder and announce the files that it begins."""
    from rosbag2_interfaces.msg import WriteSplitEvent
    from rosbag2_interfaces.srv import IsPaused, Pause, Resume, Snapshot, SplitBagfile

    def split(_: object) -> None:
        recorder.poll()
        bag.split()

    controls = Controls(node)
    bag.on_split = controls.announcing(WriteSplitEvent, "events/write_split")
    controls.add(Pause, "pause", lambda _: recorder.pause(True))
    controls.add(Resume, "resume", lambda _: recorder.pause(False))
    controls.add(IsPaused, "is_paused", lambda _: {"paused": recorder.paused})
    controls.add(SplitBagfile, "split_bagfile", split)
    if options.snapshot:
        controls.add(Snapshot, "snapshot", lambda _: {"success": recorder.snapshot()})
    return controls


def record(
    bag: BagFolder,
    options: RecordOptions,
    show: Callable[[str], None],
    stop: threading.Event | None = None,
) -> None:
    """Record the chosen topics into a folder until an event is set.

    Args:
        stop: That event; SIGINT and SIGTERM if None.

    Raises:
        RecordingError: The disk refuses.
    """
    stop = stop or stopped_by_signals()
    context = new_context()
    node = Node(
        options.node_name, context=context, **{**BARE_NODE, "enable_rosout": options.controlled}
    )
    recorder = Recorder(node, bag, show, options=options)
    controls = control(recorder, node, bag, options) if options.controlled else None
    for line in _opening(bag, options):
        show(line)
    try:
        with Keys() if options.keys else nullcontext() as keys:
            _run(recorder, options, controls, keys, stop)
    finally:
        recorder.close()
        for line in _CLOSING if options.controlled else ():
            show(line)
        show(_summary(recorder))
        context.shutdown()


_CLOSING = ("Event publisher thread: Exiting", "Recording stopped")


def _opening(bag: BagFolder, options: RecordOptions) -> Iterator[str]:
    """Yield what is said first; rosbag2's sentences, which scripts wait for, where it is its."""
    if not options.controlled:
        yield f"records into {bag.path}; Ctrl-C ends it"
        return
    if options.keys:
        yield "Press SPACE for pausing/resuming"
    yield "Listening for topics..."
    yield "Event publisher thread: Starting"
    yield "Recording..."


def _run(
    recorder: Recorder,
    options: RecordOptions,
    controls: Controls | None,
    keys: Keys | None,
    stop: threading.Event,
    poll_period: float = 0.02,
    flush_period: float = 1.0,
    settling: float = 1.0,
) -> None:
    """Record until stopped; a recorder that is killed loses at most one flush period [s].

    The topics that are there are found within a `settling` time [s].
    """
    start = discover = flush = time.monotonic()
    while not stop.is_set():
        now = time.monotonic()
        if now >= discover and (options.discovery or now < start + settling):
            recorder.discover()
            discover = now + options.polling_period
        recorder.poll()
        if controls is not None:
            controls.poll()
        if now >= flush:
            recorder.flush()
            flush = now + (flush_period if options.cache else 0.0)
        if keys is None:
            stop.wait(poll_period)
        elif keys.wait(poll_period) == " ":
            recorder.pause(not recorder.paused)


def _summary(recorder: Recorder) -> str:
    listener = recorder.listener
    text = f"{recorder.messages} messages of {len(listener.topics)} topics, "
    lost = ", ".join(f"{topic}: {count}" for topic, count in listener.lost.items())
    return text + (f"of those published these were lost: {lost}" if lost else "none lost")
