"""Claims: devices, pipes, holes and bombs in place of files are refused at once, by one error.

Each within 2 s of computing, 100 MB of memory more than before, and a message of 500 characters.
"""

from __future__ import annotations

import bz2
import gc
import gzip
import lzma
import os
import signal
import sqlite3
import struct
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
import zstandard
from mcap.writer import CompressionType, Writer

from arjuna_core.bags.reader import Bag
from arjuna_core.errors import MapError
from tests.fuzz.files import LONGEST, READERS, Reader
from tests.sim.files.test_pictures import OGRE, drawn, world_of

SECONDS = 2.0
MEGABYTES = 100.0
HOLE = 100 << 30  # [bytes]
BY_NAME = {reader.name: reader for reader in READERS}


class Stuck(BaseException):
    """A call has not ended; no handler of errors takes it for one."""


def _stuck(number: int, frame: object) -> None:
    raise Stuck


def _memory(entry: str) -> float:
    """Return an entry of this process's memory [MB]."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(float(line.split()[1]) for line in lines if line.startswith(entry)) / 1024.0


@pytest.fixture(scope="module", autouse=True)
def _garbage_of_other_tests_is_not_looked_for() -> None:
    gc.collect()
    gc.freeze()


@contextmanager
def bounds() -> Iterator[None]:
    """Hold what is done to the time and the memory that an attack may cost."""
    gc.collect()
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")  # the peak is of now
    before, started = _memory("VmRSS"), time.process_time()
    previous = signal.signal(signal.SIGALRM, _stuck)
    signal.setitimer(signal.ITIMER_REAL, 20.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, previous)
    assert time.process_time() - started < SECONDS
    assert _memory("VmHWM") - before < MEGABYTES


def refused(reader: Reader, path: Path) -> str:
    """Return the one error that a reader refuses a file with."""
    with bounds(), pytest.raises(reader.error) as caught:
        reader.read(path)
    assert len(str(caught.value)) <= LONGEST
    assert "\n" not in str(caught.value)
    return str(caught.value)


def _device(path: Path) -> None:
    path.symlink_to("/dev/zero")


def _pipe(path: Path) -> None:
    os.mkfifo(path)


def _folder(path: Path) -> None:
    path.mkdir()


def _hole(path: Path) -> None:
    path.touch()
    os.truncate(path, HOLE)


@pytest.mark.parametrize("reader", READERS, ids=[reader.name for reader in READERS])
def test_a_good_file_with_a_hole_behind_it_costs_no_more_and_what_is_no_file_is_refused(
    tmp_path: Path, reader: Reader
) -> None:
    path = reader.make(tmp_path)
    reader.read(path)  # what has to be imported is
    os.truncate(path, HOLE)
    problem = ""
    try:
        with bounds():
            reader.read(path)
    except reader.error as error:
        problem = str(error)
    assert len(problem) <= LONGEST
    if reader.name not in {"bag metadata", "CMake"}:  # which have one name
        refused(reader, path.with_name("x" * 300 + path.suffix))
    path.unlink()
    for put in (_device, _pipe, _hole, _folder):
        put(path)
        refused(reader, path)
        path.rmdir() if path.is_dir() else path.unlink()


SCAN = b"FLASER 180 " + b"1.0 " * 180 + b"0 0 0 0 0 0 1.0 host 1.0\n"
TEXTS = {"a line": b"\0", "blank lines": b"\n", "scans": SCAN, "scans cut short": b"FLASER 9\n"}
PACKERS: dict[str, Callable[[bytes], bytes]] = {
    ".gz": lambda text: gzip.compress(text, 6),
    ".bz2": lambda text: bz2.compress(text, 1),
    ".xz": lambda text: lzma.compress(text, preset=0),
}


@pytest.mark.parametrize(
    ("name", "suffix"), [*((name, ".gz") for name in TEXTS), ("scans", ".bz2"), ("scans", ".xz")]
)
def test_a_log_that_unpacks_hugely_is_refused(tmp_path: Path, name: str, suffix: str) -> None:
    path = tmp_path / f"bomb.clf{suffix}"
    text = TEXTS[name] * (5_000_000 // len(TEXTS[name]))
    path.write_bytes(PACKERS[suffix](text) * 100)
    refused(BY_NAME["CARMEN"], path)


def _chunks(path: Path, compression: CompressionType, size: int, count: int) -> Path:
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=1, compression=compression)
        writer.start()
        schema = writer.register_schema("a/B", "ros2msg", b"")
        channel = writer.register_channel("/a", "cdr", schema)
        for number in range(count):
            writer.add_message(channel, 10 - number % 2, bytes(size), 0)
        writer.finish()
    return path


@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.LZ4])
def test_chunks_beyond_all_sizes_are_skipped(tmp_path: Path, compression: CompressionType) -> None:
    path = _chunks(tmp_path / "a.mcap", compression, 200_000_000, 1)
    assert path.stat().st_size < 1_000_000
    with bounds():
        bag = Bag(path)
        assert list(bag.messages()) == []
    assert any("are damaged (a chunk of 200" in problem for problem in bag.problems)


def test_chunks_that_overlap_are_not_all_held(tmp_path: Path) -> None:
    path = _chunks(tmp_path / "a.mcap", CompressionType.ZSTD, 20_000_000, 30)
    with bounds():
        BY_NAME["mcap as bag"].read(path)


def test_a_recording_that_unpacks_to_far_more_than_itself_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap.zstd"
    path.write_bytes(zstandard.compress(bytes(400_000_000)))
    assert "unpack to" in refused(BY_NAME["mcap as log"], path)


def test_a_message_larger_than_any_in_a_db3_file_is_not_read(tmp_path: Path) -> None:
    path = BY_NAME["db3 as log"].make(tmp_path)
    with closing(sqlite3.connect(path)) as database:
        database.execute("DELETE FROM messages WHERE id > 1")
        database.execute("UPDATE messages SET data = zeroblob(256000000)")
        database.commit()
    refused(BY_NAME["db3 as log"], path)


def test_a_column_that_is_computed_is_refused(tmp_path: Path) -> None:
    path = BY_NAME["db3 as log"].make(tmp_path)
    with closing(sqlite3.connect(path)) as database:
        database.execute("ALTER TABLE messages RENAME TO old")
        database.execute(
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER,"
            " data BLOB GENERATED ALWAYS AS (zeroblob(700000000)))"
        )
        database.execute("INSERT INTO messages(topic_id, timestamp) VALUES (1, 1)")
        database.commit()
    assert "are computed" in refused(BY_NAME["db3 as log"], path)


@pytest.mark.parametrize("end", ["-wal", "-shm", "-journal"])
def test_a_pipe_beside_a_db3_file_is_refused(tmp_path: Path, end: str) -> None:
    path = BY_NAME["db3 as log"].make(tmp_path)
    os.mkfifo(f"{path}{end}")
    refused(BY_NAME["db3 as log"], path)


@pytest.mark.parametrize("packed", ["png", "pgm"])
def test_an_image_larger_than_any_map_is_refused(tmp_path: Path, packed: str) -> None:
    path = BY_NAME["map PGM"].make(tmp_path).with_suffix(f".{packed}")
    if packed == "pgm":
        path.write_bytes(b"P5 30000 30000 255 " + bytes(16))
    else:
        size = struct.pack(">IIBBBBB", 30000, 30000, 1, 0, 0, 0, 0)
        parts = ((b"IHDR", size), (b"IDAT", zlib.compress(bytes(1_000_000))), (b"IEND", b""))
        chunks = (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
            for kind, data in parts
        )
        path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunks))
    header = path.with_suffix(".yaml")
    header.write_text(header.read_text().replace("room.pgm", path.name))
    with bounds(), pytest.raises(MapError, match="pixels"):
        BY_NAME["map YAML"].read(header)


def test_blank_lines_of_a_material_s_script_are_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "board" / "materials" / "scripts" / "board.material"
    (path.parents[1] / "textures").mkdir(parents=True)
    path.parent.mkdir()
    path.write_text("\n" * 300_000)
    with bounds():
        assert drawn(world_of(tmp_path, OGRE)) == []


def _launch(text: str) -> Callable[[Path], Path]:
    def made(folder: Path) -> Path:
        path = folder / "a.launch"
        path.write_text(f"<launch>{text}</launch>")
        return path

    return made


GROWING = "".join(
    f'<arg name="a{n + 1}" value="$(arg a{n})$(arg a{n})"/>' for n in range(60)
)  # fmt: skip


@pytest.mark.parametrize(
    "text",
    [
        "<group>" * 100_000,
        '<include file="a.launch"/>' * 10,
        f'<arg name="a0" value="aaaa"/>{GROWING}',
        '<node type="amcl"><param name="{}" value="1"/></node>'.format("a/" * 100_000),
        '<node type="amcl"><rosparam>{}</rosparam></node>'.format("[" * 100_000),
    ],
    ids=["nested", "includes itself", "grows", "deep name", "deep value"],
)
def test_a_launch_file_without_end_is_refused(tmp_path: Path, text: str) -> None:
    refused(BY_NAME["launch"], _launch(text)(tmp_path))


POINT = '{"geometry": {"type": "Point", "coordinates": [X, 1]}, "properties": {"id": 0}}'
GRAPH = f'{{"features": [{POINT}]}}'


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("parameters", "amcl: {ros__parameters: {max_particles: !!timestamp x}}"),
        ("campaign", "command: goals {folder}\nresult: a\nsuccess: {}\nmeasures: 2001-01-01"),
        ("waypoints", f"waypoints: [[{'1' * 310}, 2.0, 0.0]]"),
        ("map YAML", f"image: a.pgm\nresolution: {'1' * 310}\norigin: [0, 0, 0]"),
        ("map YAML", f"image: {'x' * 300}.pgm\nresolution: 1\norigin: [0, 0, 0]"),
        ("route graph", GRAPH.replace("X", "1" * 310)),
        ("lattice", "[" * 100_000),
        ("lattice", "[" + "{}," * 6_000_000 + "{}]"),
        ("mesh dae", '<?xml version="1.0" encoding="none-such"?><COLLADA/>'),
        ("mesh dae", "<a>" * 100_000),
        ("tree", '<?xml version="1.0" encoding="none-such"?><root/>'),
        ("launch", '<?xml version="1.0" encoding="none-such"?><launch/>'),
        ("launch", f'<launch><include file="{"x" * 300}"/>{"<a/>" * 300_000}</launch>'),
        ("docks", "docks: {a: {pose: [!!timestamp x, 1, 2]}}"),
        ("relations", "1e999999 " * 8 + "x"),
    ],
)  # fmt: skip
def test_what_a_reader_does_not_expect_is_refused(tmp_path: Path, name: str, text: str) -> None:
    path = BY_NAME[name].make(tmp_path)
    path.write_text(text)
    if name == "parameters":
        BY_NAME[name].read(path)  # a date is a text there, and no number of particles
    else:
        refused(BY_NAME[name], path)
