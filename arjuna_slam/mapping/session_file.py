"""Sessions on disk: a versioned file of plain arrays with a checksum.

Layout: the magic, version and length of the header (`uint32`, little end first), the header (JSON:
names, types and shapes of the arrays), the arrays one after another, and the SHA-256 of all that.
"""

from __future__ import annotations

import hashlib
import json
import math
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.errors import InputFileError
from arjuna_core.files.atomic import write_atomically
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge, EdgeKind
from arjuna_slam.mapping.session import Session

SUFFIX = ".posegraph"
_MAGIC = b"ARJUNAPG"
_VERSION = 1
_HEAD = struct.Struct("<8sII")
_DIGEST = hashlib.sha256().digest_size
_KINDS = (EdgeKind.ODOMETRY, EdgeKind.MATCH, EdgeKind.LOOP)
_TRIANGLE = np.triu_indices(3)
Arrays = dict[str, NDArray[Any]]
_COLUMNS = {
    "poses": ("<f8", 3), "travel": ("<f8", 0), "stamps": ("<f8", 0), "mounts": ("<f8", 3),
    "motions": ("<f8", 3), "sweeps": ("<f8", 5), "beams": ("<u4", 0), "ranges": ("<f4", 0),
    "edge_nodes": ("<u4", 2), "edge_poses": ("<f8", 3), "edge_information": ("<f8", 6),
    "edge_kinds": ("u1", 0), "submap_sizes": ("<u4", 0), "submap_nodes": ("<u4", 0),
}  # fmt: skip
"""Name, type and width of each array; width 0 for a plain column."""


class SessionFileError(InputFileError):
    """A saved session is missing, damaged, foreign or inconsistent, or cannot be written."""


def save_session(path: Path, session: Session) -> None:
    """Write a session; the path then holds it whole, or what it held before.

    Args:
        path: The file.
        session: The session.

    Raises:
        SessionFileError: It cannot be written, or does not read back as it was.
    """
    data = _encode(session)

    def read_back(part: Path) -> None:
        if part.read_bytes() != data:
            raise SessionFileError(path, "does not read back as it was written; the disk may fail")
        _decode(path, data)

    try:
        write_atomically(path, data, read_back)
    except OSError as error:
        raise SessionFileError(path, f"cannot be written: {error.strerror}") from error


def load_session(path: Path) -> Session:
    """Read a session.

    Args:
        path: The file.

    Raises:
        SessionFileError: It is missing, damaged, foreign or inconsistent.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise SessionFileError(path, f"cannot be read: {error.strerror}") from error
    return _decode(path, data)


def _encode(session: Session) -> bytes:
    arrays = _to_arrays(session)
    listed = [(name, arrays[name].shape) for name in _COLUMNS]
    header = json.dumps({"arrays": listed}).encode()
    body = _HEAD.pack(_MAGIC, _VERSION, len(header)) + header
    body += b"".join(arrays[name].tobytes() for name in _COLUMNS)
    return body + hashlib.sha256(body).digest()


def _to_arrays(session: Session) -> Arrays:
    scans, edges = session.scans, session.edges
    values: Mapping[str, Any] = {
        "poses": session.poses,
        "travel": session.travel,
        "stamps": [scan.stamp for scan in scans],
        "mounts": [scan.T_base_sensor.array() for scan in scans],
        "motions": [scan.motion.array() for scan in scans],
        "sweeps": [_sweep(scan) for scan in scans],
        "beams": [len(scan.ranges) for scan in scans],
        "ranges": np.concatenate([np.zeros(0), *(scan.ranges for scan in scans)]),
        "edge_nodes": [(edge.i, edge.j) for edge in edges],
        "edge_poses": [edge.T_i_j.array() for edge in edges],
        "edge_information": [edge.information[_TRIANGLE] for edge in edges],
        "edge_kinds": [_KINDS.index(edge.kind) for edge in edges],
        "submap_sizes": [len(nodes) for nodes in session.submaps],
        "submap_nodes": [node for nodes in session.submaps for node in nodes],
    }
    return {
        name: np.asarray(values[name], dtype=kind).reshape((-1, width) if width else (-1,))
        for name, (kind, width) in _COLUMNS.items()
    }


def _sweep(scan: Scan) -> tuple[float, ...]:
    return (
        scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max, scan.time_increment
    )  # fmt: skip


def _decode(path: Path, data: bytes) -> Session:
    arrays = _read_arrays(path, data)
    _check(path, arrays)
    return _from_arrays(arrays)


def _read_arrays(path: Path, data: bytes) -> Arrays:
    if not data.startswith(_MAGIC):
        problem = "is no pose graph of Arjuna's"
        if data[:40].find(b"serialization::archive") >= 0:
            problem += "; the archives that slam_toolbox writes cannot be read"
        raise SessionFileError(path, problem)
    if len(data) < _HEAD.size + _DIGEST:
        raise SessionFileError(path, f"is cut short: {len(data)} bytes")
    _, version, length = _HEAD.unpack_from(data)
    if version != _VERSION:
        raise SessionFileError(path, f"is of version {version}; valid: {_VERSION}")
    if hashlib.sha256(data[:-_DIGEST]).digest() != data[-_DIGEST:]:
        raise SessionFileError(path, "is damaged or cut short: its checksum does not fit")
    try:
        listed = json.loads(data[_HEAD.size : _HEAD.size + length])["arrays"]
        shapes = {str(name): tuple(int(n) for n in shape) for name, shape in listed}
    except (ValueError, KeyError, TypeError) as error:
        raise SessionFileError(path, f"has no valid header: {error}") from error
    return _cut(path, data, _HEAD.size + length, shapes)


def _cut(path: Path, data: bytes, at: int, shapes: dict[str, tuple[int, ...]]) -> Arrays:
    """Return the arrays, once they are sure to fill the file exactly."""
    arrays: Arrays = {}
    for name, (kind, width) in _COLUMNS.items():
        shape = shapes.get(name, ())
        if len(shape) != (2 if width else 1) or min(shape) < 0 or (width and shape[1] != width):
            raise SessionFileError(path, f"has the shape {shape}", name)
        count = math.prod(shape)
        end = at + count * np.dtype(kind).itemsize
        if end > len(data) - _DIGEST:
            raise SessionFileError(path, f"of shape {shape} does not fit in the file", name)
        arrays[name] = np.frombuffer(data, kind, count, at).reshape(shape)
        at = end
    if at != len(data) - _DIGEST:
        raise SessionFileError(path, f"has {len(data) - _DIGEST - at} bytes too many")
    return arrays


def _check(path: Path, arrays: Arrays) -> None:
    """Refuse what contradicts itself."""
    count, edges = len(arrays["poses"]), len(arrays["edge_nodes"])

    def must(holds: Any, place: str, problem: str) -> None:
        if not holds:
            raise SessionFileError(path, problem, place)

    for name in ("travel", "stamps", "mounts", "motions", "sweeps", "beams"):
        must(len(arrays[name]) == count, name, f"{len(arrays[name])} rows for {count} keyframes")
    for name in ("edge_poses", "edge_information", "edge_kinds"):
        must(len(arrays[name]) == edges, name, f"{len(arrays[name])} rows for {edges} edges")
    for name, column in arrays.items():
        finite = name == "ranges" or column.dtype.kind != "f" or np.isfinite(column).all()
        must(finite, name, "a value is not finite")
    must(count > 0, "poses", "no keyframe")
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
    )


def _scan(arrays: Arrays, k: int, ranges: NDArray[np.float64]) -> Scan:
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
