"""Parameters of Smac's planners, by Nav2's names."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from arjuna_core.config import SEED_MAX, duration_param, length_param, param
from arjuna_nav.planners.base import GridPlannerConfig
from arjuna_nav.planners.relaxation import SmootherConfig


@dataclass(frozen=True)
class SmacConfig(GridPlannerConfig):
    """Parameters of all searches."""

    tolerance: float = length_param(0.25, "How far from a blocked goal the path may end.")
    max_iterations: int = param(
        1000000, "Most cells or poses expanded; below 1 any number.", maximum=SEED_MAX
    )
    max_on_approach_iterations: int = param(
        0,
        "Most of them from where the search is within `tolerance` of the goal; then, or where the"
        " goal itself cannot be reached, the path ends at the nearest. Below 1 it ends at the goal"
        " alone, or where that is blocked or walled off at the nearest to it.",
        maximum=SEED_MAX,
        theirs=1000,
    )
    terminal_checking_interval: int = param(
        5000, "How many between two looks whether the plan is to stop.", minimum=1, maximum=SEED_MAX
    )
    max_planning_time: float = duration_param(
        5.0, "After which a plan ends with TIMEOUT. In lock-step plans take no time."
    )
    smoother: SmootherConfig = field(default_factory=SmootherConfig)

    def tolerance_on_approach(self, resolution: float) -> float:
        """Return how near to the goal iterations begin to count [cells], below 0 if never."""
        counts = self.max_on_approach_iterations > 0
        return float(math.floor(self.tolerance / resolution)) if counts else -1.0


@dataclass(frozen=True)
class DownsamplingConfig:
    """Parameters of searches on a coarser costmap."""

    downsample_costmap: bool = param(False, "Whether to search on larger cells.")
    downsampling_factor: int = param(
        1, "How many cells along each side make one; the costliest counts.", minimum=1, maximum=100
    )

    @property
    def coarseness(self) -> int:
        """Cells of the costmap along each side of one of the search's."""
        return self.downsampling_factor if self.downsample_costmap else 1


@dataclass(frozen=True)
class PoseSearchConfig(SmacConfig):
    """Parameters of all searches over poses."""

    minimum_turning_radius: float = length_param(
        0.4, "Radius of the tightest bend; a cell at the least."
    )
    reverse_penalty: float = param(2.0, "Factor on driving backwards.", minimum=0.0)
    change_penalty: float = param(0.0, "Added to it where the bend changes sides.", minimum=0.0)
    non_straight_penalty: float = param(1.2, "Factor on bends.", minimum=0.0)
    cost_penalty: float = param(2.0, "Weight of the costs crossed.", minimum=0.0)
    retrospective_penalty: float = param(
        0.015, "How much later bends are preferred.", minimum=0.0, maximum=0.9
    )
    analytic_expansion_ratio: float = param(
        3.5, "How often a direct curve to the goal is tried; higher is oftener.", minimum=0.01
    )
    analytic_expansion_max_length: float = length_param(3.0, "Longest such curve.")
    analytic_expansion_max_cost: float = param(
        200.0, "Greatest cost that it may cross; any that is free from 253 on.", minimum=0.0
    )
    analytic_expansion_max_cost_override: bool = param(
        False, "Whether it may cross any cost within one turning circle's length of the goal."
    )
    smooth_path: bool = param(
        False, "Whether the path is smoothed, each part driven in one direction apart.", theirs=True
    )
    cache_obstacle_heuristic: bool = param(
        False,
        "Whether the costs left to a goal are kept while it stays: sooner planned, as if the"
        " costmap had not changed in its estimates.",
    )
    lookup_table_size: float = length_param(
        1000.0,
        "Edge of the square about the goal in which bends count in the estimate of the rest.",
        theirs=20.0,
    )
    goal_heading_mode: str = param(
        "DEFAULT",
        "With which heading the path may end: the goal's, that or the opposite one, or any.",
        choices=("DEFAULT", "BIDIRECTIONAL", "ALL_DIRECTION"),
    )
    coarse_search_resolution: int = param(
        1,
        "Of any heading every n-th is tried, the others only where a curve to one is free; each"
        " from 0 down.",
    )
    debug_visualizations: bool = param(
        False, "Whether `expansions` and `planned_footprints` are published."
    )
    heuristic_weight: float = param(
        1.03,
        "Factor on the estimated rest: the search is faster, the path costlier by it at most.",
        minimum=1.0,
        maximum=10.0,
        theirs=1.0,
    )


@dataclass(frozen=True)
class HybridConfig(DownsamplingConfig, PoseSearchConfig):
    """Parameters of Smac Hybrid-A*."""

    heuristic_weight: float = param(
        1.15,
        "Factor on the estimated rest: the search is faster, the path costlier by it at most.",
        minimum=1.0,
        maximum=10.0,
        theirs=1.0,
    )

    motion_model_for_search: str = param(
        "DUBIN", "Forwards alone, or backwards too.", choices=("DUBIN", "REEDS_SHEPP")
    )
    angle_quantization_bins: int = param(
        72, "Headings that are distinguished.", minimum=8, maximum=360
    )
    allow_primitive_interpolation: bool = param(
        False, "Whether pieces bend by any number of headings up to the tightest bend."
    )
    use_quadratic_cost_penalty: bool = param(
        False, "Whether costs count by their square, not linearly."
    )
    downsample_obstacle_heuristic: bool = param(
        False, "Whether the costs left are estimated on cells twice as large.", theirs=True
    )


@dataclass(frozen=True)
class SmacLatticeConfig(PoseSearchConfig):
    """Parameters of the Smac lattice planner."""

    lattice_filepath: str = param(
        "",
        "Pieces as lattice_primitives of Nav2 writes them; empty: those of a differential drive"
        " that bend by minimum_turning_radius.",
        path=True,
    )
    minimum_turning_radius: float = length_param(
        0.5, "Radius of the tightest bend where no file is given."
    )
    allow_reverse_expansion: bool = param(False, "Whether pieces are driven back, too.")
    rotation_penalty: float = param(
        5.0, "Price of a turn on the spot to the next heading.", unit="cells", minimum=0.0
    )
    change_penalty: float = param(0.05, "Added to it where the bend changes sides.", minimum=0.0)
    non_straight_penalty: float = param(1.05, "Factor on bends.", minimum=0.0)
