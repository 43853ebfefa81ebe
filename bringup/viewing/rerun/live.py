"""A running robot in rerun."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path

from rclpy.node import Node

from arjuna_core.ros.context import new_context
from bringup.recording.bags.topic import TopicInfo
from bringup.recording.listener import TopicListener
from bringup.viewing.drawing.looks import FindMesh
from bringup.viewing.rerun.output import Output
from bringup.viewing.rerun.scene import Scene
from bringup.viewing.rerun.stream import Stream

_POLL = 0.05  # [s]
_DISCOVER = 0.5  # [s]


def watch(
    save: Path | None,
    web: bool,
    find_mesh: FindMesh,
    show: Callable[[str], None],
    stopped: Callable[[], bool],
) -> None:
    """Show what the robot says until it is stopped or the viewer is closed.

    Args:
        save: A file of rerun's to write instead.
        web: Whether to show it in a browser.
        find_mesh: Finds the robot's meshes.
        show: Takes lines for the user.
        stopped: Tells whether to end.

    Raises:
        OutputError: There is nowhere to show it.
    """
    with Output(save, web, show) as output:
        stream = Stream(output.recording, _POLL)
        scene = Scene(stream, find_mesh)
        context = new_context()
        node = Node("viewer", context=context, start_parameter_services=False, enable_rosout=False)
        try:
            _run(TopicListener(node), scene, stream, lambda: stopped() or not output.open)
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
) -> None:
    pause, discover = threading.Event(), 0.0
    while not done():
        now = time.monotonic()
        if now >= discover:
            listener.discover(lambda name: True, lambda kind: scene.shows(TopicInfo("", kind)))
            discover = now + _DISCOVER
        for heard in listener.take():
            scene.take(heard.topic, heard.received, heard.data)
        stream.flush()
        pause.wait(_POLL)
