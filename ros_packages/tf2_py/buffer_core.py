"""A tree of frames whose transforms change over time, interpolated in between.

Source: Foote, tf: The transform library, 2013. Messages of exceptions are tf2's own.
"""

from __future__ import annotations

import bisect
from typing import Any

from builtin_interfaces.msg import Time as TimeMsg
from geometry_msgs.msg import TransformStamped
from rclpy.duration import Duration
from rclpy.time import Time

from arjuna_core.pose3 import ORIGIN, Pose3
from tf2_py.exceptions import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TransformException,
)

_SECOND = 1_000_000_000
_CACHE = 10 * _SECOND
_UNIT = 1e-3  # by which a quaternion's squared norm may differ from 1; tf2 allows 1e-3 too


class _Frame:
    """A child frame's transforms to its parent, oldest first; stamps in nanoseconds."""

    def __init__(self, parent: str, static: bool, authority: str) -> None:
        self.parent, self.static, self.authority = parent, static, authority
        self.stamps: list[int] = []
        self.poses: list[Pose3] = []

    def insert(self, stamp: int, pose: Pose3, cache: int) -> bool:
        """Take a transform; tell whether it is kept."""
        if self.static:
            self.stamps, self.poses = [0], [pose]
            return True
        if self.stamps and stamp < self.stamps[-1] - cache:
            return False
        at = bisect.bisect_left(self.stamps, stamp)
        if at < len(self.stamps) and self.stamps[at] == stamp:
            self.poses[at] = pose
            return True
        self.stamps.insert(at, stamp)
        self.poses.insert(at, pose)
        drop = bisect.bisect_left(self.stamps, self.stamps[-1] - cache)
        del self.stamps[:drop], self.poses[:drop]
        return True

    def at(self, stamp: int) -> Pose3:
        """Return the transform at a time.

        Raises:
            ExtrapolationException: The time lies outside what is known.
        """
        if self.static:
            return self.poses[0]
        at = bisect.bisect_left(self.stamps, stamp)
        if at < len(self.stamps) and self.stamps[at] == stamp:
            return self.poses[at]
        if at == 0 or at == len(self.stamps):
            where, edge = ("past", "earliest") if at == 0 else ("future", "latest")
            known = self.stamps[0 if at == 0 else -1]
            raise ExtrapolationException(
                f"Lookup would require extrapolation into the {where}.  Requested time "
                f"{stamp / _SECOND:.6f} but the {edge} data is at time {known / _SECOND:.6f}"
            )
        before, after = self.stamps[at - 1], self.stamps[at]
        return self.poses[at - 1].interpolated(self.poses[at], (stamp - before) / (after - before))


class BufferCore:
    """The transforms that were set, and those between any two frames that follow.

    Args:
        cache_time: How long transforms are kept; 10 s by default.
    """

    def __init__(self, cache_time: Duration | None = None) -> None:
        self._cache = _CACHE if cache_time is None else cache_time.nanoseconds
        self._frames: dict[str, _Frame] = {}

    def set_transform(self, transform: TransformStamped, authority: str = "default") -> bool:
        """Take a transform; tell whether it is newer than what is forgotten."""
        return self._set(transform, authority, False)

    def set_transform_static(self, transform: TransformStamped, authority: str = "default") -> bool:
        """Take a transform that holds at all times."""
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
        frame = self._frames.get(child)
        if frame is None or frame.parent != parent or frame.static != static:
            frame = self._frames[child] = _Frame(parent, static, authority)
        stamp = Time.from_msg(transform.header.stamp).nanoseconds
        scale = norm**-0.5
        pose = Pose3((t.x, t.y, t.z), (q.w * scale, q.x * scale, q.y * scale, q.z * scale))
        return frame.insert(stamp, pose, self._cache)

    def lookup_transform_core(
        self, target_frame: str, source_frame: str, time: Time
    ) -> TransformStamped:
        """Return the transform that maps source into target at a time; 0 is the latest.

        Raises:
            LookupException: A frame does not exist.
            ConnectivityException: The frames are not connected.
            ExtrapolationException: The time lies outside what is known.
        """
        target, source = target_frame.lstrip("/"), source_frame.lstrip("/")
        up, down = self._ways(target, source)
        stamp = time.nanoseconds or self._latest(up + down)
        try:
            T_target_source = self._product(up, stamp).inverse() @ self._product(down, stamp)
        except ExtrapolationException as error:
            way = f"when looking up transform from frame [{source}] to frame [{target}]"
            raise ExtrapolationException(f"{error}, {way}") from None
        return _message(T_target_source, target, source, stamp)

    def lookup_transform_full_core(
        self,
        target_frame: str,
        target_time: Time,
        source_frame: str,
        source_time: Time,
        fixed_frame: str,
    ) -> TransformStamped:
        """Return the transform between two times, through a frame that does not move."""
        first = self.lookup_transform_core(fixed_frame, source_frame, source_time)
        second = self.lookup_transform_core(target_frame, fixed_frame, target_time)
        T = _pose(second) @ _pose(first)
        stamp = Time.from_msg(second.header.stamp).nanoseconds
        return _message(T, target_frame, source_frame, stamp)

    def can_transform_core(
        self, target_frame: str, source_frame: str, time: Time
    ) -> tuple[bool, str]:
        """Tell whether a transform is known, and if not, why."""
        for frame, argument in ((target_frame, "target_frame"), (source_frame, "source_frame")):
            if not self._known(frame.lstrip("/")):
                return False, (
                    f'Invalid frame ID "{frame}" passed to canTransform argument {argument}'
                    " - frame does not exist"
                )
        try:
            self.lookup_transform_core(target_frame, source_frame, time)
        except TransformException as error:
            return False, str(error)
        return True, ""

    def clear(self) -> None:
        """Forget all but the static transforms."""
        self._frames = {name: frame for name, frame in self._frames.items() if frame.static}

    def all_frames_as_yaml(self) -> str:
        """Return every frame with its parent, publisher, rate and times, as view_frames has it."""
        lines = []
        for name, frame in sorted(self._frames.items()):
            first, last = frame.stamps[0] / _SECOND, frame.stamps[-1] / _SECOND
            rate = (len(frame.stamps) - 1) / max(last - first, 1e-4)
            lines += [
                f"{name}: ",
                f"  parent: '{frame.parent}'",
                f"  broadcaster: '{frame.authority}'",
                f"  rate: {10000.0 if frame.static else rate:.3f}",
                f"  most_recent_transform: {last:.6f}",
                f"  oldest_transform: {first:.6f}",
                f"  buffer_length: {last - first:.3f}",
            ]
        return "\n".join(lines) + "\n" if lines else "{}"

    def all_frames_as_string(self) -> str:
        """Return every frame with its parent, a line each."""
        rows = sorted(self._frames.items())
        return "".join(f"Frame {name} exists with parent {frame.parent}.\n" for name, frame in rows)

    def _known(self, frame: str) -> bool:
        return frame in self._frames or any(f.parent == frame for f in self._frames.values())

    def _chain(self, frame: str, argument: str) -> list[str]:
        if not self._known(frame):
            raise LookupException(
                f'"{frame}" passed to lookupTransform argument {argument} does not exist. '
            )
        chain = [frame]
        while chain[-1] in self._frames:
            chain.append(self._frames[chain[-1]].parent)
            if len(chain) > len(self._frames) + 1:
                raise LookupException(f"the frames of '{frame}' are their own parents")
        return chain

    def _ways(self, target: str, source: str) -> tuple[list[str], list[str]]:
        """Return the frames from target and from source up to where they meet."""
        up, down = self._chain(target, "target_frame"), self._chain(source, "source_frame")
        if up[-1] != down[-1]:
            raise ConnectivityException(
                f"Could not find a connection between '{target}' and '{source}' because they are "
                "not part of the same tree. Tf has two or more unconnected trees."
            )
        while up and down and up[-1] == down[-1]:
            up.pop()
            down.pop()
        return up, down

    def _latest(self, way: list[str]) -> int:
        moving = [self._frames[name] for name in way if not self._frames[name].static]
        return min((frame.stamps[-1] for frame in moving), default=0)

    def _product(self, way: list[str], stamp: int) -> Pose3:
        pose = ORIGIN
        for name in way:
            pose = self._frames[name].at(stamp) @ pose
        return pose


def _pose(message: TransformStamped) -> Pose3:
    t, q = message.transform.translation, message.transform.rotation
    return Pose3((t.x, t.y, t.z), (q.w, q.x, q.y, q.z))


def _message(pose: Pose3, parent: str, child: str, stamp: int) -> Any:
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.header.stamp = TimeMsg(sec=stamp // _SECOND, nanosec=stamp % _SECOND)
    t, q = message.transform.translation, message.transform.rotation
    t.x, t.y, t.z = pose.position
    q.w, q.x, q.y, q.z = pose.quaternion
    return message
