"""What a mapping session leaves behind: all that another needs to go on from it."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.graph.pose_graph import Edge


@dataclass(frozen=True)
class Session:
    """A graph with the scans at its nodes.

    Attributes:
        scans: The scan of each keyframe.
        poses: Optimised x, y, theta of each keyframe in map, `(N, 3) float64` [m, m, rad].
        travel: Distance driven up to each keyframe, `(N,) float64` [m].
        edges: The measurements between keyframes.
        submaps: The keyframes of each submap, the first its anchor.
        T_odom_base: Odometry at the last keyframe; None where it is not known.
    """

    scans: tuple[Scan, ...]
    poses: NDArray[np.float64]
    travel: NDArray[np.float64]
    edges: tuple[Edge, ...]
    submaps: tuple[tuple[int, ...], ...]
    T_odom_base: SE2 | None = None


class StartKind(enum.Enum):
    """What is known of the robot's pose when a session goes on."""

    FIRST_NODE = "at the first keyframe"
    NEAR_POSE = "near a pose"
    ANYWHERE = "anywhere on the map"
    ODOMETRY = "where odometry, which went on meanwhile, has brought it"


@dataclass(frozen=True)
class Start:
    """Where a session goes on.

    Attributes:
        kind: What is known.
        T_map_base: The pose, where one is known.
    """

    kind: StartKind
    T_map_base: SE2 = IDENTITY
