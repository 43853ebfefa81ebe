"""Every reader of files, with a file to start from, and changes of its bytes at random."""

from __future__ import annotations

import hashlib
import re
import time
import traceback
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import yaml

from arjuna_core.bags.reader import Bag
from arjuna_core.errors import ArjunaError, InputFileError, MapError
from arjuna_core.files.map_image import MapOptions
from arjuna_core.files.maps import load_map, save_map
from arjuna_core.files.shipped import shipped_file
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_nav.planners.hybrid import primitives
from arjuna_nav.routes.graph import read_graph
from arjuna_slam.logs.log import open_log
from arjuna_slam.logs.recording import RecordingTopics
from arjuna_slam.mapping.session import SessionFileError, load_session
from bringup.client.waypoints import load_waypoints
from bringup.parameters.files import load_parameters
from tests.core.bags.recordings import (
    ODOMETRY,
    SCAN,
    TF,
    odometry_bytes,
    scan_bytes,
    transform_bytes,
    write,
    write_humble,
    write_ros1,
)
from tests.helpers.nav import lattices, routes

WORDS = (
    *("nan", "inf", "-1", "0", "1e9", "1e308", "-1e-308", "1000000000", "", "../../../etc/passwd"),
    *("__model__", "base", "true", "%s", "1 2", "\N{SNOWMAN}", "package://", "0x10", "--", "]]>"),
)
NUMBER = re.compile(rb"-?\d+(\.\d+)?(e-?\d+)?")
TAG = re.compile(rb"<(\w+)[^<>]*/>|<(\w+)[^<>]*>[^<]*</\2>")


def _flip(text: bytes, rng: np.random.Generator) -> bytes:
    changed = bytearray(text)
    for index in rng.integers(len(text), size=rng.integers(1, 6)):
        changed[index] = rng.integers(256)
    return bytes(changed)


def _cut(text: bytes, rng: np.random.Generator) -> bytes:
    first, last = np.sort(rng.integers(len(text) + 1, size=2))
    return text[:last] if rng.random() < 0.5 else text[:first] + text[last:]


def _replace(pattern: re.Pattern[bytes], text: bytes, rng: np.random.Generator) -> bytes:
    found = list(pattern.finditer(text))
    if not found:
        return _flip(text, rng)
    hit = found[rng.integers(len(found))]
    if pattern is NUMBER:
        new = WORDS[rng.integers(len(WORDS))].encode()
    else:
        new = b"" if rng.random() < 0.5 else found[rng.integers(len(found))].group() * 2
    return text[: hit.start()] + new + text[hit.end() :]


def _number(text: bytes, rng: np.random.Generator) -> bytes:
    return _replace(NUMBER, text, rng)


def _tag(text: bytes, rng: np.random.Generator) -> bytes:
    return _replace(TAG, text, rng)


MUTATIONS: tuple[Callable[[bytes, np.random.Generator], bytes], ...] = (
    *(_flip, _cut, _number, _number, _number, _tag, _tag),
)


def mutated(text: bytes, rng: np.random.Generator, most: int = 3) -> bytes:
    """Return a text after a few changes."""
    for _ in range(int(rng.integers(1, most + 1))):
        text = MUTATIONS[int(rng.integers(len(MUTATIONS)))](text or b" ", rng)
    return text


SLOW = 2.0
"""How long a file of some kilobytes may take a core [s]."""
_DIGEST = hashlib.sha256().digest_size


@dataclass(frozen=True)
class Reader:
    """A reader of one kind of file.

    Attributes:
        name: What it reads.
        read: Reads a file to its end.
        error: The one error that it may raise.
        make: Writes a good file into a folder and returns it; what is changed.
        mend: Makes good what only says that a file was changed, such as a checksum.
    """

    name: str
    read: Callable[[Path], object]
    error: type[ArjunaError]
    make: Callable[[Path], Path]
    mend: Callable[[bytes], bytes] = field(default=lambda data: data)


def _map(folder: Path, image_format: str = "pgm", mode: str = "trinary") -> Path:
    rng = np.random.default_rng(0)
    data = rng.choice(np.array([0, 100], dtype=np.int8), (12, 17))
    grid = OccupancyGrid(GridFrame(0.05, 17, 12, SE2(-1.0, 2.0, 0.1)), data, 0.0)
    return save_map(grid, folder / "room", image_format, MapOptions(mode))[0]


def _image(image_format: str) -> Callable[[Path], Path]:
    return lambda folder: _map(folder, image_format).with_suffix(f".{image_format}")


def _parameters(folder: Path) -> Path:
    path = folder / "nav.yaml"
    lines = shipped_file("params/arjuna_nav.yaml").read_bytes().splitlines(keepends=True)
    last = lines.index(b"planner_server:\n")
    path.write_bytes(b"".join(lines[:last]))
    return path


def _waypoints(folder: Path) -> Path:
    path = folder / "tour.yaml"
    rows = [{"x": 1.0, "y": 2.0, "yaw": 0.5}, [3.0, 4.0, 0.1]]
    path.write_text(yaml.safe_dump({"waypoints": rows}), encoding="utf-8")
    return path


def _carmen(folder: Path) -> Path:
    path = folder / "room.clf"
    beams = " ".join(f"{1.0 + k % 7}" for k in range(180))
    lines = [
        f"FLASER 180 {beams} {t} 0.1 0.2 {t} 0.1 0.2 {t} host {t}\n"
        "ROBOTLASER1 4 -1.57 3.14 0.785 10.0 0.1 0 4 1.0 2.0 3.0 4.0 0 "
        f"{t} 0.1 0.2 {t} 0.1 0.2 0.1 0.1 0.5 0.5 1.0 {t} host {t}\n"
        for t in (1.0, 2.0, 3.0)
    ]
    path.write_text("".join(lines), encoding="ascii")
    return path


def log_entries() -> list[tuple[str, str, float, bytes]]:
    found = []
    for k in range(6):
        stamp, pose = 1.0 + 0.1 * k, SE2(0.1 * k, 0.0)
        scan = Scan(np.full(30, 2.0), -1.0, 0.07, 0.1, 10.0, stamp)
        found.append(("/odom", ODOMETRY, stamp, odometry_bytes(pose, stamp)))
        tree = ("odom", "base_footprint", pose, stamp)
        found.append(("/tf", TF, stamp, transform_bytes(tree)))
        found.append(("/scan", SCAN, stamp, scan_bytes(scan)))
    return found


def _db3(folder: Path) -> Path:
    return next(write_humble(folder / "bag", log_entries()).glob("*.db3"))


def _session(folder: Path) -> Path:
    from arjuna_slam.mapping.session import save_session
    from arjuna_slam.slam import Slam  # compiles the matcher: only where sessions are read

    slam = Slam()
    for k in range(4):
        scan = Scan(np.full(60, 2.0 + 0.1 * k), -3.0, 0.1, 0.1, 10.0, float(k))
        slam.process(scan, SE2(0.6 * k, 0.0))
    session = slam.session()
    assert session is not None
    save_session(folder / "room.posegraph", session)
    return folder / "room.posegraph"


def _signed(data: bytes) -> bytes:
    """Return a session with the checksum that its content has."""
    body = data[:-_DIGEST]
    return body + hashlib.sha256(body).digest()


def _drained(path: Path) -> None:
    deque(open_log(path, RecordingTopics()), maxlen=0)


def _bag(path: Path) -> None:
    deque(Bag(path).messages(), maxlen=0)


def _recorded(folder: Path) -> Path:
    return write(folder / "run.mcap", log_entries())


READERS = (
    Reader("map YAML", load_map, MapError, _map),
    Reader("map PGM", lambda path: load_map(path.with_suffix(".yaml")), MapError, _image("pgm")),
    Reader("map PNG", lambda path: load_map(path.with_suffix(".yaml")), MapError, _image("png")),
    Reader("parameters", lambda path: load_parameters([path]), InputFileError, _parameters),
    Reader("waypoints", load_waypoints, InputFileError, _waypoints),
    Reader("route graph", lambda path: read_graph(path, "map"), InputFileError, routes.written),
    Reader("lattice", primitives.read, InputFileError, lattices.written),
    Reader("CARMEN", _drained, InputFileError, _carmen),
    Reader("mcap as log", _drained, InputFileError, _recorded),
    Reader("mcap as bag", _bag, InputFileError, _recorded),
    Reader("db3 as log", _drained, InputFileError, _db3),
    Reader("db3 as bag", _bag, InputFileError, _db3),
    Reader(
        "ROS 1 bag",
        _drained,
        InputFileError,
        lambda folder: write_ros1(folder / "run.bag", log_entries()),
    ),
    Reader("session", load_session, SessionFileError, _session, _signed),
)


@dataclass(frozen=True)
class Finding:
    """An input that a reader fails on.

    Attributes:
        reader: Its name.
        problem: What it raised, or how long it took.
        data: The input.
    """

    reader: str
    problem: str
    data: bytes


class Fuzzer:
    """Changes one reader's file and has it read, again and again.

    Args:
        reader: The reader.
        folder: Where its file is.
        seed: Of all changes.
    """

    def __init__(self, reader: Reader, folder: Path, seed: int) -> None:
        self.reader = reader
        self._rng = np.random.default_rng(seed)
        self._path = reader.make(folder)
        self._good = self._path.read_bytes()
        reader.read(self._path)

    def once(self) -> Finding | None:
        """Read the file after a few changes; return what was wrong with that."""
        data = self.reader.mend(mutated(self._good, self._rng, 4))
        self._path.write_bytes(data)
        started = time.process_time()
        problem = ""
        try:
            self.reader.read(self._path)
        except self.reader.error as error:
            problem = "an error of many lines" if "\n" in str(error) else ""
        except Exception as error:  # noqa: BLE001 - what is looked for
            frame = traceback.extract_tb(error.__traceback__)[-1]
            where = f"{Path(frame.filename).name}:{frame.lineno}"
            problem = f"{type(error).__name__} at {where}: {str(error)[:200]}"
        spent = time.process_time() - started
        if spent > SLOW:
            problem = f"took {spent:.1f} s"
        return Finding(self.reader.name, problem, data) if problem else None
