"""Submaps: overlapping runs of keyframes, each with a field in its first keyframe's frame."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.surface import Surface


@dataclass(frozen=True)
class SubmapConfig:
    """Parameters of submaps and their fields."""

    max_laser_range: float = param(20.0, "Longest range used.", unit="m", minimum=0.1)
    submap_size: int = param(40, "Keyframes in a submap.", minimum=2, maximum=10000)
    field_resolution: float = param(
        0.05, "Edge of a cell of the matching field.", unit="m", minimum=0.005, maximum=0.5
    )
    field_deviation: float = param(
        0.05,
        "Deviation of the Gaussian around a reference point.",
        unit="m",
        minimum=0.005,
        maximum=0.5,
    )

    def field(self) -> Field:
        """Return an empty field."""
        return Field(self.field_resolution, self.field_deviation)


@dataclass
class Submap:
    """A run of keyframes.

    Attributes:
        field: The reference that scans are matched against, in the anchor's frame.
        T_previous_anchor: The anchor in the frame of the submap before, as matched.
        nodes: The keyframes in it; the first is the anchor.
    """

    field: Field
    T_previous_anchor: SE2 = IDENTITY
    nodes: list[int] = dataclasses.field(default_factory=list)

    @property
    def anchor(self) -> int:
        """The node whose frame the field is in."""
        return self.nodes[0]

    def insert(self, node: int, surface: Surface, T_anchor_base: SE2) -> None:
        """Add a keyframe's surface at its pose in the anchor's frame."""
        self.nodes.append(node)
        points, normals = surface.dense(self.field.resolution)
        rotation = SE2(0.0, 0.0, T_anchor_base.theta)
        self.field.add(T_anchor_base.apply(points), rotation.apply(normals))


class LocalMap:
    """The two submaps being built, each half a submap apart; scans are matched against the older.

    Args:
        config: The parameters.

    Source: Hess et al., Real-time loop closure in 2D LIDAR SLAM, 2016, section IV.
    """

    def __init__(self, config: SubmapConfig) -> None:
        self._config = config
        self.active: list[Submap] = []
        self.finished: list[Submap] = []

    @property
    def reference(self) -> Submap:
        """The submap to match against."""
        return self.active[0]

    def restore(self, nodes: tuple[int, ...], surfaces: list[Surface], poses: list[SE2]) -> None:
        """Add a finished submap of another session.

        Args:
            nodes: Its keyframes.
            surfaces: What every keyframe saw.
            poses: Where every keyframe lies in map.
        """
        submap = Submap(self._config.field())
        T_anchor_map = poses[nodes[0]].inverse()
        for node in nodes:
            submap.insert(node, surfaces[node], T_anchor_map @ poses[node])
        submap.field.trim()
        self.finished.append(submap)

    def insert(self, node: int, surface: Surface, T_anchor_base: SE2) -> SE2:
        """Add a keyframe; start a submap when the newest is half full, finish the full one.

        Args:
            node: The keyframe.
            surface: What it saw.
            T_anchor_base: Its pose in the reference's frame.

        Returns:
            The pose in the frame of the reference that holds from now on.
        """
        if not self.active or len(self.active[-1].nodes) >= self._config.submap_size // 2:
            start = T_anchor_base if self.active else IDENTITY
            self.active.append(Submap(self._config.field(), start))
        pose = T_anchor_base
        for k, submap in enumerate(self.active):
            if k > 0:
                pose = submap.T_previous_anchor.inverse() @ pose
            submap.insert(node, surface, pose)
        if len(self.reference.nodes) < self._config.submap_size:
            return T_anchor_base
        self.finished.append(self.active.pop(0))
        self.finished[-1].field.trim()
        return self.reference.T_previous_anchor.inverse() @ T_anchor_base

    def renumber(self, index: NDArray[np.int64]) -> None:
        """Follow keyframes that were forgotten; finished submaps go with their anchor.

        Args:
            index: The new number of each keyframe, -1 for those gone, `(N,) int64`.
        """
        self.finished = [submap for submap in self.finished if index[submap.anchor] >= 0]
        for submap in self.finished + self.active:
            submap.nodes = [int(index[node]) for node in submap.nodes if index[node] >= 0]

    def poses(self, T_anchor_base: SE2) -> list[tuple[int, SE2]]:
        """Return the anchor of each active submap and the pose in its frame."""
        pose, result = T_anchor_base, []
        for k, submap in enumerate(self.active):
            if k > 0:
                pose = submap.T_previous_anchor.inverse() @ pose
            result.append((submap.anchor, pose))
        return result
