"""Global planners."""

from arjuna_nav.planners.base import Planner, PlanResult, PlanStatus
from arjuna_nav.planners.navfn import NavFn, NavFnConfig
from arjuna_nav.planners.query import plan_through

__all__ = ["NavFn", "NavFnConfig", "PlanResult", "PlanStatus", "Planner", "plan_through"]
