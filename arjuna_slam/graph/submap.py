"""Submaps: overlapping runs of keyframes, each with a field in its first keyframe's frame."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Bytes, Floats, Ints, Singles
from arjuna_core.config import length_param, param
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.surface import Surface

_NONE = np.zeros((3, 3))
_POST_DISTANCE = (
    4.0  # distance after which keyframes are tied to a nearer one, with which they share more
)


@dataclass(frozen=True, eq=False)
class PackedField:
    """The cells of a field that hold anything, row by row."""

    resolution: float  # edge of a cell [m]
    sigma: float  # of the field [m]
    origin: Floats  # outer corner of cell (0, 0), `(2,) float64` [m]
    shape: tuple[int, int]  # rows and columns
    cells: NDArray[np.int32]  # their numbers, `(N,) int32`
    score: Bytes  # their likelihoods, `(N,) uint8`
    surface: Bools  # which of them have sums of a surface, `(N,) bool`
    # those sums in their order after a row for none, `(K + 1, 4) float32`
    planes: Singles

    @staticmethod
    def of(field: Field) -> PackedField:
        """Return what a field holds."""
        cells = np.flatnonzero(field.score).astype(np.int32)
        rows = field.index.ravel()[cells]
        planes = field.planes[np.concatenate(([0], rows[rows > 0]))]
        height, width = field.score.shape
        return PackedField(
            field.resolution, field.sigma, field.origin, (height, width),
            cells, field.score.ravel()[cells], rows > 0, planes,
        )  # fmt: skip

    def unpacked(self) -> Field:
        """Return the field; nothing is to be added to it."""
        field = Field(self.resolution, self.sigma)
        field.origin, field.planes = self.origin, self.planes
        field.score = np.zeros(self.shape, np.uint8)
        field.score.ravel()[self.cells] = self.score
        count = len(self.planes)
        small = count <= np.iinfo(np.uint16).max + 1
        field.index = np.zeros(self.shape, np.uint16 if small else np.int32)
        field.index.ravel()[self.cells[self.surface]] = np.arange(1, count)
        return field


@dataclass(frozen=True)
class SubmapConfig:
    """Parameters of submaps and their fields."""

    max_laser_range: float = length_param(20.0, "Longest range used.", minimum=0.1)
    submap_size: int = param(40, "Keyframes in a submap.", minimum=2, maximum=10000)
    submap_length: float = length_param(
        12.0, "Way on which a submap's keyframes lie at most.", minimum=0.1, maximum=1e4
    )
    field_resolution: float = length_param(
        0.05, "Edge of a cell of the matching field.", minimum=0.005, maximum=0.5
    )
    field_deviation: float = length_param(
        0.05, "Deviation around a reference point.", minimum=0.005, maximum=0.5
    )

    def field(self) -> Field:
        """Return an empty field."""
        return Field(self.field_resolution, self.field_deviation)


@dataclass
class Submap:
    """A run of keyframes.

    Args:
        _field: The reference that scans are matched against, empty.
    """

    _field: Field | Callable[[], Field]
    T_previous_anchor: SE2 = IDENTITY  # the anchor in the frame of the submap before, as matched
    # the keyframes in it; the first is the anchor
    nodes: list[int] = dataclasses.field(default_factory=list)
    # their poses in the anchor's frame, as they were added
    poses: list[SE2] = dataclasses.field(default_factory=list)
    path_length: float = 0.0  # distance travelled from the first to the last [m]
    # covariance of the steps in it that only odometry knows, `(3, 3) float64`: keyframes on
    # both sides of one are not as certain as a match against all of them
    bend: Floats = dataclasses.field(default_factory=lambda: np.zeros((3, 3)))
    _unseen: Floats = dataclasses.field(default_factory=lambda: np.zeros((3, 3)))
    _post: int = 0
    _post_length: float = 0.0

    @property
    def field(self) -> Field:
        """The reference that scans are matched against, in the anchor's frame."""
        return self._field if isinstance(self._field, Field) else self._field()

    @property
    def anchor(self) -> int:
        """The node whose frame the field is in."""
        return self.nodes[0]

    def finish(self, unpacked: Callable[[PackedField], Field]) -> None:
        """Keep the field packed from now on; `unpacked` restores it."""
        self.field.trim()
        self._field = partial(unpacked, PackedField.of(self.field))

    def constraint_to(self, T_anchor_base: SE2) -> tuple[int, SE2, Floats]:
        """Return the keyframe that a new one is tied to, which saw most of what it sees.

        Also the new one's pose in its frame and, in its axes, the covariance of what no match has
        seen in between, `(3, 3) float64`.
        """
        T_post_anchor = self.poses[self._post].inverse()
        turn = SE2(0.0, 0.0, T_post_anchor.theta).matrix()
        return self.nodes[self._post], T_post_anchor @ T_anchor_base, turn @ self._unseen @ turn.T

    def nearest(self, T_anchor_base: SE2) -> tuple[int, SE2]:
        """Return the keyframe nearest to a pose in the anchor's frame, and its pose."""
        k = min(range(len(self.poses)), key=lambda k: self.poses[k].distance(T_anchor_base))
        return self.nodes[k], self.poses[k]

    def renumber(self, index: Ints) -> None:
        """Follow keyframes that were forgotten; see `LocalMap.renumber`."""
        kept = [k for k, node in enumerate(self.nodes) if index[node] >= 0]
        self._post = max((new for new, k in enumerate(kept) if k <= self._post), default=0)
        self.nodes = [int(index[self.nodes[k]]) for k in kept]
        self.poses = [self.poses[k] for k in kept]

    def insert(
        self, node: int, surface: Surface, T_anchor_base: SE2, unseen: Floats = _NONE
    ) -> None:
        """Add a keyframe's surface at its pose in the anchor's frame.

        `unseen` is the covariance of what no match has seen of the step to it, in its axes.
        """
        torn = unseen[2, 2] > 0.0
        if torn and self.nodes:
            self.bend = self.bend + unseen
        self._unseen = self._unseen + unseen
        self.path_length += self.poses[-1].distance(T_anchor_base) if self.poses else 0.0
        self.nodes.append(node)
        self.poses.append(T_anchor_base)
        if torn or self.path_length - self._post_length >= _POST_DISTANCE:
            self._post, self._post_length = len(self.nodes) - 1, self.path_length
            self._unseen = np.zeros((3, 3))
        points, normals = surface.dense(self.field.resolution)
        rotation = SE2(0.0, 0.0, T_anchor_base.theta)
        self.field.add(T_anchor_base.apply(points), rotation.apply(normals))


class LocalMap:
    """The two submaps being built, each half a submap apart; scans are matched against the older.

    Source: Hess et al., Real-time loop closure in 2D LIDAR SLAM, 2016, section IV.
    """

    def __init__(self, config: SubmapConfig) -> None:
        self._config = config
        self.active: list[Submap] = []
        self.finished: list[Submap] = []
        unpacked = 12  # fields, some MB each: a scan is matched against few
        self._unpacked = lru_cache(unpacked)(PackedField.unpacked)

    @property
    def reference(self) -> Submap:
        """The submap to match against."""
        return self.active[0]

    def restore(self, nodes: tuple[int, ...], surfaces: list[Surface], poses: list[SE2]) -> None:
        """Add a finished submap of another session, whose surfaces and poses are those in map."""
        submap = Submap(self._config.field())
        T_anchor_map = poses[nodes[0]].inverse()
        for node in nodes:
            submap.insert(node, surfaces[node], T_anchor_map @ poses[node])
        submap.finish(self._unpacked)
        self.finished.append(submap)

    def insert(
        self, node: int, surface: Surface, T_anchor_base: SE2, unseen: Floats = _NONE
    ) -> SE2:
        """Add a keyframe at its pose in the reference's frame; return that in the next one's.

        A submap starts when the newest is half full. `unseen` is as of `Submap.insert`.
        """
        if not self.active or self._full(self.active[-1], 0.5):
            start = self.poses(T_anchor_base)[-1][1] if self.active else IDENTITY
            self.active.append(Submap(self._config.field(), start))
        for submap, pose in self.poses(T_anchor_base):
            turn = SE2(0.0, 0.0, pose.theta - T_anchor_base.theta).matrix()
            submap.insert(node, surface, pose, turn @ unseen @ turn.T)
        if len(self.active) < 2 or not self._full(self.reference, 1.0):
            return T_anchor_base
        self.finished.append(self.active.pop(0))
        self.finished[-1].finish(self._unpacked)
        return self.reference.T_previous_anchor.inverse() @ T_anchor_base

    def _full(self, submap: Submap, share: float) -> bool:
        count, length = self._config.submap_size, self._config.submap_length
        return len(submap.nodes) >= int(share * count) or submap.path_length >= share * length

    def renumber(self, index: Ints) -> None:
        """Follow keyframes that were forgotten; finished submaps go with their anchor.

        `index` is the new number of each keyframe, -1 for those gone, `(N,) int64`.
        """
        self.finished = [submap for submap in self.finished if index[submap.anchor] >= 0]
        for submap in self.finished + self.active:
            submap.renumber(index)

    def poses(self, T_anchor_base: SE2) -> list[tuple[Submap, SE2]]:
        """Return each active submap and the pose in its frame."""
        pose, result = T_anchor_base, []
        for k, submap in enumerate(self.active):
            if k > 0:
                pose = submap.T_previous_anchor.inverse() @ pose
            result.append((submap, pose))
        return result
