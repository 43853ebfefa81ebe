"""Parameters of the planners that search over poses, by Nav2's names."""

from __future__ import annotations

from dataclasses import dataclass

from arjuna_core.config import SEED_MAX, param


@dataclass(frozen=True)
class PoseSearchConfig:
    """Parameters of all searches over poses."""

    tolerance: float = param(
        0.25, "How far from a blocked goal the path may end.", unit="m", minimum=0.0
    )
    allow_unknown: bool = param(True, "Whether paths may cross unknown space.")
    max_iterations: int = param(
        1000000, "Most poses expanded; below 1 any number.", maximum=SEED_MAX
    )
    minimum_turning_radius: float = param(
        0.4, "Radius of the tightest bend; a cell at the least.", unit="m", minimum=0.0
    )
    reverse_penalty: float = param(2.0, "Factor on driving backwards.", minimum=1.0)
    change_penalty: float = param(0.0, "Added to it where the bend changes sides.", minimum=0.0)
    non_straight_penalty: float = param(1.2, "Factor on bends.", minimum=1.0)
    cost_penalty: float = param(2.0, "Weight of the costs crossed.", minimum=0.0)
    retrospective_penalty: float = param(
        0.015, "How much later bends are preferred.", minimum=0.0, maximum=0.9
    )
    analytic_expansion_ratio: float = param(
        3.5, "How often a direct curve to the goal is tried; higher is oftener.", minimum=0.01
    )
    analytic_expansion_max_length: float = param(3.0, "Longest such curve.", unit="m", minimum=0.0)
    analytic_expansion_max_cost: float = param(
        200.0, "Greatest cost that it may cross.", minimum=0.0, maximum=255.0
    )
    escape_radius: float = param(
        3.0,
        "How far a start too near to an obstacle is led out of it.",
        unit="m",
        minimum=0.0,
        nav2=0.0,
    )
    heuristic_weight: float = param(
        1.03,
        "Factor on the estimated rest: the search is faster, the path costlier by it at most.",
        minimum=1.0,
        maximum=10.0,
        nav2=1.0,
    )


@dataclass(frozen=True)
class HybridConfig(PoseSearchConfig):
    """Parameters of Smac Hybrid-A*."""

    heuristic_weight: float = param(
        1.15,
        "Factor on the estimated rest: the search is faster, the path costlier by it at most.",
        minimum=1.0,
        maximum=10.0,
        nav2=1.0,
    )

    motion_model_for_search: str = param(
        "DUBIN", "Forwards alone, or backwards too.", choices=("DUBIN", "REEDS_SHEPP")
    )
    angle_quantization_bins: int = param(
        72, "Headings that are distinguished.", minimum=8, maximum=360
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
    minimum_turning_radius: float = param(
        0.5, "Radius of the tightest bend where no file is given.", unit="m", minimum=0.0
    )
    allow_reverse_expansion: bool = param(False, "Whether pieces are driven back, too.")
    rotation_penalty: float = param(
        5.0, "Price of a turn on the spot to the next heading.", unit="cells", minimum=0.01
    )
    change_penalty: float = param(0.05, "Added to it where the bend changes sides.", minimum=0.0)
    non_straight_penalty: float = param(1.05, "Factor on bends.", minimum=1.0)
