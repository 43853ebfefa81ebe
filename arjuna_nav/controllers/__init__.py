"""Local planners: controllers that follow a path."""

from arjuna_nav.controllers.base import Controller, ControlResult, ControlStatus, PathError
from arjuna_nav.controllers.pursuit.config import RegulatedPurePursuitConfig
from arjuna_nav.controllers.pursuit.controller import RegulatedPurePursuit
