"""Smac Hybrid-A*: plans of a robot with a turning circle."""

from __future__ import annotations

from typing import Any, ClassVar

from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.hybrid.config import HybridConfig
from arjuna_nav.planners.hybrid.moves import Moves, arcs
from arjuna_nav.planners.hybrid.pose_search import PoseSearch


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

    def _moves(self, costmap: Costmap, heading: float) -> Moves:
        config, radius = self._config, self._radius(costmap)
        factors = config.reverse_penalty, config.non_straight_penalty, config.change_penalty
        moves: Moves = arcs(heading, self._bins, radius, self._reverse, factors)
        return moves

    @property
    def _reverse(self) -> bool:
        return self._model == "REEDS_SHEPP"
