"""A saved session reads back whole, and is never half a file, nor a hostile one."""

from __future__ import annotations

import dataclasses
import hashlib
import io
import signal
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.lib import format as npy
from numpy.typing import NDArray

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge, EdgeKind
from arjuna_slam.mapping.session import Session, SessionFileError, load_session, save_session
from tests.helpers.killed import killed


def test_where_odometry_was_is_kept_and_earlier_files_do_not_know_it(
    session: Session, log: list[tuple[Scan, SE2, SE2]], file: Path
) -> None:
    at = {scan.stamp: odometry for scan, odometry, _ in log}
    assert load_session(file).T_odom_base == session.T_odom_base == at[session.scans[-1].stamp]
    file.write_bytes(packed(file, {"odometry": None}))
    assert load_session(file).T_odom_base is None


def test_the_same_session_gives_the_same_bytes(file: Path, tmp_path: Path) -> None:
    save_session(tmp_path / "again", load_session(file))
    assert (tmp_path / "again").read_bytes() == file.read_bytes()


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
        (
            b"22 serialization::archive 17 0 0",
            r"archive of slam_toolbox.* map again with 'slam --offline BAG'",
        ),
        (b"\x89PNG" * 100, "is no pose graph of Arjuna's"),
        (b"ARJUNAPG\x01\0\0\0" + b"\0" * 100, "is of version 1, an earlier Arjuna's; valid: 2"),
        (b"PK\x03\x04" + b"\0" * 100, "its checksum does not fit"),
    ],
)
def test_a_foreign_file_is_refused_with_a_reason(tmp_path: Path, data: bytes, message: str) -> None:
    path = tmp_path / "other.posegraph"
    path.write_bytes(data)
    with pytest.raises(SessionFileError, match=message):
        load_session(path)
    with pytest.raises(SessionFileError, match="cannot be read"):
        load_session(tmp_path / "none")


def sealed(archive: bytes) -> bytes:
    return archive + hashlib.sha256(archive).digest()


def packed(file: Path, changed: dict[str, NDArray[Any] | None], compressed: bool = False) -> bytes:
    """Return a file with some arrays changed or left out, its checksum right."""
    with np.load(file) as archive:
        arrays = {name: archive[name] for name in archive.files} | changed
    content = io.BytesIO()
    save = np.savez_compressed if compressed else np.savez
    save(content, **{name: array for name, array in arrays.items() if array is not None})
    return sealed(content.getvalue())


def test_numpy_reads_the_file_and_no_code_is_in_it(session: Session, file: Path) -> None:
    with np.load(file, allow_pickle=False) as archive:
        assert archive["poses"].tobytes() == session.poses.tobytes()
        assert archive["version"].tolist() == [2]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"poses": np.zeros((4, 2))}, r"poses has the shape \(4, 2\)"),
        ({"poses": np.zeros((4, 3), np.float32)}, "of float32"),
        ({"ranges": np.zeros((4, 3), np.float32)}, r"ranges has the shape \(4, 3\)"),
        ({"travel": None}, "no item named 'travel.npy'"),
        ({"travel": np.array(["a"], object)}, "travel has the shape"),
        ({"odometry": np.zeros((2, 3))}, "odometry: more than that of the last keyframe"),
        ({"version": np.array([3], np.uint32)}, r"is of version \[3\]; valid: 2"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(
    file: Path, changed: dict[str, NDArray[Any] | None], message: str
) -> None:
    file.write_bytes(packed(file, changed))
    with pytest.raises(SessionFileError, match=message):
        load_session(file)


def test_a_compressed_archive_is_refused_before_it_is_unpacked(file: Path) -> None:
    file.write_bytes(packed(file, {"ranges": np.zeros(10**7, np.float32)}, True))
    assert file.stat().st_size < 10**6
    with pytest.raises(SessionFileError, match="poses is compressed"):
        load_session(file)


def test_a_header_of_terabytes_is_refused_before_it_is_believed(file: Path) -> None:
    lie = io.BytesIO()
    npy.write_array_header_1_0(lie, {"descr": "<f8", "fortran_order": False, "shape": (10**12, 3)})
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        archive.writestr("poses.npy", lie.getvalue())
    file.write_bytes(sealed(content.getvalue()))
    with pytest.raises(SessionFileError, match=r"poses has the shape \(10{12}, 3\) .* in 0 bytes"):
        load_session(file)


def test_random_damage_with_a_right_checksum_raises_its_own_error_alone(file: Path) -> None:
    whole, rng = file.read_bytes()[:-32], np.random.default_rng(2)
    start = whole.index(b"PK\x01\x02")
    for k in range(300):
        damaged = bytearray(whole)
        low, high = (0, len(whole)) if k % 2 else (start, len(whole))
        for at in rng.integers(low, high, 5).tolist():
            damaged[at] = int(rng.integers(256))
        file.write_bytes(sealed(bytes(damaged)))
        try:
            load_session(file)
        except SessionFileError:
            continue


def test_a_disk_that_returns_other_bytes_is_noticed_and_the_old_file_stays(
    session: Session, file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = file.read_bytes()
    changed = whole[:-1] + bytes([whole[-1] ^ 1])
    monkeypatch.setattr("arjuna_slam.mapping.session.read_bytes", lambda path, *_: changed)
    with pytest.raises(SessionFileError, match="does not read back"):
        save_session(file, session)
    monkeypatch.undo()
    assert file.read_bytes() == whole


@pytest.mark.parametrize(
    ("point", "number", "saved"),
    [
        ("write", 50000, False),
        ("fsync", 1, False),
        ("replace", 1, False),
        ("fsync", 2, True),
    ],
)
def test_killed_while_saving_the_file_is_the_old_or_the_new(
    file: Path, tmp_path: Path, session: Session, point: str, number: int, saved: bool
) -> None:
    old = file.read_bytes()
    new = tmp_path / "new.posegraph"
    save_session(new, dataclasses.replace(session, travel=session.travel + 1.0))
    ended = killed(lambda: save_session(file, load_session(new)), point, number)
    assert ended == (signal.SIGXFSZ if point == "write" else signal.SIGKILL)
    assert file.read_bytes() == (new.read_bytes() if saved else old)
    save_session(file, load_session(new))  # what the killed one left is in nobody's way
    assert sorted(path.name for path in tmp_path.iterdir()) == ["new.posegraph", "room.posegraph"]


BEAMS = (5, 0, 3, 1)


def made_up(seed: int) -> Session:
    """Return a session of which no two values are the same."""
    rng = np.random.default_rng(seed)

    def pose() -> SE2:
        return SE2(*rng.normal(size=3).tolist())

    def scan(beams: int) -> Scan:
        ranges = rng.uniform(0.5, 9.0, beams).astype(np.float32).astype(np.float64)
        numbers = rng.uniform(0.1, 9.0, 6).tolist()
        return replace(Scan(ranges, *numbers), T_base_sensor=pose(), motion=pose())

    def information() -> Floats:
        root = rng.normal(size=(3, 3))
        return np.asarray(root @ root.T + np.eye(3), np.float64)

    kinds = (EdgeKind.LOOP, EdgeKind.ODOMETRY, EdgeKind.MATCH)
    edges = tuple(
        Edge(i, j, pose(), information(), kind)
        for (i, j), kind in zip(((3, 0), (0, 1), (2, 1)), kinds, strict=True)
    )
    scans = tuple(scan(count) for count in BEAMS)
    return Session(scans, rng.normal(size=(4, 3)), rng.random(4), edges, ((0, 2), (1,), (3, 0, 1)))


@pytest.mark.parametrize("odometry", [None, SE2(1.5, -2.0, 0.25)])
def test_every_value_comes_back(odometry: SE2 | None, tmp_path: Path) -> None:
    saved = replace(made_up(1), T_odom_base=odometry)
    save_session(tmp_path / "a.posegraph", saved)
    read = load_session(tmp_path / "a.posegraph")
    np.testing.assert_array_equal(read.poses, saved.poses)
    np.testing.assert_array_equal(read.travel, saved.travel)
    assert (read.submaps, read.T_odom_base) == (saved.submaps, saved.T_odom_base)
    for scan, known in zip(read.scans, saved.scans, strict=True):
        np.testing.assert_array_equal(scan.ranges, known.ranges)
        bare = np.zeros(0)
        assert repr(replace(scan, ranges=bare)) == repr(replace(known, ranges=bare))
    for edge, saved_edge in zip(read.edges, saved.edges, strict=True):
        assert (edge.i, edge.j, edge.T_i_j, edge.kind) == (
            saved_edge.i,
            saved_edge.j,
            saved_edge.T_i_j,
            saved_edge.kind,
        )
        np.testing.assert_array_equal(edge.information, edge.information.T)
        np.testing.assert_allclose(edge.information, saved_edge.information, rtol=1e-12)


def with_edge(session: Session, edge: Edge) -> Session:
    return replace(session, edges=(*session.edges, edge))


EDGE = Edge(0, 3, SE2(), np.eye(3), EdgeKind.LOOP)
FAR = replace(made_up(1).scans[0], range_max=float("nan"))


@pytest.mark.parametrize(
    ("wrong", "problem"),
    [
        (with_edge(made_up(1), replace(EDGE, j=4)), r"edge_nodes.*a node is none of 0\.\.3"),
        (with_edge(made_up(1), replace(EDGE, i=3)), "an edge joins a node to itself"),
        (replace(made_up(1), submaps=((0, 4),)), r"submap_nodes.*a node is none of 0\.\.3"),
        (replace(made_up(1), submaps=((),)), "submap_sizes.*not as many as nodes"),
        (replace(made_up(1), travel=np.zeros(3)), "travel.*3 rows for 4 keyframes"),
        (replace(made_up(1), poses=np.full((4, 3), np.inf)), "poses.*a value is not finite"),
        (replace(made_up(1), scans=(FAR, *made_up(1).scans[1:])), "sweeps.*is not finite"),
        (Session((), np.zeros((0, 3)), np.zeros(0), (), ()), "poses.*no keyframe"),
    ],
)
def test_contradictions_are_not_stored(wrong: Session, problem: str, tmp_path: Path) -> None:
    path = tmp_path / "a.posegraph"
    save_session(path, made_up(2))
    before = path.read_bytes()
    with pytest.raises(SessionFileError, match=problem):
        save_session(path, wrong)
    assert path.read_bytes() == before
    silent = replace(made_up(1).scans[0], ranges=np.array([np.inf, np.nan, 1.0, 2.0, 3.0]))
    save_session(path, replace(made_up(1), scans=(silent, *made_up(1).scans[1:])))
    np.testing.assert_array_equal(load_session(path).scans[0].ranges, silent.ranges)
