"""A recording in rerun."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from arjuna_core.errors import InputFileError
from bringup.recording.bags.reader import Bag
from bringup.viewing.drawing.looks import FindMesh
from bringup.viewing.rerun.output import Output
from bringup.viewing.rerun.scene import Scene
from bringup.viewing.rerun.stream import Stream

_PATIENCE = 5.0  # [s] of the recording


def replay(
    bag: Bag, save: Path | None, web: bool, find_mesh: FindMesh, show: Callable[[str], None]
) -> None:
    """Show a recording, or write it to a file of rerun's.

    Args:
        bag: The recording.
        save: The file; None to show it, until the viewer is closed.
        web: Whether to show it in a browser.
        find_mesh: Finds the robot's meshes.
        show: Takes lines for the user.

    Raises:
        InputFileError: It holds nothing that can be shown.
        OutputError: There is nowhere to show it.
    """
    with Output(save, web, show) as output:
        stream = Stream(output.recording, _PATIENCE)
        scene = Scene(stream, find_mesh)
        names = {name for name, topic in bag.topics.items() if scene.shows(topic)}
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
        left = ", ".join(sorted(set(bag.topics) - scene.topics)) or "none"
        show(f"{stream.now:.1f} s, {len(scene.topics)} topics shown; not shown: {left}")
        output.wait()
