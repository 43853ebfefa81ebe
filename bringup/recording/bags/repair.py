"""A mended copy of a recording that was cut short or is damaged."""

from __future__ import annotations

from pathlib import Path

from bringup.recording.bags.reader import Bag
from bringup.recording.bags.writer import BagFolder


def repair(bag: Bag, folder: Path) -> int:
    """Write what can be read of a recording into a new folder, with index and metadata.

    Args:
        bag: The recording; it stays as it is.
        folder: Where to; it must not exist.

    Returns:
        How many messages there are.

    Raises:
        RecordingError: The folder exists, or the disk refuses.
    """
    copy = BagFolder(folder)
    for message in bag.messages():
        copy.write(message.topic, message.time, message.data, message.time)
    copy.close(dict(bag.lost))
    return sum(file.messages for file in copy.files)
