"""Scans and other readings of sensors that wait for the transforms at their stamp."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from typing import Any, Generic, TypeVar

from arjuna_core.ros.convert import scan_from_msg, seconds
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformBuffer, TransformError
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2

T = TypeVar("T")


class BaseFrames:
    """The frames that a node needs the robot's pose of; says once what is wrong with them.

    Args:
        parameter: The node's parameter that names the base's frame.
        adopt: Whether the frame that moves in the fixed one is taken where the base's is missing.
    """

    def __init__(
        self,
        node: ManagedNode,
        fixed: str,
        base: str,
        parameter: str = "base_frame",
        adopt: bool = False,
    ) -> None:
        self.node, self.fixed, self.base = node, fixed, base
        self._parameter, self._adopt = parameter, adopt
        self._first: float | None = None
        self._reported = False

    def pose(self, stamp: float) -> SE2:
        """Return `T_fixed_base` at a time [s].

        Raises:
            TransformError: It is not known.
        """
        return self.node.transforms.lookup(self.fixed, self.base, stamp)

    def look(self, stamp: float) -> None:
        """Log that nobody moves the base, and the remedy, once a message of a time [s] has come."""
        self._first = stamp if self._first is None else min(self._first, stamp)
        waited = stamp - self._first
        # The robot's frames appear within 1 s after the first message.
        if self._reported or waited < 1.0:
            return
        problem = self.node.transforms.missing_base(self._parameter, self.base, self.fixed)
        if problem:
            there = self.node.transforms.base_below(self.fixed) if self._adopt else None
            if there is None:
                self._reported = True
                self.node.get_logger().error(problem)
            # After 3 s the existing frame replaces the one that is missing.
            elif waited >= 3.0:
                self._take(there)

    def _take(self, there: str) -> None:
        self._reported = True
        self.node.get_logger().warning(
            f"{self._parameter} is '{self.base}', a frame that does not exist: '{there}' moves in"
            f" '{self.fixed}' and is used; set {self._parameter}: {there}"
        )
        self.base = there


class PosedQueue(Generic[T]):
    """Reads what sensors see with the robot's pose at its stamp, in order; drops what it never can.

    Args:
        frames: Of the robot's pose; several queues of a node share them.
        what: Several of its messages, in a word.
        read: Returns what a message and `T_fixed_base` at its stamp say.
        length: How many may wait.

    Attributes:
        dropped: How many were dropped.
    """

    # 10, as nav2_amcl's message filter.
    def __init__(
        self, frames: BaseFrames, what: str, read: Callable[[Any, SE2], T], length: int = 10
    ) -> None:
        self._frames, self._what, self._read = frames, what, read
        self._node = frames.node
        self._length = length
        self._waiting: deque[Any] = deque()
        self.dropped = 0

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, message: Any) -> None:
        """Take in a message."""
        self._waiting.append(message)
        self._frames.look(seconds(message.header.stamp))
        if len(self._waiting) > self._length:
            self._drop("its transform has not come in time")

    def clear(self) -> None:
        """Forget those that wait."""
        self._waiting.clear()

    def ready(self) -> Iterator[T]:
        """Yield what each says whose transforms are known."""
        while self._waiting:
            message = self._waiting[0]
            stamp = seconds(message.header.stamp)
            try:
                seen = self._read(message, self._frames.pose(stamp))
            except TransformError as error:
                if not self._passed(stamp):
                    return
                self._drop(str(error))
                continue
            self._waiting.popleft()
            yield seen

    def _passed(self, stamp: float) -> bool:
        """Return whether a pose newer than a stamp is known: the missing one will not come."""
        try:
            newest = self._node.transforms.latest_common(self._frames.fixed, self._frames.base)
        except TransformError:
            return False
        return newest > stamp

    def _drop(self, reason: str) -> None:
        """Count what is lost; the first, and each that starts another thousand, is logged."""
        message = self._waiting.popleft()
        self.dropped += 1
        # Every thousandth lost scan is logged, so that the log stays readable.
        if self.dropped % 1000 == 1:
            self._node.get_logger().warning(
                f"{self._what} dropped so far: {self.dropped}; the last, of "
                f"{seconds(message.header.stamp):.3f} s, at {self._node.now:.3f} s: {reason}"
            )


class ScanQueue(PosedQueue[tuple[Scan, SE2]]):
    """Laser scans, each with `T_fixed_base` at its stamp."""

    def __init__(self, frames: BaseFrames, length: int = 10) -> None:
        super().__init__(frames, "scans", self._seen, length)

    def _seen(self, message: Any, T_fixed_base: SE2) -> tuple[Scan, SE2]:
        frames = self._frames
        return scan_seen_from(frames.node.transforms, frames.base, message), T_fixed_base


def scan_seen_from(transforms: TransformBuffer, base: str, message: Any) -> Scan:
    """Return a LaserScan message as a scan of the robot, as it is seen from above.

    Raises:
        TransformError: The sensor's frame is not connected to the base's.
    """
    frame = message.header.frame_id.lstrip("/")
    scan = scan_from_msg(message, transforms.lookup(base, frame))
    return scan.mirrored() if transforms.upside_down(base, frame) else scan
