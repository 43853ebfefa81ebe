"""Claims: a saved session reads back whole, goes on where it ended, and is never half a file."""

from __future__ import annotations

import dataclasses
import hashlib
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.mapping.session import Session, Start, StartKind
from arjuna_slam.mapping.session_file import SessionFileError, load_session, save_session
from arjuna_slam.matching.scan_filter import Skip
from arjuna_slam.slam import Slam, SlamUpdate
from tests.slam.slam_room import distance_to_walls, drive, room, scan_at

Log = list[tuple[Scan, SE2, SE2]]
ORIGIN = SE2(5.0, 3.0, 0.0)  # where a drive begins, and so the map's frame in the room
SECOND = SE2(100.0, -50.0, 2.0)  # odometry starts anew with every session


@pytest.fixture(scope="module")
def log() -> Log:
    return drive(seed=5)


@pytest.fixture(scope="module")
def mapped(log: Log) -> Slam:
    slam = Slam()
    for scan, odometry, _ in log:
        slam.process(scan, odometry)
    slam.optimize()
    return slam


@pytest.fixture(scope="module")
def session(mapped: Slam) -> Session:
    found = mapped.session()
    assert found is not None
    return found


@pytest.fixture
def file(session: Session, tmp_path: Path) -> Path:
    path = tmp_path / "room.posegraph"
    save_session(path, session)
    return path


def test_a_session_reads_back_as_it_was(session: Session, file: Path) -> None:
    read = load_session(file)
    assert read.poses.tobytes() == session.poses.tobytes()
    assert read.travel.tobytes() == session.travel.tobytes()
    assert read.submaps == session.submaps
    assert len(read.edges) == len(session.edges)
    for edge, known in zip(read.edges, session.edges, strict=True):
        assert (edge.i, edge.j, edge.T_i_j, edge.kind) == (
            known.i,
            known.j,
            known.T_i_j,
            known.kind,
        )
        np.testing.assert_allclose(edge.information, known.information, rtol=1e-9)
    for scan, known_scan in zip(read.scans, session.scans, strict=True):
        np.testing.assert_allclose(scan.ranges, known_scan.ranges, rtol=1e-6)
        assert scan.angle_increment == known_scan.angle_increment
        assert (scan.stamp, scan.T_base_sensor) == (known_scan.stamp, known_scan.T_base_sensor)


def test_the_motion_within_scans_is_kept(session: Session, tmp_path: Path) -> None:
    moving = tuple(dataclasses.replace(scan, motion=SE2(0.1, 0.02, 0.3)) for scan in session.scans)
    save_session(tmp_path / "moving", dataclasses.replace(session, scans=moving))
    assert all(scan.motion == moving[0].motion for scan in load_session(tmp_path / "moving").scans)


def test_the_same_session_gives_the_same_bytes(file: Path, tmp_path: Path) -> None:
    save_session(tmp_path / "again", load_session(file))
    assert (tmp_path / "again").read_bytes() == file.read_bytes()


def test_the_map_of_a_saved_session_is_the_map(mapped: Slam, file: Path) -> None:
    resumed = Slam()
    resumed.resume(load_session(file), Start(StartKind.FIRST_NODE))
    first, second = mapped.map(), resumed.map()
    assert first is not None
    assert second is not None
    assert first.frame == second.frame
    assert (first.data != second.data).mean() < 1e-3


def go_on(slam: Slam, start: int, count: int = 60) -> tuple[list[SlamUpdate], Log]:
    """Drive on from a place on a lap of another seed, with odometry of its own."""
    log = drive(seed=9)[start : start + count]
    away = SECOND @ log[0][1].inverse()
    later = [(dataclasses.replace(s, stamp=s.stamp + 1000.0), away @ o, t) for s, o, t in log]
    updates = [slam.process(scan, odometry) for scan, odometry, _ in later]
    return [update for update in updates if update is not None], later


@pytest.mark.parametrize(
    ("start", "at"),
    [
        (Start(StartKind.FIRST_NODE), 3),
        (Start(StartKind.NEAR_POSE, SE2(2.4, 2.3, 1.4)), 75),
        (Start(StartKind.ANYWHERE), 75),
        (Start(StartKind.ANYWHERE), 190),
    ],
)
def test_mapping_goes_on_in_the_frame_of_the_saved_map(start: Start, at: int, file: Path) -> None:
    slam = Slam()
    slam.resume(load_session(file), start)
    nodes = len(slam.graph)
    updates, log = go_on(slam, at)
    assert len(updates) == len(log)
    error = [
        (ORIGIN @ update.T_map_base).distance(truth)
        for update, (_, _, truth) in zip(updates, log, strict=True)
    ]
    assert max(error) < 0.05
    assert len(slam.graph) > nodes + 10
    assert any(edge.i < nodes <= edge.j for edge in slam.graph.edges)
    grid = slam.map()
    assert grid is not None
    cells = np.argwhere(grid.occupied()).astype(np.int64)
    assert distance_to_walls(room(), ORIGIN.apply(grid.frame.to_points(cells))).mean() < 0.03


def test_a_continued_session_can_be_saved_and_continued_again(file: Path, tmp_path: Path) -> None:
    slam = Slam()
    for k in range(2):
        slam.resume(load_session(file), Start(StartKind.FIRST_NODE))
        updates, log = go_on(slam, 3 + 5 * k)
        found = slam.session()
        assert found is not None
        save_session(file, found)
    assert (ORIGIN @ updates[-1].T_map_base).distance(log[-1][2]) < 0.05


def test_a_robot_that_is_nowhere_on_the_map_waits_until_it_is(file: Path) -> None:
    slam = Slam()
    slam.resume(load_session(file), Start(StartKind.ANYWHERE))
    elsewhere = scan_at(room()[:4] * 0.31, SE2(1.0, 2.0, 0.3), stamp=1.0)
    assert slam.process(elsewhere, SE2()) is None
    assert slam.scans.counts[Skip.LOST] == 1
    updates, log = go_on(slam, 75)
    assert (ORIGIN @ updates[-1].T_map_base).distance(log[-1][2]) < 0.05


def test_a_start_that_no_scan_confirms_is_believed_and_said_so(file: Path) -> None:
    slam = Slam()
    slam.resume(load_session(file), Start(StartKind.NEAR_POSE, SE2(50.0, 0.0, 0.0)))
    updates, _ = go_on(slam, 75, 5)
    assert updates[0].status.value == "low response"
    assert updates[0].T_map_base == SE2(50.0, 0.0, 0.0)


def test_nothing_to_save_is_none() -> None:
    assert Slam().session() is None


@pytest.mark.parametrize("share", [0.0, 0.0001, 0.001, 0.3, 0.9, 0.9999])
def test_a_file_cut_short_is_refused(file: Path, share: float) -> None:
    file.write_bytes(file.read_bytes()[: int(share * file.stat().st_size)])
    with pytest.raises(SessionFileError, match=r"no pose graph|cut short"):
        load_session(file)


def test_any_byte_that_changed_is_noticed(file: Path) -> None:
    whole = file.read_bytes()
    for at in np.random.default_rng(1).integers(0, len(whole), 50).tolist():
        file.write_bytes(whole[:at] + bytes([whole[at] ^ 0x10]) + whole[at + 1 :])
        with pytest.raises(SessionFileError):
            load_session(file)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"22 serialization::archive 17 0 0", "archives that slam_toolbox writes cannot be read"),
        (b"\x89PNG" * 100, "is no pose graph of Arjuna's"),
        (b"ARJUNAPG\x02\0\0\0" + b"\0" * 100, "is of version 2; valid: 1"),
    ],
)
def test_a_foreign_file_is_refused_with_the_reason(
    tmp_path: Path, data: bytes, message: str
) -> None:
    path = tmp_path / "other.posegraph"
    path.write_bytes(data)
    with pytest.raises(SessionFileError, match=message):
        load_session(path)
    with pytest.raises(SessionFileError, match="cannot be read"):
        load_session(tmp_path / "none")


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        (b'"ranges", [', b'"ranges", [999', "ranges: of shape"),
        (b'"poses", [', b'"poses", [-', "poses: has the shape"),
        (b'"travel"', b'"trovel"', "travel: has the shape"),
        (b'{"arrays"', b'["arrays"', "has no valid header"),
    ],
)
def test_a_header_that_lies_is_refused(
    file: Path, before: bytes, after: bytes, message: str
) -> None:
    data = file.read_bytes()
    length = int.from_bytes(data[12:16], "little")
    header = data[16 : 16 + length].replace(before, after)
    body = data[:12] + len(header).to_bytes(4, "little") + header + data[16 + length : -32]
    file.write_bytes(body + hashlib.sha256(body).digest())
    with pytest.raises(SessionFileError, match=message):
        load_session(file)


def test_a_session_that_contradicts_itself_is_never_written(
    session: Session, tmp_path: Path
) -> None:
    poses = session.poses.copy()
    poses[3, 1] = np.nan
    with pytest.raises(SessionFileError, match="poses: a value is not finite"):
        save_session(tmp_path / "a", dataclasses.replace(session, poses=poses))
    with pytest.raises(SessionFileError, match=r"travel: .* rows for"):
        save_session(tmp_path / "a", dataclasses.replace(session, travel=session.travel[1:]))
    assert not (tmp_path / "a").exists()


def test_a_disk_that_returns_other_bytes_is_noticed_and_the_old_file_stays(
    session: Session, file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = file.read_bytes()
    monkeypatch.setattr(Path, "read_bytes", lambda path: whole[:-1] + b"?")
    with pytest.raises(SessionFileError, match="does not read back"):
        save_session(file, session)
    monkeypatch.undo()
    assert file.read_bytes() == whole


_CHILD = """
import os, resource, signal, sys
from pathlib import Path
from arjuna_slam.mapping.session_file import load_session, save_session

new, target, point, number = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3], int(sys.argv[4])
session = load_session(new)
calls = 0

def killing(call, number):
    def wrapped(*arguments):
        global calls
        calls += 1
        if calls == number:
            os.kill(os.getpid(), signal.SIGKILL)
        return call(*arguments)
    return wrapped

if point == "write":
    signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
    resource.setrlimit(resource.RLIMIT_FSIZE, (number, number))
if point == "fsync":
    os.fsync = killing(os.fsync, number)
if point == "replace":
    Path.replace = killing(Path.replace, number)
save_session(target, session)
"""


@pytest.mark.parametrize(
    ("point", "number", "saved"),
    [
        ("write", 100, False),
        ("write", 50000, False),
        ("fsync", 1, False),
        ("replace", 1, False),
        ("fsync", 2, True),
        ("never", 0, True),
    ],
)
def test_killed_while_saving_the_file_is_the_old_or_the_new(
    file: Path, tmp_path: Path, session: Session, point: str, number: int, saved: bool
) -> None:
    old = file.read_bytes()
    new = tmp_path / "new.posegraph"
    save_session(new, dataclasses.replace(session, travel=session.travel + 1.0))
    child = subprocess.run(
        [sys.executable, "-c", _CHILD, str(new), str(file), point, str(number)],
        cwd=Path(__file__).resolve().parents[3],
        check=False,
    )
    killed = {"never": 0, "write": -signal.SIGXFSZ}.get(point, -signal.SIGKILL)
    assert child.returncode == killed
    assert file.read_bytes() == (new.read_bytes() if saved else old)
    save_session(file, load_session(new))  # what the killed one left is in nobody's way
    assert sorted(path.name for path in tmp_path.iterdir()) == ["new.posegraph", "room.posegraph"]
