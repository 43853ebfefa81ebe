"""The tree of frames in space: what stands where, now or a moment ago."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from arjuna_core.pose3 import ORIGIN, Pose3

_HISTORY = 256  # transforms of a frame: some seconds of odometry
_JUMP = 1.0  # back in time, which is another run [s]
_LATE = 0.05  # a pose may be older than its stamp by so much: half a period of a slow odometry [s]
_DEEPEST = 100


@dataclass
class _Edge:
    """The newest transforms of a child in its parent, oldest first."""

    parent: str
    static: bool
    poses: deque[tuple[float, Pose3]] = field(default_factory=lambda: deque(maxlen=_HISTORY))

    def at(self, stamp: float | None) -> Pose3 | None:
        """Return the pose at a time: the last not younger, or the oldest; None before it comes."""
        if stamp is not None and not self.static:
            if stamp > self.poses[-1][0] + _LATE:
                return None
            for time, pose in reversed(self.poses):
                if time <= stamp:
                    return pose
            return self.poses[0][1]
        return self.poses[-1][1]


class Frames:
    """A tree of frames for drawing: never interpolates, answers with the nearest there is.

    `arjuna_core.transforms` is the planar one that algorithms use.

    Args:
        fixed: The frame that everything is drawn in, once it is known.
    """

    def __init__(self, fixed: str) -> None:
        self._wanted = fixed
        self._edges: dict[str, _Edge] = {}

    def insert(self, parent: str, child: str, stamp: float, pose: Pose3, static: bool) -> None:
        """Add `T_parent_child` at a time [s]; time that is set back clears what moves."""
        edge = self._edges.get(child)
        moved_back = edge is not None and not static and stamp < edge.poses[-1][0] - _JUMP
        if moved_back:
            self._edges = {name: edge for name, edge in self._edges.items() if edge.static}
        if edge is None or moved_back or edge.parent != parent or edge.static != static:
            edge = self._edges[child] = _Edge(parent, static)
        edge.poses.append((stamp, pose))

    @property
    def parents(self) -> dict[str, str]:
        """The parent of each frame that has one."""
        return {child: edge.parent for child, edge in self._edges.items()}

    def chain(self, frame: str) -> list[str]:
        """Return a frame and what it hangs on, up to its root."""
        chain = [frame]
        while (edge := self._edges.get(chain[-1])) is not None and len(chain) < _DEEPEST:
            chain.append(edge.parent)
        return chain

    def local(self, frame: str) -> Pose3:
        """Return a frame's newest pose in its parent, or the origin for a root."""
        edge = self._edges.get(frame)
        return ORIGIN if edge is None else edge.poses[-1][1]

    @property
    def fixed(self) -> str | None:
        """The frame to draw in: the wanted one, else the root most frames hang on, or None."""
        if self._wanted in self._edges or self._wanted in self.parents.values():
            return self._wanted
        roots = [self.chain(frame)[-1] for frame in self._edges]
        return max(sorted(set(roots)), key=roots.count) if roots else None

    def pose(self, frame: str, stamp: float | None = None) -> Pose3 | None:
        """Return `T_fixed_frame` at a time [s], the newest for None; None where unknown yet."""
        fixed = self.fixed
        if fixed is None or self.chain(fixed)[-1] != self.chain(frame)[-1]:
            return None
        T_root_fixed, T_root_frame = self._from_root(fixed, stamp), self._from_root(frame, stamp)
        if T_root_fixed is None or T_root_frame is None:
            return None
        return T_root_fixed.inverse() @ T_root_frame

    def _from_root(self, frame: str, stamp: float | None) -> Pose3 | None:
        pose = ORIGIN
        for name in self.chain(frame)[:-1]:
            at = self._edges[name].at(stamp)
            if at is None:
                return None
            pose = at @ pose
        return pose
