"""The tree of frames that is drawn: it has an answer wherever there is one near."""

from __future__ import annotations

import math
from typing import Any

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_core.readings import seconds
from arjuna_core.transforms import TransformError, TransformTree
from bringup.viewing.drawing.messages import frame_of, pose3


class Frames(TransformTree[Pose3]):
    """A tree of frames for drawing, in the `wanted` one once it is known.

    Args:
        late: Time after a frame's newest transform at which that one stands in: half a period of
            a slow odometry [s].
    """

    def __init__(self, fixed: str, late: float = 0.05) -> None:
        super().__init__(ORIGIN, duration=10.0)
        self.wanted, self._late = fixed, late

    def take(self, message: Any, static: bool, stamp: float | None = None) -> bool:
        """Insert the transforms of a TFMessage; return whether a frame has a new parent.

        They are of a time [s] of their own unless one is given.
        """
        changed = False
        for each in message.transforms:
            parent, child = frame_of(each), each.child_frame_id.lstrip("/")
            edge = self.edges.get(child)
            changed |= edge is None or edge.parent != parent
            when = seconds(each.header.stamp) if stamp is None else stamp
            self.insert(parent, child, when, pose3(each.transform), static)
        return changed

    @property
    def parents(self) -> dict[str, str]:
        """The parent of each frame that has one."""
        return {child: edge.parent for child, edge in self.edges.items()}

    @property
    def newest(self) -> float:
        """The newest stamp of a moving frame [s]; 0 where none moves."""
        return max((e.stamps[-1] for e in self.edges.values() if not e.static), default=0.0)

    def root(self, frame: str) -> str:
        """Return the last ancestor of a frame; the frame itself where they form a loop."""
        try:
            return self.chain(frame)[-1]
        except TransformError:
            return frame

    @property
    def fixed(self) -> str | None:
        """The frame to draw in: the wanted one, else the root of the most frames, or None."""
        if self.knows(self.wanted):
            return self.wanted
        roots = [self.root(frame) for frame in self.edges]
        return max(sorted(set(roots)), key=roots.count) if roots else None

    def pose(self, frame: str, stamp: float | None = None) -> Pose3 | None:
        """Return `T_fixed_frame` at a time [s], each newest for None; None where unknown yet."""
        fixed = self.fixed
        if fixed is None:
            return None
        when, late = (math.inf, math.inf) if stamp is None else (stamp, self._late)
        try:
            return self.lookup(fixed, frame, when, early=math.inf, late=late)
        except TransformError:
            return None
