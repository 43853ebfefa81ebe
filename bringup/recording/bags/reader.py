"""Recordings read: an mcap file, a .db3 file, or a rosbag2 folder of either."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

from arjuna_core.files.rosbag2 import RecordingFiles
from bringup.recording.bags.mcap_bag import McapBag
from bringup.recording.bags.metadata import FileEntry
from bringup.recording.bags.sqlite_bag import SqliteBag
from bringup.recording.bags.topic import BagMessage, TopicInfo

_KINDS: dict[str, tuple[str, type[McapBag | SqliteBag]]] = {
    ".mcap": ("mcap", McapBag),
    ".db3": ("sqlite3", SqliteBag),
}


class Bag:
    """A recording.

    Args:
        path: A file or folder.

    Attributes:
        path: The file or folder.
        storage: `mcap` or `sqlite3`.
        topics: Its topics by name.
        files: Each file's name, times and counts.
        lost: How many messages of a topic never reached the recorder.

    Raises:
        InputFileError: It is no recording.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._recording = RecordingFiles(path, tuple(_KINDS))
        files = self._recording.files
        self.storage = _KINDS[files[0].suffix][0]
        self._bags = [_KINDS[file.suffix][1](file) for file in files]
        self.topics: dict[str, TopicInfo] = {}
        self.lost: Counter[str] = Counter()
        for bag in self._bags:
            self.topics.update(bag.topics)
            self.lost.update(bag.lost)
        self.files: list[FileEntry] = [bag.entry for bag in self._bags]
        self._reading = 0

    @property
    def problems(self) -> list[str]:
        """What it lacks, as far as it has been read."""
        missing = "has no metadata.yaml, as if the recorder was killed"
        bare = self.path.is_dir() and not self._recording.described
        said = [f"{self.path.name}: {missing}"] if bare else []
        return [*said, *(text for bag in self._bags for text in bag.problems)]

    @property
    def counts(self) -> Counter[str]:
        """How many messages of each topic it holds."""
        return sum((file.counts for file in self.files), Counter[str]())

    @property
    def start(self) -> int:
        """When the first message was received [ns]."""
        return min((file.start for file in self.files if file.counts), default=0)

    @property
    def end(self) -> int:
        """When the last message was received [ns]."""
        return max((file.end for file in self.files if file.counts), default=0)

    @property
    def share(self) -> float:
        """Share (0..1) that has been read."""
        return (self._reading + self._bags[self._reading].share) / len(self._bags)

    @property
    def sizes(self) -> list[int]:
        """Size of each mcap file [bytes]."""
        return [bag.path.stat().st_size for bag in self._bags]

    def messages(
        self, takes: Callable[[str], bool] = lambda topic: True, start: int = 0
    ) -> Iterator[BagMessage]:
        """Yield its messages in the order of their time, those of a file after the last one's.

        Args:
            takes: Tells which topics.
            start: From when on [ns].
        """
        for number, bag in enumerate(self._bags):
            self._reading = number
            if bag.entry.end >= start:
                yield from self._unpacked(bag, takes, start)

    def _unpacked(
        self, bag: McapBag | SqliteBag, takes: Callable[[str], bool], start: int
    ) -> Iterator[BagMessage]:
        for message in bag.messages(takes, start):
            try:
                data = self._recording.message(message.data)
            except ValueError as error:
                problem = f"{bag.path.name}: {message.topic.name}: {error}"
                if problem not in bag.problems:
                    bag.problems.append(problem)
            else:
                yield message._replace(data=data)
