"""The ROS messages that SLAM needs, read from their bytes (CDR), so that no ROS is needed."""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2, is_upside_down, yaw_of

_HEADER = 4


class CdrError(ValueError):
    """Bytes are no message of the type asked for."""


@dataclass(frozen=True)
class StampedTransform:
    """`T_parent_child` at a time.

    Attributes:
        stamp: Time [s].
        parent: Frame mapped into.
        child: Frame mapped from.
        transform: The planar part.
        upside_down: Whether the child's z axis points down in the parent.
    """

    stamp: float
    parent: str
    child: str
    transform: SE2
    upside_down: bool = False


class CdrReader:
    """Reads values one after another; each lies at a multiple of its own size.

    Args:
        data: An encapsulated message: plain CDR, of either byte order.

    Raises:
        CdrError: The encapsulation is none or another one.

    Source: OMG DDS-XTypes 1.3, section 7.4.3 (XCDR version 1).
    """

    def __init__(self, data: bytes) -> None:
        if len(data) < _HEADER or data[0] != 0 or data[1] > 1:
            raise CdrError(f"no plain CDR: begins with {data[:_HEADER].hex(' ') or 'nothing'}")
        self._data = memoryview(data)[_HEADER:]
        self._order = "<" if data[1] else ">"
        self._at = 0

    def values(self, code: str, count: int = 1) -> NDArray[np.float64]:
        """Return `count` numbers of one kind, `(count,) float64`; `code` is NumPy's, as `f4`."""
        size = int(code[1:])
        start = -(-self._at // size) * size if count else self._at
        end = start + size * count
        if end > len(self._data):
            raise CdrError(f"ends after {len(self._data)} bytes; {end} are needed")
        self._at = end
        return np.frombuffer(self._data[start:end], self._order + code).astype(np.float64)

    def number(self, code: str) -> float:
        """Return one number."""
        return float(self.values(code)[0])

    def length(self) -> int:
        """Return the length of a sequence or string."""
        start = -(-self._at // 4) * 4
        if start + 4 > len(self._data):
            raise CdrError(f"ends after {len(self._data)} bytes; {start + 4} are needed")
        self._at = start + 4
        return int(struct.unpack_from(f"{self._order}I", self._data, start)[0])

    def text(self) -> str:
        """Return a string."""
        count = self.length()
        end = self._at + count
        if end > len(self._data):
            raise CdrError(f"ends after {len(self._data)} bytes; {end} are needed")
        raw = bytes(self._data[self._at : end])
        self._at = end
        return raw.rstrip(b"\0").decode("utf-8", "replace")

    def stamp(self) -> float:
        """Return a Time [s]."""
        sec, nanosec = self.number("i4"), self.number("u4")
        return sec + nanosec / 1e9

    def planar(self) -> tuple[SE2, bool]:
        """Return the planar part of a translation and a quaternion, and if z points down."""
        x, y, _, *rotation = (float(value) for value in self.values("f8", 7))
        try:
            return SE2(x, y, yaw_of(*rotation)), is_upside_down(*rotation)
        except ValueError as error:
            raise CdrError(str(error)) from error


def read_scan(data: bytes) -> tuple[Scan, str]:
    """Return a sensor_msgs/LaserScan as a scan, the sensor at the base, and its frame.

    Raises:
        CdrError: The bytes are no such message.
    """
    reader = CdrReader(data)
    stamp, frame = reader.stamp(), reader.text()
    angle_min, _, increment, time_increment, _, range_min, range_max = (
        float(value) for value in reader.values("f4", 7)
    )
    ranges = reader.values("f4", reader.length())
    scan = Scan(ranges, angle_min, increment, range_min, range_max, stamp, time_increment)
    return scan, frame.lstrip("/")


def read_odometry(data: bytes) -> StampedTransform:
    """Return a nav_msgs/Odometry's pose.

    Raises:
        CdrError: The bytes are no such message.
    """
    return _transform(CdrReader(data))


def read_transforms(data: bytes) -> list[StampedTransform]:
    """Return the transforms of a tf2_msgs/TFMessage.

    Raises:
        CdrError: The bytes are no such message.
    """
    reader = CdrReader(data)
    return [_transform(reader) for _ in range(reader.length())]


def _transform(reader: CdrReader) -> StampedTransform:
    stamp, parent, child = reader.stamp(), reader.text(), reader.text()
    return StampedTransform(stamp, parent.lstrip("/"), child.lstrip("/"), *reader.planar())
