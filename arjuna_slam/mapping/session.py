"""The saved state of a mapping session: all that another needs to continue from it."""

from __future__ import annotations

import enum
import hashlib
import io
import math
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from arjuna_core.arrays import Floats
from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import head_of, open_file, read_bytes
from arjuna_core.files.whole_file import write_atomically
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.graph.pose_graph import Edge, EdgeKind

_VERSION = 2
_FIRST_VERSION = b"ARJUNAPG"  # began the files of a format of its own
_DIGEST = hashlib.sha256().digest_size
_KINDS = (EdgeKind.ODOMETRY, EdgeKind.MATCH, EdgeKind.LOOP)
_TRIANGLE = np.triu_indices(3)
_COLUMNS = {
    "poses": ("<f8", 3), "travel": ("<f8", 0), "stamps": ("<f8", 0), "mounts": ("<f8", 3),
    "motions": ("<f8", 3), "sweeps": ("<f8", 5), "beams": ("<u4", 0), "ranges": ("<f4", 0),
    "edge_nodes": ("<u4", 2), "edge_poses": ("<f8", 3), "edge_information": ("<f8", 6),
    "edge_kinds": ("u1", 0), "submap_sizes": ("<u4", 0), "submap_nodes": ("<u4", 0),
    "version": ("<u4", 0), "odometry": ("<f8", 3),
}  # fmt: skip
_ADDED = "odometry"  # of no or one row; files of before lack it


@dataclass(frozen=True)
class Session:
    """A graph with the scans at its nodes."""

    scans: tuple[Scan, ...]  # the scan of each keyframe
    poses: Floats  # optimised x, y, theta of each keyframe in map, `(N, 3) float64` [m, m, rad]
    travel: Floats  # distance driven up to each keyframe, `(N,) float64` [m]
    edges: tuple[Edge, ...]  # the measurements between keyframes
    submaps: tuple[tuple[int, ...], ...]  # the keyframes of each submap, the first its anchor
    T_odom_base: SE2 | None = None  # odometry at the last keyframe; None where it is not known


class StartKind(enum.Enum):
    """Knowledge of the robot's pose when a session is resumed."""

    FIRST_NODE = "at the first keyframe"
    NEAR_POSE = "near a pose"
    ANYWHERE = "anywhere on the map"
    ODOMETRY = "where odometry, which went on meanwhile, has brought it"


@dataclass(frozen=True)
class Start:
    """The pose at which a session is resumed."""

    kind: StartKind  # what is known
    T_map_base: SE2 = IDENTITY  # the pose, where one is known


SUFFIX = ".posegraph"
Arrays = dict[str, NDArray[Any]]
"""Name, type and width of each array; width 0 for a plain column."""


class SessionFileError(InputFileError):
    """A saved session is missing, damaged, foreign or inconsistent, or cannot be written."""


def save_session(path: Path, session: Session) -> None:
    """Write a session, over one alone; the path then holds it whole, or what it held before.

    Raises:
        SessionFileError: It cannot be written, does not read back as it was, or is the file of
            something else.
    """
    archive = io.BytesIO()
    np.savez(archive, allow_pickle=False, **_to_arrays(session))
    body = archive.getvalue()
    data = body + hashlib.sha256(body).digest()

    def read_back(part: Path) -> None:
        if read_bytes(part, len(data), SessionFileError) != data:
            raise SessionFileError(path, "does not read back as it was written; the disk may fail")
        _check(path, _read_arrays(path, data))

    try:
        _check_replaced(path)
        write_atomically(path, data, read_back)
    except OSError as error:
        raise SessionFileError(path, f"cannot be written: {error.strerror}") from error


def load_session(path: Path) -> Session:
    """Read a session.

    Raises:
        SessionFileError: It is missing, damaged, foreign or inconsistent.
    """
    largest = 2**31  # [bytes]
    with open_file(path, SessionFileError) as file:
        _check_kind(path, file.read(64))  # before all of it is read
    arrays = _read_arrays(path, read_bytes(path, largest, SessionFileError))
    _check(path, arrays)
    return _from_arrays(arrays)


def _check_replaced(path: Path) -> None:
    """Refuse to write over a file that no session was written to."""
    size = 64  # [bytes] that distinguish a session from other files
    head = head_of(path, size, SessionFileError)
    ours = head.startswith(_FIRST_VERSION) or (head.startswith(b"PK") and b"poses.npy" in head)
    if head and not ours:
        problem = "is there and no pose graph of Arjuna's: it is not overwritten"
        raise SessionFileError(path, f"{problem}; choose another name")


def _to_arrays(session: Session) -> Arrays:
    """Return the arrays; flat lists, for many tuples at once call the garbage collector."""
    scans, edges = session.scans, session.edges
    values: Mapping[str, Any] = {
        "poses": session.poses,
        "travel": session.travel,
        "stamps": [scan.stamp for scan in scans],
        "mounts": [scan.T_base_sensor.array() for scan in scans],
        "motions": [scan.motion.array() for scan in scans],
        "sweeps": [value for scan in scans for value in _sweep(scan)],
        "beams": [len(scan.ranges) for scan in scans],
        "ranges": np.concatenate([np.zeros(0), *(scan.ranges for scan in scans)]),
        "edge_nodes": [node for edge in edges for node in (edge.i, edge.j)],
        "edge_poses": [edge.T_i_j.array() for edge in edges],
        "edge_information": [edge.information[_TRIANGLE] for edge in edges],
        "edge_kinds": [_KINDS.index(edge.kind) for edge in edges],
        "submap_sizes": [len(nodes) for nodes in session.submaps],
        "submap_nodes": [node for nodes in session.submaps for node in nodes],
        "version": [_VERSION],
        "odometry": [] if session.T_odom_base is None else [session.T_odom_base.array()],
    }
    return {
        name: np.asarray(values[name], dtype=kind).reshape((-1, width) if width else (-1,))
        for name, (kind, width) in _COLUMNS.items()
    }


def _sweep(scan: Scan) -> tuple[float, ...]:
    return (
        scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max, scan.time_increment
    )  # fmt: skip


def _check_kind(path: Path, data: bytes) -> None:
    if data.startswith(_FIRST_VERSION):
        raise SessionFileError(path, f"is of version 1, an earlier Arjuna's; valid: {_VERSION}")
    if not data.startswith(b"PK"):
        problem = "is no pose graph of Arjuna's"
        if data[:40].find(b"serialization::archive") >= 0:
            problem = (
                "is an archive of slam_toolbox's C++ (boost), which cannot be read: map again with"
                " 'slam --offline BAG' of the recording it was made from, or save its map there"
                " (save_map) and localize by that .yaml ('nav --map')"
            )
        raise SessionFileError(path, problem)


def _read_arrays(path: Path, data: bytes) -> Arrays:
    _check_kind(path, data)
    body = data[:-_DIGEST]
    if hashlib.sha256(body).digest() != data[-_DIGEST:]:
        raise SessionFileError(path, "is damaged or cut short: its checksum does not fit")
    try:
        with zipfile.ZipFile(io.BytesIO(body)) as archive:
            arrays = {name: _read_array(archive, name) for name in _COLUMNS}
    except (zipfile.BadZipFile, ValueError, KeyError, EOFError, RuntimeError) as error:
        raise SessionFileError(path, f"is no archive of its arrays: {error}") from error
    if arrays["version"].tolist() != [_VERSION]:
        raise SessionFileError(path, f"is of version {arrays['version']}; valid: {_VERSION}")
    return arrays


def _read_array(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    """Return an array, once its size is known to fit its entry in the file."""
    if name == _ADDED and f"{name}.npy" not in archive.namelist():
        return np.empty((0, 3))
    info = archive.getinfo(f"{name}.npy")
    if info.compress_type != zipfile.ZIP_STORED or info.file_size != info.compress_size:
        raise ValueError(f"{name} is compressed")
    content = io.BytesIO(archive.read(info))
    npy.read_magic(content)
    shape, fortran, kind = npy.read_array_header_1_0(content)
    known, width = _COLUMNS[name]
    rows = content.getbuffer().nbytes - content.tell()
    fits = math.prod(shape) * kind.itemsize == rows and len(shape) == (2 if width else 1)
    if kind != np.dtype(known) or fortran or not fits or (width and shape[1] != width):
        raise ValueError(f"{name} has the shape {shape} of {kind} in {rows} bytes")
    return np.frombuffer(content.getvalue(), kind, offset=content.tell()).reshape(shape)


def _check(path: Path, arrays: Arrays) -> None:
    count, edges = len(arrays["poses"]), len(arrays["edge_nodes"])

    def must(holds: Any, entry: str, problem: str) -> None:
        if not holds:
            raise SessionFileError(path, problem, entry)

    for name in ("travel", "stamps", "mounts", "motions", "sweeps", "beams"):
        must(len(arrays[name]) == count, name, f"{len(arrays[name])} rows for {count} keyframes")
    for name in ("edge_poses", "edge_information", "edge_kinds"):
        must(len(arrays[name]) == edges, name, f"{len(arrays[name])} rows for {edges} edges")
    for name, column in arrays.items():
        finite = name == "ranges" or column.dtype.kind != "f" or np.isfinite(column).all()
        must(finite, name, "a value is not finite")
    must(count > 0, "poses", "no keyframe")
    must(len(arrays["odometry"]) <= 1, "odometry", "more than that of the last keyframe")
    must(arrays["beams"].sum() == len(arrays["ranges"]), "ranges", "not as many as beams")
    nodes = arrays["edge_nodes"]
    must((nodes < count).all(), "edge_nodes", f"a node is none of 0..{count - 1}")
    must((nodes[:, 0] != nodes[:, 1]).all(), "edge_nodes", "an edge joins a node to itself")
    must((arrays["edge_kinds"] < len(_KINDS)).all(), "edge_kinds", "an unknown kind")
    sizes, members = arrays["submap_sizes"], arrays["submap_nodes"]
    must((sizes > 0).all() and sizes.sum() == len(members), "submap_sizes", "not as many as nodes")
    must((members < count).all(), "submap_nodes", f"a node is none of 0..{count - 1}")


def _from_arrays(arrays: Arrays) -> Session:
    ranges = np.split(arrays["ranges"].astype(np.float64), np.cumsum(arrays["beams"])[:-1])
    scans = tuple(_scan(arrays, k, values) for k, values in enumerate(ranges))
    members = np.split(arrays["submap_nodes"], np.cumsum(arrays["submap_sizes"])[:-1])
    return Session(
        scans,
        arrays["poses"].astype(np.float64),
        arrays["travel"].astype(np.float64),
        tuple(_edge(arrays, k) for k in range(len(arrays["edge_nodes"]))),
        tuple(tuple(nodes.tolist()) for nodes in members if len(nodes)),
        next(map(SE2.from_array, arrays["odometry"]), None),
    )


def _scan(arrays: Arrays, k: int, ranges: Floats) -> Scan:
    angle_min, increment, range_min, range_max, time_increment = arrays["sweeps"][k].tolist()
    stamp, mount = float(arrays["stamps"][k]), SE2.from_array(arrays["mounts"][k])
    motion = SE2.from_array(arrays["motions"][k])
    return Scan(
        ranges, angle_min, increment, range_min, range_max, stamp, time_increment, mount, motion
    )  # fmt: skip


def _edge(arrays: Arrays, k: int) -> Edge:
    i, j = arrays["edge_nodes"][k].tolist()
    information = np.zeros((3, 3))
    information[_TRIANGLE] = arrays["edge_information"][k]
    information.T[_TRIANGLE] = arrays["edge_information"][k]
    kind = _KINDS[int(arrays["edge_kinds"][k])]
    return Edge(i, j, SE2.from_array(arrays["edge_poses"][k]), information, kind)
