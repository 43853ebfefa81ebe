"""Transforms over time: the one tree of frames, planar for algorithms and in space for the rest.

Source: Foote, tf: The transform library, 2013.
"""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from arjuna_core.errors import ArjunaError
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_core.se2 import IDENTITY, SE2, is_upside_down

LATEST = None
T = TypeVar("T", SE2, Pose3)


class TransformError(ArjunaError):
    """A transform is unknown; the message names the frames."""


class LoopError(TransformError):
    """A frame is its own ancestor."""


class ExtrapolationError(TransformError):
    """A transform is unknown at a time; `known` is the nearest end of the known times."""

    def __init__(self, edge: str, stamp: float, known: float) -> None:
        Exception.__init__(self, edge, stamp, known)
        self.stamp, self.known = stamp, known

    def __str__(self) -> str:
        """Return the message; it is raised often where a transform is waited for, seldom read."""
        edge, stamp, known = self.args
        side = "oldest" if stamp < known else "newest"
        return (
            f"{edge} is asked for at {stamp:.3f} s, "
            f"its {side} is at {known:.3f} s ({abs(stamp - known):.3f} s off)"
        )


class Edge(Generic[T]):
    """The transforms of one child in its parent over time, oldest first."""

    def __init__(self, parent: str, static: bool) -> None:
        self.parent, self.static = parent, static
        self.received = -math.inf  # when, by the clock of who receives
        self.contested = -math.inf  # when one that moves came last for this static one
        self.stamps: list[float] = []
        self.transforms: list[T] = []

    def insert(self, stamp: float, transform: T, duration: float) -> bool:
        """Add a transform; return False where it is older than what is kept."""
        if self.static:
            self.stamps, self.transforms = [stamp], [transform]
            return True
        if self.stamps and stamp < self.stamps[-1] - duration:
            return False
        index = bisect.bisect_left(self.stamps, stamp)
        if index < len(self.stamps) and self.stamps[index] == stamp:
            self.transforms[index] = transform
            return True
        self.stamps.insert(index, stamp)
        self.transforms.insert(index, transform)
        oldest = self.stamps[-1] - duration
        if self.stamps[0] < oldest:
            keep = bisect.bisect_left(self.stamps, oldest)
            del self.stamps[:keep], self.transforms[:keep]
        return True

    def at(self, child: str, stamp: float, early: float = 0.0, late: float = 0.0) -> T:
        """Return the transform at a time; see `TransformTree.lookup`."""
        if self.static:
            return self.transforms[0]
        if stamp == self.stamps[-1]:  # as mostly
            return self.transforms[-1]
        index = bisect.bisect_left(self.stamps, stamp)
        if index < len(self.stamps) and self.stamps[index] == stamp:
            return self.transforms[index]
        if index == 0 or index == len(self.stamps):
            end = 0 if index == 0 else -1
            known = self.stamps[end]
            if known - early <= stamp <= known + late:
                return self.transforms[end]
            raise ExtrapolationError(f"{self.parent} -> {child}", stamp, known)
        before, after = self.stamps[index - 1], self.stamps[index]
        ratio = (stamp - before) / (after - before)
        return self.transforms[index - 1].interpolate(self.transforms[index], ratio)


@dataclass(frozen=True)
class Branch(Generic[T]):
    """The frames from one up to another above it, that one excluded.

    Attributes:
        fixed: Those at the lower end that are static in their parents.
        T_top_frame: Their product; what follows goes in front.
        rest: The others with their transforms, from below.
    """

    fixed: tuple[str, ...]
    T_top_frame: T
    rest: tuple[tuple[str, Edge[T]], ...]

    @property
    def frames(self) -> tuple[str, ...]:
        """All of them, from below."""
        return self.fixed + tuple(child for child, _ in self.rest)

    def at(self, stamp: float, early: float = 0.0, late: float = 0.0) -> T:
        """Return the lowest frame's transform in the upper one; see `TransformTree.lookup`."""
        result = self.T_top_frame
        for child, edge in self.rest:
            result = edge.at(child, stamp, early, late) @ result
        return result


class TransformTree(Generic[T]):
    """A tree of frames whose transforms change over time, interpolated in between.

    Args:
        identity: The transform of a frame in itself.
        duration: Time of which transforms are kept; its unit is that of all stamps.
        jump: A stamp that lies so far behind its frame's newest is of another run, which does not
            mix with this one: what moves is forgotten.
    """

    # [s]: for so long after its last transform a frame that moves keeps its parent; so far a stamp
    # may be ahead of the clock, and a clock from stamps that are judged by it; see `admit`.
    _living, _ahead = 5.0, 10.0

    def __init__(self, identity: T, duration: float = 30.0, jump: float = 1.0) -> None:
        self._identity: T = identity
        self._duration, self._jump = duration, jump
        self._edges: dict[str, Edge[T]] = {}
        self._branches: dict[tuple[str, str], tuple[Branch[T], Branch[T]]] = {}

    @property
    def edges(self) -> Mapping[str, Edge[T]]:
        """The transforms to its parent of each frame that has one."""
        return self._edges

    def clear(self) -> None:
        """Forget every transform that is not static; those that are may get another parent."""
        self._edges = {child: edge for child, edge in self._edges.items() if edge.static}
        self._branches.clear()
        for edge in self._edges.values():
            edge.received = -math.inf

    def admit(self, parent: str, child: str, stamp: float, static: bool, now: float) -> str:
        """Return why a transform may not be added now; "" where it may, dead rivals removed.

        A living frame keeps its parent, and living frames are closed to no loop: one that is
        static, or of which a transform was `received` lately. A static one gives way to one that
        moves from its second transform on, as in tf2 from the first. One that moves takes no stamp
        of another time while the clock runs on; a clock that is not known yet judges none.
        """
        edge = self._edges.get(child)
        if not static and 0.0 < now < stamp - self._ahead:
            return f"'{child}' in '{parent}' is stamped {stamp - now:.1f} s ahead of the clock"
        if edge is not None and (edge.parent, edge.static) == (parent, static):
            return "" if static else self._admit_stamp(edge, child, stamp, now)
        if edge is not None and self._lives(edge, now):
            if edge.parent != parent:
                return f"'{child}' has the parent '{edge.parent}', so not '{parent}' too"
            if static:
                return f"'{child}' in '{parent}' is one that moves, so not static too"
            before, edge.contested = edge.contested, now
            if not 0.0 <= now - before <= self._living:
                return (
                    f"'{child}' in '{parent}' is static; one that moves replaces it if it goes on"
                )
            return ""
        above: list[str] = self.chain(parent)
        if child not in above:
            return ""
        between: list[str] = above[: above.index(child)]
        gone = [frame for frame in between if not self._lives(self._edges[frame], now)]
        if not gone:
            return f"frames would form a loop: {' -> '.join([child, *above[: len(between) + 1]])}"
        for frame in gone:
            del self._edges[frame]
        self._branches.clear()
        return ""

    def _admit_stamp(self, edge: Edge[T], child: str, stamp: float, now: float) -> str:
        newest = edge.stamps[-1]
        if stamp >= newest - self._jump or abs(now - newest) > self._ahead:
            return ""
        if stamp < now - self._jump:
            return f"'{child}' in '{edge.parent}' is {newest - stamp:.1f} s older than its newest"
        del self._edges[child]  # what is ahead of the clock is of no use, all else is still true
        self._branches.clear()
        return ""

    def _lives(self, edge: Edge[T], now: float) -> bool:
        if edge.static:
            return edge.received > -math.inf
        return -self._jump <= now - edge.received <= self._living

    def insert(
        self,
        parent: str,
        child: str,
        stamp: float,
        transform: T,
        static: bool = False,
        *,
        received: float = -math.inf,
    ) -> bool:
        """Add `T_parent_child`; a child with a new parent forgets the old one.

        Args:
            static: Whether it holds for all time.
            received: When it came; see `admit`.

        Returns:
            False where it is older than what is kept.
        """
        edge = self._edges.get(child)
        if edge and not (static or edge.static) and stamp < edge.stamps[-1] - self._jump:
            self.clear()
            edge = None
        if edge is None or edge.parent != parent or edge.static != static:
            edge = self._edges[child] = Edge(parent, static)
            self._branches.clear()
        elif static:
            self._branches.clear()
        edge.received = received
        return edge.insert(stamp, transform, self._duration)

    def rigid_root(self, frame: str) -> str:
        """Return the highest frame that static transforms join to one, itself if there is none."""
        for one in self.chain(frame):
            if one not in self._edges or not self._edges[one].static:
                return one
        return frame

    def knows(self, frame: str) -> bool:
        """Return whether a frame is in the tree."""
        return frame in self._edges or any(edge.parent == frame for edge in self._edges.values())

    def chain(self, frame: str) -> list[str]:
        """Return a frame and its ancestors.

        Raises:
            LoopError: It is one of them.
        """
        chain: list[str] = [frame]
        while chain[-1] in self._edges:
            parent = self._edges[chain[-1]].parent
            if parent in chain:
                raise LoopError(f"frames form a loop: {' -> '.join([*chain, parent])}")
            chain.append(parent)
        return chain

    def _legs(self, target: str, source: str) -> tuple[list[str], list[str]]:
        target_chain, source_chain = self.chain(target), self.chain(source)
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

    def _between(self, target: str, source: str) -> tuple[Branch[T], Branch[T]]:
        """Return the branches of two frames up to the first that both are below; they are kept."""
        found = self._branches.get((target, source))
        if found is None:
            up, down = self._legs(target, source)
            found = self._branches[target, source] = self._branch(up), self._branch(down)
        return found

    def _branch(self, frames: Sequence[str]) -> Branch[T]:
        edges = tuple((frame, self._edges[frame]) for frame in frames)
        count = sum(1 for _ in itertools.takewhile(lambda one: one[1].static, edges))
        product = Branch((), self._identity, edges[:count]).at(0.0)
        return Branch(tuple(frames[:count]), product, edges[count:])

    def latest_common(self, target: str, source: str) -> float:
        """Return the newest time at which `lookup(target, source)` is known; 0 if static.

        Raises:
            TransformError: The frames are not connected.
        """
        up, down = self._between(target, source)
        stamps = [edge.stamps[-1] for _, edge in up.rest + down.rest if not edge.static]
        return min(stamps, default=0.0)

    def lookup(
        self,
        target: str,
        source: str,
        stamp: float | None = LATEST,
        early: float = 0.0,
        late: float = 0.0,
    ) -> T:
        """Return `T_target_source` at a time.

        Args:
            stamp: The time; None for the newest at which it is known.
            early: Time before a frame's oldest transform at which that one stands in.
            late: Time after a frame's newest transform at which that one stands in.

        Raises:
            TransformError: The frames are not connected, or the time is not covered.
        """
        up, down = self._between(target, source)
        when = self.latest_common(target, source) if stamp is None else stamp
        T_top_target = up.at(when, early, late)
        T_top_source = down.at(when, early, late)
        return T_top_target.inverse() @ T_top_source if up.fixed or up.rest else T_top_source

    def try_lookup(self, target: str, source: str, stamp: float | None = LATEST) -> T | None:
        """Return `lookup`, or None where it would raise."""
        try:
            return self.lookup(target, source, stamp)
        except TransformError:
            return None


class TransformBuffer(TransformTree[SE2]):
    """The planar tree of frames that algorithms use; stamps in seconds."""

    def __init__(self) -> None:
        super().__init__(IDENTITY)
        self._mounts: dict[str, Pose3] = {}
        self._fixed_mounts: dict[tuple[str, ...], Pose3] = {}

    def insert(
        self,
        parent: str,
        child: str,
        stamp: float,
        transform: SE2,
        static: bool = False,
        mount: Pose3 | None = None,
        *,
        received: float = -math.inf,
    ) -> bool:
        """Add `T_parent_child`; see `TransformTree.insert`.

        Args:
            mount: The same transform in space; None for an upright one at no height.
        """
        if static:
            self._fixed_mounts.clear()
        self._mounts.pop(child, None)
        if mount is not None:
            self._mounts[child] = mount
        return super().insert(parent, child, stamp, transform, static, received=received)

    def base_below(self, fixed: str) -> str | None:
        """Return the frame that moves in a fixed frame and carries something: the robot's base."""
        moving = [f for f, edge in self._edges.items() if edge.parent == fixed and not edge.static]
        for frame in moving:
            if any(edge.static for edge in self._edges.values() if edge.parent == frame):
                return frame
        below = (self.base_below(frame) for frame in moving)
        return next((frame for frame in below if frame is not None), next(iter(moving), None))

    def missing_base(self, parameter: str, base: str, fixed: str) -> str:
        """Return that a robot's frame is missing, with the remedy; "" where it exists."""
        if self.knows(base):
            return ""
        instead = self.base_below(fixed)
        remedy = (
            f"'{fixed}' carries '{instead}'; set {parameter}: {instead}, or start it with"
            f" --base-frame {instead}"
            if instead is not None
            else f"nothing moves in '{fixed}' either: is odometry's transform on /tf?"
        )
        return f"{parameter} is '{base}', a frame that does not exist: {remedy}"

    def upside_down(self, target: str, source: str) -> bool:
        """Return whether the source's z axis points down in the target.

        Raises:
            TransformError: The frames are not connected.
        """
        up, down = self._between(target, source)
        mounts = [self._mounts[one] for one in up.frames + down.frames if one in self._mounts]
        turns = [mount.quaternion for mount in mounts]
        return sum(is_upside_down(x, y, z, w) for w, x, y, z in turns) % 2 == 1

    def mount(self, target: str, source: str) -> Pose3:
        """Return the newest transform in space, of frames that hardly move in each other.

        Raises:
            TransformError: The frames are not connected.
        """
        up, down = self._between(target, source)
        T_top_source = self._mounted(down)
        return self._mounted(up).inverse() @ T_top_source if up.frames else T_top_source

    def _mounted(self, branch: Branch[SE2]) -> Pose3:
        result = self._fixed_mounts.get(branch.fixed)
        if result is None:
            result = ORIGIN
            for frame in branch.fixed:
                result = self._mount_of(frame) @ result
            self._fixed_mounts[branch.fixed] = result
        for frame, _ in branch.rest:
            result = self._mount_of(frame) @ result
        return result

    def _mount_of(self, frame: str) -> Pose3:
        mount = self._mounts.get(frame)
        return Pose3.from_se2(self._edges[frame].transforms[-1]) if mount is None else mount
