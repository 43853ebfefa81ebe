"""Global planners."""

from arjuna_nav.planners.base import Planner, PlanResult, PlanStatus, plan_through
from arjuna_nav.planners.navfn import NavFn, NavFnConfig

__all__ = ["NavFn", "NavFnConfig", "PlanResult", "PlanStatus", "Planner", "plan_through"]
