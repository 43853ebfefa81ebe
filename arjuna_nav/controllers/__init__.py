"""Local planners: controllers that follow a path."""

from arjuna_nav.controllers.base import Controller, ControlResult, ControlStatus
from arjuna_nav.controllers.regulated_pure_pursuit import (
    PathError,
    RegulatedPurePursuit,
    RegulatedPurePursuitConfig,
)

__all__ = [
    "ControlResult",
    "ControlStatus",
    "Controller",
    "PathError",
    "RegulatedPurePursuit",
    "RegulatedPurePursuitConfig",
]
