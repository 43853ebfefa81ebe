"""Every planner, for tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from arjuna_core.config import load, plugin_names
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import Planner
from arjuna_nav.planners.base import PLANNERS

CLASSES = {
    "navfn": "nav2_navfn_planner::NavfnPlanner",
    "theta*": "nav2_theta_star_planner::ThetaStarPlanner",
    "smac 2d": "nav2_smac_planner::SmacPlanner2D",
    "smac hybrid": "nav2_smac_planner::SmacPlannerHybrid",
    "smac lattice": "nav2_smac_planner::SmacPlannerLattice",
}
ON_CELLS = tuple(name for name in CLASSES if name not in ("smac hybrid", "smac lattice"))
"""Planners whose paths go from cell to cell, so that they turn on the spot."""
_OWN = {"smac hybrid": {"motion_model_for_search": "REEDS_SHEPP"}}


@dataclass(frozen=True)
class _Server:
    names: tuple[str, ...] = plugin_names(("it",), "The planners.", PLANNERS)


def make(name: str, footprint: Footprint | None = None, **values: Any) -> Planner:
    """Return a planner for a circle of 0.25 m, with some parameters."""
    config: Any = load(_Server, {"it": {"plugin": CLASSES[name], **_OWN.get(name, {}), **values}})
    made: Planner = PLANNERS.make(config.it, footprint or Footprint.circle(0.25))
    return made
