"""Smac Hybrid-A*: plans of a robot with a turning circle."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.hybrid.config import HybridConfig
from arjuna_nav.planners.hybrid.moves import Moves, arcs
from arjuna_nav.planners.hybrid.pose_search import PoseSearch

_MOST_CELLS = 4096 * 4096  # of a grid that is made finer


class Hybrid(PoseSearch):
    """Plans by hybrid A* with Dubins' or Reeds and Shepp's curves.

    Args:
        config: Parameters.
        footprint: The robot.

    Source: Dolgov, Thrun, Montemerlo and Diebel, Path planning for autonomous vehicles in unknown
        semi-structured environments, IJRR 2010; nav2_smac_planner, SmacPlannerHybrid.
    """

    Config: ClassVar[type[Any]] = HybridConfig

    def __init__(self, config: HybridConfig, footprint: Footprint) -> None:
        super().__init__(config, footprint)
        self._model, self._bins = config.motion_model_for_search, config.angle_quantization_bins

    def _grid(self, costmap: Costmap) -> Costmap:
        """Return the costs in cells no larger than the tightest bend, or it could not be driven."""
        radius = self._config.minimum_turning_radius
        needed = math.ceil(costmap.frame.resolution / radius - 1e-9)
        return _finer(costmap, min(needed, math.isqrt(_MOST_CELLS // costmap.data.size)))

    def _moves(self, costmap: Costmap, first: NDArray[np.float64]) -> Moves:
        config, radius = self._config, self._radius(costmap)
        factors = config.reverse_penalty, config.non_straight_penalty, config.change_penalty
        moves: Moves = arcs(first[2], self._bins, radius, self._reverse, factors)
        return moves

    @property
    def _reverse(self) -> bool:
        return self._model == "REEDS_SHEPP"


def _finer(costmap: Costmap, factor: int) -> Costmap:
    """Return the same costs, each cell divided into so many along each side."""
    if factor <= 1:
        return costmap
    data, frame = costmap.data.repeat(factor, axis=0).repeat(factor, axis=1), costmap.frame
    height, width = data.shape
    frame = replace(frame, resolution=frame.resolution / factor, width=width, height=height)
    return replace(costmap, frame=frame, data=data, hits=None)
