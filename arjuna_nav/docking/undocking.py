"""Undocking: back to the staging pose, away from the dock.

Source: opennav_docking, DockingServer.
"""

from __future__ import annotations

from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.docking.approach import BlockedError, at_the_end, towards
from arjuna_nav.docking.config import DockingConfig
from arjuna_nav.docking.dock_types import DockType
from arjuna_nav.docking.docking import DockingError, DockingState, DockingStep, docked_pose


class Undocking:
    """One order to undock.

    Args:
        config: Tolerances and limits.
        kind: The dock's kind.
        footprint: The robot.
        max_time: How long it may take [s].
        docked: Whether the robot is known to have docked; else contact or current must show it.
    """

    def __init__(
        self,
        config: DockingConfig,
        kind: DockType,
        footprint: Footprint,
        max_time: float,
        docked: bool = False,
    ) -> None:
        self._config = config
        self._kind = kind
        self._footprint = footprint
        self._max_time = max_time
        self._docked = docked
        self._start: tuple[float, SE2] | None = None

    def tick(self, state: DockingState) -> DockingStep:
        """Return what to do; where the robot stands at the first tick is the docked pose."""
        if self._start is None:
            self._start = state.now, state.pose
            if self._kind.charges and not self._docked and not self._is_in(state):
                return DockingStep(ended=DockingError.NONE)
        since, docked = self._start
        backward = not self._config.dock_backwards
        target = self._kind.staging_pose(docked_pose(docked, self._config.dock_backwards))
        tolerances = self._config.undock_linear_tolerance, self._config.undock_angular_tolerance
        controller = self._config.controller
        last = at_the_end(controller, state.pose, target, tolerances, backward)
        if last == STILL:
            return self._arrive(state)
        if state.now - since > self._max_time:
            return _failed(f"undocking took over {self._max_time:g} s")
        try:
            velocity = last or towards(
                controller,
                state.pose,
                target,
                backward,
                docked,
                state.costmap,
                self._footprint,
            )
        except BlockedError as error:
            return _failed(str(error))
        return DockingStep(velocity)

    def _is_in(self, state: DockingState) -> bool:
        return self._kind.is_docked(state.senses) or self._kind.is_charging(state.senses)

    def _arrive(self, state: DockingState) -> DockingStep:
        if self._kind.is_charging(state.senses):
            return _failed("the battery still charges at the staging pose")
        return DockingStep(ended=DockingError.NONE)


def _failed(message: str) -> DockingStep:
    return DockingStep(ended=DockingError.FAILED_TO_CONTROL, message=message)
