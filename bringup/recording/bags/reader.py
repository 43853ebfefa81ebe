"""Recordings read: an mcap file, a .db3 file, or a rosbag2 folder of either."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import yaml

from arjuna_core.errors import InputFileError
from arjuna_core.files.yaml_file import plain
from bringup.recording.bags.mcap_bag import McapBag
from bringup.recording.bags.metadata import FileEntry
from bringup.recording.bags.sqlite_bag import SqliteBag
from bringup.recording.bags.topic import BagMessage, TopicInfo

_METADATA = "metadata.yaml"
_VALID = "valid: an mcap or .db3 file, or a folder with metadata.yaml or such files"


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
        self.storage, self._bags = _open(path)
        self.topics: dict[str, TopicInfo] = {}
        self.lost: Counter[str] = Counter()
        for bag in self._bags:
            self.topics.update(bag.topics)
            self.lost.update(bag.lost)
        self.files: list[FileEntry] = [bag.entry for bag in self._bags]
        self._missing = _missing_metadata(path)
        self._reading = 0

    @property
    def problems(self) -> list[str]:
        """What it lacks, as far as it has been read."""
        return [*self._missing, *(text for bag in self._bags for text in bag.problems)]

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
                yield from bag.messages(takes, start)


def _open(path: Path) -> tuple[str, Sequence[McapBag | SqliteBag]]:
    if not path.exists():
        raise InputFileError(path, f"does not exist; {_VALID}")
    if path.is_dir():
        files = _listed(path) or sorted([*path.glob("*.mcap"), *path.glob("*.db3")], key=_number)
        if files and all(file.suffix != ".mcap" for file in files):
            whole = (path / _METADATA).exists()
            return "sqlite3", [SqliteBag(file) for file in ([path] if whole else files)]
    else:
        files = [path]
    if not files:
        raise InputFileError(path, f"holds no recording; {_VALID}")
    for file in files:
        if file.suffix not in (".mcap", ".db3") or not file.is_file():
            raise InputFileError(file, f"is no recording; {_VALID}")
    if path.suffix == ".db3":
        return "sqlite3", [SqliteBag(path)]
    return "mcap", [McapBag(file) for file in files]


def _number(file: Path) -> tuple[int, str]:
    """Return what sorts the files of a recording: `run_10.mcap` comes after `run_9.mcap`."""
    digits = file.stem.rpartition("_")[2]
    return (int(digits) if digits.isdecimal() else 0), file.name


def _listed(folder: Path) -> list[Path]:
    """Return the files that a folder's metadata names; none where it has no metadata."""
    metadata = folder / _METADATA
    if not metadata.exists():
        return []
    try:
        text = plain(metadata.read_text(encoding="utf-8"))
        names = text["rosbag2_bagfile_information"]["relative_file_paths"]
        return [folder / Path(name).name for name in names]
    except (OSError, ValueError, KeyError, TypeError, yaml.YAMLError) as error:
        raise InputFileError(metadata, f"is no metadata of rosbag2: {error}") from error


def _missing_metadata(path: Path) -> list[str]:
    if path.is_dir() and not (path / _METADATA).exists():
        return [f"{path.name}: has no {_METADATA}, as if the recorder was killed"]
    return []
