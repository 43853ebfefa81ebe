"""tf2's names, messages, exceptions and their texts for `arjuna_core`'s tree of frames."""

from __future__ import annotations

import math
from typing import Any

from builtin_interfaces.msg import Time as TimeMsg
from geometry_msgs.msg import TransformStamped
from rclpy.duration import Duration
from rclpy.time import Time

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_core.ros.convert import pose3_from_transform, transform3_msg
from arjuna_core.timing import NANOSECONDS
from arjuna_core.transforms import ExtrapolationError, LoopError, TransformError, TransformTree


class TransformException(Exception):
    """Any error of tf2."""


class ConnectivityException(TransformException):
    """Two frames are in trees that are not connected."""


class LookupException(TransformException):
    """A frame does not exist."""


class ExtrapolationException(TransformException):
    """A transform is asked for at a time that its data does not reach."""


class InvalidArgumentException(TransformException):
    """An argument is not valid."""


class TimeoutException(TransformException):
    """A transform did not come in time."""


_CACHE = 10 * NANOSECONDS  # tf2's BUFFER_CORE_DEFAULT_CACHE_TIME
_UNIT = 1e-3  # tf2's QUATERNION_NORMALIZATION_TOLERANCE


class BufferCore:
    """The transforms that were set, 10 s of them by default, and those that follow from them."""

    def __init__(self, cache_time: Duration | None = None) -> None:
        cache = _CACHE if cache_time is None else cache_time.nanoseconds
        self._tree = TransformTree(ORIGIN, cache, jump=math.inf)
        self._authorities: dict[str, str] = {}

    def set_transform(self, transform: TransformStamped, authority: str = "default") -> bool:
        """Add a transform; return False where it is older than what is kept."""
        return self._set(transform, authority, False)

    def set_transform_static(self, transform: TransformStamped, authority: str = "default") -> bool:
        """Add a transform that holds at all times."""
        return self._set(transform, authority, True)

    def _set(self, transform: TransformStamped, authority: str, static: bool) -> bool:
        parent = transform.header.frame_id.lstrip("/")
        child = transform.child_frame_id.lstrip("/")
        t, q = transform.transform.translation, transform.transform.rotation
        norm = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z
        if not parent or not child or parent == child:
            raise InvalidArgumentException(f"no transform from '{parent}' to '{child}'")
        if not abs(norm - 1.0) < _UNIT or not all(abs(v) < 1e300 for v in (t.x, t.y, t.z)):
            raise InvalidArgumentException(f"the transform of '{child}' is no rigid motion")
        self._authorities[child] = authority
        stamp = 0 if static else Time.from_msg(transform.header.stamp).nanoseconds
        scale = norm**-0.5
        pose = Pose3((t.x, t.y, t.z), (q.w * scale, q.x * scale, q.y * scale, q.z * scale))
        return self._tree.insert(parent, child, stamp, pose, static)

    def lookup_transform_core(
        self, target_frame: str, source_frame: str, time: Time | TimeMsg
    ) -> TransformStamped:
        """Return the transform that maps source into target at a time; 0 is the latest.

        Raises:
            TypeError: The time is none.
            LookupException: A frame does not exist.
            ConnectivityException: The frames are not connected.
            ExtrapolationException: The time lies outside what is known.
        """
        target, source = target_frame.lstrip("/"), source_frame.lstrip("/")
        for frame, argument in ((target, "target_frame"), (source, "source_frame")):
            if not self._tree.knows(frame):
                problem = f'"{frame}" passed to lookupTransform argument {argument}'
                raise LookupException(f"{problem} does not exist. ")
        try:
            stamp = _nanoseconds(time) or int(self._tree.latest_common(target, source))
            pose = self._tree.lookup(target, source, stamp)
        except ExtrapolationError as error:
            past = error.stamp < error.known
            where, edge = ("past", "earliest") if past else ("future", "latest")
            raise ExtrapolationException(
                f"Lookup would require extrapolation into the {where}.  Requested time "
                f"{error.stamp / NANOSECONDS:.6f} but the {edge} data is at time "
                f"{error.known / NANOSECONDS:.6f}, when looking up transform from frame [{source}] "
                f"to frame [{target}]"
            ) from None
        except LoopError as error:
            raise LookupException(str(error)) from None
        except TransformError:
            raise ConnectivityException(
                f"Could not find a connection between '{target}' and '{source}' because they are "
                "not part of the same tree. Tf has two or more unconnected trees."
            ) from None
        return _message(pose, target, source, stamp)

    def lookup_transform_full_core(
        self,
        target_frame: str,
        target_time: Time | TimeMsg,
        source_frame: str,
        source_time: Time | TimeMsg,
        fixed_frame: str,
    ) -> TransformStamped:
        """Return the transform between two times, through a frame that does not move."""
        first = self.lookup_transform_core(fixed_frame, source_frame, source_time)
        second = self.lookup_transform_core(target_frame, fixed_frame, target_time)
        stamp = Time.from_msg(second.header.stamp).nanoseconds
        T_target_fixed = pose3_from_transform(second.transform)
        T_fixed_source = pose3_from_transform(first.transform)
        return _message(T_target_fixed @ T_fixed_source, target_frame, source_frame, stamp)

    def can_transform_core(
        self, target_frame: str, source_frame: str, time: Time | TimeMsg
    ) -> tuple[bool, str]:
        """Return whether a transform is known, and if not, why."""
        for frame, argument in ((target_frame, "target_frame"), (source_frame, "source_frame")):
            if not self._tree.knows(frame.lstrip("/")):
                return False, (
                    f'Invalid frame ID "{frame}" passed to canTransform argument {argument}'
                    " - frame does not exist"
                )
        try:
            self.lookup_transform_core(target_frame, source_frame, time)
        except TransformException as error:
            return False, str(error)
        return True, ""

    def can_transform_full_core(
        self,
        target_frame: str,
        target_time: Time | TimeMsg,
        source_frame: str,
        source_time: Time | TimeMsg,
        fixed_frame: str,
    ) -> tuple[bool, str]:
        """Return whether a transform between two times is known, and if not, why."""
        known = self.can_transform_core(fixed_frame, source_frame, source_time)
        return (
            self.can_transform_core(target_frame, fixed_frame, target_time) if known[0] else known
        )

    def get_latest_common_time(self, target_frame: str, source_frame: str) -> Time:
        """Return the newest time at which the transform between two frames is known.

        Raises:
            LookupException: A frame does not exist.
            ConnectivityException: The frames are not connected.
        """
        found = self.lookup_transform_core(target_frame, source_frame, Time())
        return Time.from_msg(found.header.stamp)

    def _frameExists(self, frame_id: str) -> bool:
        return self._tree.knows(frame_id.lstrip("/"))

    def _getFrameStrings(self) -> list[str]:
        edges = self._tree.edges
        return sorted({*edges, *(edge.parent for edge in edges.values())})

    def clear(self) -> None:
        self._tree.clear()

    def all_frames_as_yaml(self) -> str:
        """Return every frame with its parent, publisher, rate and times, as view_frames has it."""
        lines = []
        for name, edge in sorted(self._tree.edges.items()):
            first, last = edge.stamps[0] / NANOSECONDS, edge.stamps[-1] / NANOSECONDS
            rate = (len(edge.stamps) - 1) / max(last - first, 1e-4)
            lines += [
                f"{name}: ",
                f"  parent: '{edge.parent}'",
                f"  broadcaster: '{self._authorities[name]}'",
                f"  rate: {10000.0 if edge.static else rate:.3f}",
                f"  most_recent_transform: {last:.6f}",
                f"  oldest_transform: {first:.6f}",
                f"  buffer_length: {last - first:.3f}",
            ]
        return "\n".join(lines) + "\n" if lines else "{}"

    def all_frames_as_string(self) -> str:
        """Return every frame with its parent, a line each."""
        rows = sorted(self._tree.edges.items())
        return "".join(f"Frame {name} exists with parent {edge.parent}.\n" for name, edge in rows)


def _nanoseconds(time: Any) -> int:
    """Return a time [ns], rclpy's or the stamp of a message, which tf2 takes alike."""
    if hasattr(time, "sec") and hasattr(time, "nanosec"):
        return int(time.sec) * NANOSECONDS + int(time.nanosec)
    if hasattr(time, "nanoseconds"):
        return int(time.nanoseconds)
    raise TypeError("time must have sec and nanosec, or nanoseconds.")


def _message(pose: Pose3, parent: str, child: str, stamp: int) -> Any:
    message = transform3_msg(pose, parent, child, 0.0)
    message.header.stamp = TimeMsg(sec=stamp // NANOSECONDS, nanosec=stamp % NANOSECONDS)
    return message
