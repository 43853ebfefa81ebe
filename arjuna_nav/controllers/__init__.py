"""Local planners: controllers that follow a path."""

from arjuna_nav.controllers.base import Controller, ControlResult, ControlStatus, PathError
from arjuna_nav.controllers.regulated_pure_pursuit import (
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
