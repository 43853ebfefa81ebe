"""A recording, or a running robot, in rerun."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path

from arjuna_core.bags.reader import Bag
from arjuna_core.errors import InputFileError
from bringup.viewing.drawing.visual_model import FindMesh
from bringup.viewing.rerun.output import Output
from bringup.viewing.rerun.scene import Scene
from bringup.viewing.rerun.stream import Stream


def replay(
    bag: Bag, save: Path | None, web: bool, find_mesh: FindMesh, show: Callable[[str], None]
) -> None:
    """Show a recording, or write it to a file of rerun's.

    Args:
        save: The file; None to show it, until the viewer is closed.

    Raises:
        InputFileError: It holds nothing that can be shown.
        OutputError: There is nowhere to show it.
    """
    with Output(save, web, show) as output:
        stream = Stream(output.recording, patience=5.0)
        scene = Scene(stream, find_mesh)
        names = {name for name, topic in bag.topics.items() if scene.shows(topic.type_name)}
        if not names:
            valid = ", ".join(sorted(bag.topics)) or "none"
            raise InputFileError(bag.path, f"holds nothing that can be shown; its topics: {valid}")
        for message in bag.messages(names.__contains__):
            scene.take(message.topic, message.time, message.data)
            if not output.open:
                break
        stream.flush()
        for note in [*scene.notes, *bag.problems]:
            show(f"note: {note}")
        hidden = ", ".join(sorted(set(bag.topics) - scene.topics)) or "none"
        show(f"{stream.now:.1f} s, {len(scene.topics)} topics shown; not shown: {hidden}")
        output.wait()


def watch(
    save: Path | None,
    web: bool,
    find_mesh: FindMesh,
    show: Callable[[str], None],
    stopped: Callable[[], bool],
) -> None:
    """Show the running robot until it is stopped or the viewer is closed.

    Args:
        save: A file of rerun's to write instead.
        stopped: Returns whether to end.

    Raises:
        OutputError: There is nowhere to show it.
    """
    from rclpy.node import Node

    from arjuna_core.ros.context import new_context
    from bringup.recording.listener import TopicListener

    poll, discover = 0.05, 0.5  # [s]
    with Output(save, web, show) as output:
        stream = Stream(output.recording, poll)
        scene = Scene(stream, find_mesh)
        context = new_context()
        node = Node("viewer", context=context, start_parameter_services=False, enable_rosout=False)
        listener, pause, due = TopicListener(node), threading.Event(), 0.0
        try:
            while not stopped() and output.open:
                now = time.monotonic()
                if now >= due:
                    listener.discover(lambda name, kind: scene.shows(kind))
                    due = now + discover
                for message in listener.take():
                    scene.take(message.topic, message.received, message.data)
                stream.flush()
                pause.wait(poll)
        finally:
            node.destroy_node()
            context.shutdown()
        for note in scene.notes:
            show(f"note: {note}")
