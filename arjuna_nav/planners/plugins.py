"""Which planners there are, by Nav2's class names."""

from __future__ import annotations

from arjuna_core.plugins import PluginTypes

_HERE = "arjuna_nav.planners"
_NAVFN = "nav2_navfn_planner::NavfnPlanner"

PLANNERS = PluginTypes(
    "planner",
    {
        _NAVFN: f"{_HERE}.navfn:NavFn",
        "nav2_theta_star_planner::ThetaStarPlanner": f"{_HERE}.theta_star:ThetaStar",
        "nav2_smac_planner::SmacPlanner2D": f"{_HERE}.smac_2d:Smac2D",
        "nav2_smac_planner::SmacPlannerHybrid": f"{_HERE}.hybrid.planner:Hybrid",
        "nav2_smac_planner::SmacPlannerLattice": f"{_HERE}.hybrid.lattice:SmacLattice",
    },
    _NAVFN,
)
