"""Keyframes: the pose graph with the scan at each of its nodes, and the map they make."""

from __future__ import annotations

import numpy as np

from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import PoseGraph
from arjuna_slam.mapping.mapper import Mapper
from arjuna_slam.mapping.session import Session


class Keyframes:
    """The keyframes of a mapping session.

    Args:
        mapper: Makes the map; without scans.

    Attributes:
        graph: Their poses and the measurements between them.
    """

    def __init__(self, mapper: Mapper) -> None:
        self._mapper = mapper
        self.graph = PoseGraph()

    @property
    def scans(self) -> tuple[Scan, ...]:
        """The scan at each node."""
        return self._mapper.scans

    def add(self, scan: Scan, T_map_base: SE2) -> int:
        """Add a scan at its pose in map and return its node."""
        self._mapper.add(scan)
        return self.graph.add_node(T_map_base)

    def adopt(self, session: Session) -> None:
        """Take over a session's keyframes and edges."""
        for scan, pose in zip(session.scans, session.poses, strict=True):
            self.add(scan, SE2.from_array(pose))
        for edge in session.edges:
            self.graph.add_edge(edge)

    def nearest(self, T_map_base: SE2) -> int:
        """Return the node nearest to a pose in map."""
        place = T_map_base.x, T_map_base.y
        return int(np.hypot(*(self.graph.poses[:, :2] - place).T).argmin())

    def map(self, most_moved: int | None = None) -> OccupancyGrid | None:
        """Return the map, or None without keyframes.

        Args:
            most_moved: How many keyframes that have moved are traced anew at most; None for all.
        """
        return self._mapper.grid(self.graph.poses, most_moved)

    @property
    def map_behind(self) -> bool:
        """Whether the map would be another than when it was last returned."""
        return self._mapper.behind(self.graph.poses)
