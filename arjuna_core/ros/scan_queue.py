"""Scans that wait for the transforms at their stamp."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import Any

from arjuna_core.ros.convert import scan_from_msg, seconds
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2

_LENGTH = 10  # as nav2_amcl's message filter
_TELL_EVERY = 1000  # of the scans lost, so that a log stays readable
_FRAME_PATIENCE = 1.0  # [s] in which the robot's frames appear, after its first scan


class ScanQueue:
    """Pairs scans with the robot's pose at their stamp, in order; drops those it can never pair.

    Args:
        node: The node that uses the scans.
        fixed_frame: Frame in which the robot's pose is wanted, such as odom.
        base_frame: Frame of the robot's base.
        length: How many scans may wait.
        parameter: The node's parameter that names the base's frame.

    Attributes:
        dropped: How many scans were dropped.
    """

    def __init__(
        self,
        node: ManagedNode,
        fixed_frame: str,
        base_frame: str,
        length: int = _LENGTH,
        parameter: str = "base_frame",
    ) -> None:
        self._node = node
        self._fixed_frame = fixed_frame
        self._base_frame = base_frame
        self._length = length
        self._parameter = parameter
        self._waiting: deque[Any] = deque()
        self._first: float | None = None
        self._told = False
        self.dropped = 0

    def __len__(self) -> int:
        """Return the number of scans that wait."""
        return len(self._waiting)

    def add(self, message: Any) -> None:
        """Take in a LaserScan message."""
        self._waiting.append(message)
        self._check_base(seconds(message.header.stamp))
        if len(self._waiting) > self._length:
            self._drop("its transform has not come in time")

    def _check_base(self, stamp: float) -> None:
        """Say once that nobody moves the base's frame, what is moved instead, and the cure."""
        self._first = stamp if self._first is None else min(self._first, stamp)
        if self._told or stamp - self._first < _FRAME_PATIENCE:
            return
        problem = self._node.transforms.missing_base(
            self._parameter, self._base_frame, self._fixed_frame
        )
        if problem:
            self._told = True
            self._node.get_logger().error(problem)

    def clear(self) -> None:
        """Forget the scans that wait."""
        self._waiting.clear()

    def ready(self) -> Iterator[tuple[Scan, SE2]]:
        """Yield each scan whose transforms are known, with `T_fixed_base` at its stamp."""
        while self._waiting:
            message = self._waiting[0]
            stamp = seconds(message.header.stamp)
            try:
                T_fixed_base = self._lookup(self._fixed_frame, self._base_frame, stamp)
                T_base_sensor = self._lookup(self._base_frame, message.header.frame_id.lstrip("/"))
            except TransformError as error:
                if not self._passed(stamp):
                    return
                self._drop(str(error))
                continue
            self._waiting.popleft()
            scan = scan_from_msg(message, T_base_sensor)
            frame = message.header.frame_id.lstrip("/")
            hangs = self._node.transforms.upside_down(self._base_frame, frame)
            yield scan.mirrored() if hangs else scan, T_fixed_base

    def _lookup(self, target: str, source: str, stamp: float | None = None) -> SE2:
        return self._node.transforms.lookup(target, source, stamp)

    def _passed(self, stamp: float) -> bool:
        """Whether a pose newer than a stamp is known, so that what lacks will not come."""
        try:
            newest = self._node.transforms.latest_common(self._fixed_frame, self._base_frame)
        except TransformError:
            return False
        return newest > stamp

    def _drop(self, reason: str) -> None:
        """Count a scan that is lost; the first, and each that starts another thousand, is told."""
        message = self._waiting.popleft()
        self.dropped += 1
        if self.dropped % _TELL_EVERY == 1:
            self._node.get_logger().warning(
                f"{self.dropped} scans dropped so far; the last, of "
                f"{seconds(message.header.stamp):.3f} s, at {self._node.now:.3f} s: {reason}"
            )
