"""Transforms over time: a tree of planar frames that interpolates."""

from __future__ import annotations

import bisect
from collections.abc import Sequence

from arjuna_core.errors import ArjunaError
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import IDENTITY, SE2

LATEST = None
_DURATION = 30.0  # that is kept; tf2 keeps 10 s by default [s]
_JUMP = 1.0  # back in time: more is another run, less is a late message [s]


class TransformError(ArjunaError):
    """A transform is not known at the asked time; the message says which frame and by how much."""


class _Edge:
    """The transforms of one child in its parent over time, oldest first."""

    def __init__(self, parent: str, static: bool) -> None:
        self.parent = parent
        self.static = static
        self.upside_down = False
        self.mount: Pose3 | None = None
        self.stamps: list[float] = []
        self.transforms: list[SE2] = []

    def jumped_back(self, stamp: float) -> bool:
        return not self.static and bool(self.stamps) and stamp < self.stamps[-1] - _JUMP

    def insert(self, stamp: float, transform: SE2) -> None:
        if self.static:
            self.stamps, self.transforms = [stamp], [transform]
            return
        index = bisect.bisect_left(self.stamps, stamp)
        if index < len(self.stamps) and self.stamps[index] == stamp:
            self.transforms[index] = transform
            return
        self.stamps.insert(index, stamp)
        self.transforms.insert(index, transform)
        if self.stamps[-1] - self.stamps[0] > 2.0 * _DURATION:
            keep = bisect.bisect_left(self.stamps, self.stamps[-1] - _DURATION)
            del self.stamps[:keep], self.transforms[:keep]

    def at(self, child: str, stamp: float) -> SE2:
        if self.static:
            return self.transforms[0]
        index = bisect.bisect_left(self.stamps, stamp)
        if index < len(self.stamps) and self.stamps[index] == stamp:
            return self.transforms[index]
        if index == 0 or index == len(self.stamps):
            edge = self.stamps[0] if index == 0 else self.stamps[-1]
            side = "oldest" if index == 0 else "newest"
            raise TransformError(
                f"{self.parent} -> {child} is asked for at {stamp:.3f} s, "
                f"its {side} is at {edge:.3f} s ({abs(stamp - edge):.3f} s off)"
            )
        before, after = self.stamps[index - 1], self.stamps[index]
        ratio = (stamp - before) / (after - before)
        return self.transforms[index - 1].interpolate(self.transforms[index], ratio)


class TransformBuffer:
    """A tree of planar transforms over time: interpolates, never extrapolates.

    A stamp that lies over a second behind its frame's newest clears it, so that a restarted
    simulation does not mix with the one before.
    """

    def __init__(self) -> None:
        self._edges: dict[str, _Edge] = {}

    def clear(self) -> None:
        """Forget every transform that is not static."""
        self._edges = {child: edge for child, edge in self._edges.items() if edge.static}

    def insert(
        self,
        parent: str,
        child: str,
        stamp: float,
        transform: SE2,
        static: bool = False,
        upside_down: bool = False,
        mount: Pose3 | None = None,
    ) -> None:
        """Add `T_parent_child` at a time [s]; a child with a new parent forgets the old one.

        Args:
            parent: Frame mapped into.
            child: Frame mapped from.
            stamp: Time [s].
            transform: The planar part.
            static: Whether it holds for all time.
            upside_down: Whether the child's z axis points down in the parent.
            mount: The same transform in space, for `mount`; None for an upright one at no height.
        """
        edge = self._edges.get(child)
        if edge is not None and not static and edge.jumped_back(stamp):
            self.clear()
            edge = None
        if edge is None or edge.parent != parent or edge.static != static:
            edge = self._edges[child] = _Edge(parent, static)
        edge.upside_down, edge.mount = upside_down, mount
        edge.insert(stamp, transform)

    def knows(self, frame: str) -> bool:
        """Tell whether a frame is in the tree."""
        return frame in self._edges or any(edge.parent == frame for edge in self._edges.values())

    def base_below(self, fixed: str) -> str | None:
        """Return the frame that moves in a fixed frame and carries something: the robot's base.

        Args:
            fixed: Such as `odom`, or `map` above it.
        """
        moving = [f for f, edge in self._edges.items() if edge.parent == fixed and not edge.static]
        for frame in moving:
            if any(edge.static for edge in self._edges.values() if edge.parent == frame):
                return frame
        below = (self.base_below(frame) for frame in moving)
        return next((frame for frame in below if frame is not None), next(iter(moving), None))

    def missing_base(self, parameter: str, base: str, fixed: str) -> str:
        """Say that a robot's frame is not there, what is there instead, and the cure.

        Args:
            parameter: What names the frame.
            base: The frame that it names.
            fixed: The frame in which the robot moves.

        Returns:
            A sentence; empty where the frame is there.
        """
        if self.knows(base):
            return ""
        instead = self.base_below(fixed)
        cure = (
            f"'{fixed}' carries '{instead}'; set {parameter}: {instead}, or start it with"
            f" --base-frame {instead}"
            if instead is not None
            else f"nothing moves in '{fixed}' either: is odometry's transform on /tf?"
        )
        return f"{parameter} is '{base}', a frame that does not exist: {cure}"

    def _chain(self, frame: str) -> list[str]:
        chain = [frame]
        while chain[-1] in self._edges:
            parent = self._edges[chain[-1]].parent
            if parent in chain:
                raise TransformError(f"frames form a loop: {' -> '.join([*chain, parent])}")
            chain.append(parent)
        return chain

    def latest_common(self, target: str, source: str) -> float:
        """Return the newest time [s] at which `lookup(target, source)` is known; 0 if static.

        Raises:
            TransformError: The frames are not connected.
        """
        up, down = self._legs(target, source)
        stamps = [self._edges[f].stamps[-1] for f in up + down if not self._edges[f].static]
        return min(stamps, default=0.0)

    def _legs(self, target: str, source: str) -> tuple[list[str], list[str]]:
        target_chain, source_chain = self._chain(target), self._chain(source)
        common = next((frame for frame in target_chain if frame in source_chain), None)
        if common is None:
            known = sorted({*self._edges, *(edge.parent for edge in self._edges.values())})
            raise TransformError(
                f"no transform connects '{target}' and '{source}'; "
                f"known frames: {', '.join(known) or 'none'}"
            )
        up = target_chain[: target_chain.index(common)]
        down = source_chain[: source_chain.index(common)]
        return up, down

    def upside_down(self, target: str, source: str) -> bool:
        """Tell whether the source's z axis points down in the target; chains must be known.

        Raises:
            TransformError: The frames are not connected.
        """
        up, down = self._legs(target, source)
        return sum(self._edges[frame].upside_down for frame in up + down) % 2 == 1

    def mount(self, target: str, source: str) -> Pose3:
        """Return the newest transform in space, of frames that hardly move in each other.

        Raises:
            TransformError: The frames are not connected.
        """
        up, down = self._legs(target, source)
        return self._mounted(up).inverse() @ self._mounted(down)

    def _mounted(self, frames: Sequence[str]) -> Pose3:
        result = Pose3()
        for frame in frames:
            edge = self._edges[frame]
            result = (edge.mount or Pose3.from_se2(edge.transforms[-1])) @ result
        return result

    def lookup(self, target: str, source: str, stamp: float | None = LATEST) -> SE2:
        """Return `T_target_source` at a time.

        Args:
            target: Frame to map into.
            source: Frame to map from.
            stamp: Time [s]; None for the newest time at which it is known.

        Raises:
            TransformError: The frames are not connected, or the time is not covered.
        """
        up, down = self._legs(target, source)
        when = self.latest_common(target, source) if stamp is None else stamp
        return self._compose(up, when).inverse() @ self._compose(down, when)

    def _compose(self, frames: Sequence[str], stamp: float) -> SE2:
        result = IDENTITY
        for frame in frames:
            result = self._edges[frame].at(frame, stamp) @ result
        return result

    def try_lookup(self, target: str, source: str, stamp: float | None = LATEST) -> SE2 | None:
        """Return `lookup`, or None where it would raise."""
        try:
            return self.lookup(target, source, stamp)
        except TransformError:
            return None
