"""Parameters of loop closure, and what a loop is closed with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_slam.matching.field import Field


@dataclass(frozen=True)
class LoopConfig:
    """Parameters of loop closure; slam_toolbox's names."""

    do_loop_closing: bool = param(True, "Whether to close loops.")
    loop_search_maximum_distance: float = param(
        3.0, "Distance to a past keyframe within which its submap is tried.", unit="m", minimum=0.0
    )
    loop_search_space_dimension: float = param(
        30.0, "Width of the greatest search window.", unit="m", minimum=0.0, maximum=100.0
    )
    loop_search_angle: float = param(
        0.785,
        "Half the angle of the greatest search window.",
        unit="rad",
        minimum=0.01,
        maximum=3.15,
    )
    loop_match_minimum_response_coarse: float = param(
        0.35, "Mean likelihood that the search must reach.", minimum=0.0
    )
    loop_match_minimum_response_fine: float = param(
        0.45, "Share of points on the submap's surfaces after refinement.", minimum=0.0
    )
    loop_search_deviations: float = param(
        3.0, "How many deviations of what the graph does not know a search window reaches.",
        minimum=0.1, maximum=100.0,
    )  # fmt: skip
    loop_scan_window: float = param(
        1.0, "Half the window up to which a single scan is enough; beyond, submaps are compared.",
        unit="m", minimum=0.0, maximum=100.0,
    )  # fmt: skip
    loop_place_response: float = param(
        0.4, "Share of a submap's surfaces that must lie on a past one's.", minimum=0.0, maximum=1.0
    )
    loop_contradiction: float = param(
        0.08, "Share of a submap's points that a past one's beams may go through at most.",
        minimum=0.0, maximum=1.0,
    )  # fmt: skip
    loop_retry_distance: float = param(
        0.5, "Travel within which a failed search is not repeated.", unit="m", minimum=0.0
    )
    loop_sure_distance: float = param(
        0.15, "Correction in position below which a match needs no witness.", unit="m", minimum=0.0
    )
    loop_sure_angle: float = param(
        0.05, "Correction in heading below which a match needs no witness.", unit="rad", minimum=0.0
    )
    loop_witness_distance: float = param(
        2.0, "Travel within which another match may bear a correction out.", unit="m", minimum=0.0
    )
    loop_agree_distance: float = param(
        0.1, "Position within which two matches agree.", unit="m", minimum=0.0
    )
    loop_agree_angle: float = param(
        0.03, "Heading within which two matches agree.", unit="rad", minimum=0.0
    )


class Submap(Protocol):
    """What a loop is closed with: a run of keyframes and their field in the first one's frame."""

    nodes: list[int]
    way: float
    bend: NDArray[np.float64]

    @property
    def field(self) -> Field:
        """What scans are matched against."""

    @property
    def anchor(self) -> int:
        """The node whose frame the field is in."""

    poses: list[SE2]

    def nearest(self, T_anchor_base: SE2) -> tuple[int, SE2]:
        """Return the keyframe nearest to a pose in the anchor's frame, and its pose."""
