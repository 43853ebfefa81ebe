"""A running robot in rerun."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path

import rclpy
from rclpy.context import Context
from rclpy.node import Node

from arjuna_core.ros.ament import add_environment_to_ament_index
from bringup.recording.bags.topic import TopicInfo
from bringup.recording.listener import TopicListener
from bringup.viewing.drawing.looks import FindMesh
from bringup.viewing.rerun.output import Output
from bringup.viewing.rerun.scene import Scene
from bringup.viewing.rerun.stream import Stream

_POLL = 0.05  # [s]
_DISCOVER = 0.5  # [s]


def watch(save: Path | None, web: bool, find_mesh: FindMesh, show: Callable[[str], None]) -> None:
    """Show what the robot says until the viewer is closed, SIGINT or SIGTERM.

    Args:
        save: A file of rerun's to write instead.
        web: Whether to show it in a browser.
        find_mesh: Finds the robot's meshes.
        show: Takes lines for the user.

    Raises:
        OutputError: There is nowhere to show it.
    """
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    add_environment_to_ament_index()
    with Output(save, web, show) as output:
        stream = Stream(output.recording, _POLL)
        scene = Scene(stream, find_mesh)
        context = Context()
        rclpy.init(context=context)
        node = Node("viewer", context=context, start_parameter_services=False, enable_rosout=False)
        try:
            _run(TopicListener(node), scene, stream, lambda: stop.is_set() or not output.open, stop)
        finally:
            node.destroy_node()
            context.shutdown()
        for note in scene.notes:
            show(f"note: {note}")


def _run(
    listener: TopicListener,
    scene: Scene,
    stream: Stream,
    done: Callable[[], bool],
    pause: threading.Event,
) -> None:
    discover = 0.0
    while not done():
        now = time.monotonic()
        if now >= discover:
            listener.discover(lambda name: True, lambda kind: scene.shows(TopicInfo("", kind)))
            discover = now + _DISCOVER
        for heard in listener.take():
            scene.take(heard.topic, heard.received, heard.data)
        stream.flush()
        pause.wait(_POLL)
