"""Docking from the order to the charging current, and undocking back to the staging pose.

Source: opennav_docking, DockingServer.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field

from arjuna_core.config import angle_param, duration_param, fixed, length_param, param
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.docking.approach import ApproachConfig, BlockedError, at_the_end, towards
from arjuna_nav.docking.dock_types import DockSenses, DockType


@dataclass(frozen=True)
class DockingConfig:
    """When docking waits, tries again and gives up, by Nav2's names."""

    controller_frequency: float = fixed(50.0, "Commands a second.", unit="Hz", minimum=0.1)
    initial_perception_timeout: float = duration_param(
        5.0, "How long to wait until the dock is seen."
    )
    wait_charge_timeout: float = duration_param(5.0, "How long to wait until the battery charges.")
    dock_approach_timeout: float = duration_param(30.0, "How long an approach may take.")
    undock_linear_tolerance: float = length_param(
        0.05, "Distance to the staging pose that is good enough."
    )
    undock_angular_tolerance: float = angle_param(
        0.05, "Heading from the staging pose that is good enough."
    )
    max_retries: int = param(3, "Most retries.", minimum=0)
    dock_backwards: bool = param(False, "Whether the robot backs into docks.")
    dock_prestaging_tolerance: float = length_param(
        0.5, "Distance to the staging pose within which it is not driven to."
    )
    controller: ApproachConfig = field(default_factory=ApproachConfig)


class DockingPhase(enum.IntEnum):
    """The states of nav2_msgs' feedback."""

    NAV_TO_STAGING_POSE = 1
    INITIAL_PERCEPTION = 2
    CONTROLLING = 3
    WAIT_FOR_CHARGE = 4
    RETRY = 5


class DockingError(enum.IntEnum):
    """The error codes of nav2_msgs."""

    NONE = 0
    DOCK_NOT_IN_DB = 901
    DOCK_NOT_VALID = 902
    FAILED_TO_STAGE = 903
    FAILED_TO_DETECT_DOCK = 904
    FAILED_TO_CONTROL = 905
    FAILED_TO_CHARGE = 906
    UNKNOWN = 999


@dataclass(frozen=True)
class DockingState:
    """Knowledge at a tick; poses and costmap are of one fixed frame.

    Attributes:
        now: Time [s].
        dock: The dock's pose, None where it is not seen.
        staged: Whether the staging pose was reached; None while it is driven to.
    """

    now: float
    pose: SE2
    dock: SE2 | None
    senses: DockSenses
    costmap: Costmap | None = None
    staged: bool | None = None


@dataclass(frozen=True)
class DockingStep:
    """Instructions until the next tick.

    Attributes:
        velocity: What to drive; None leaves the wheels to the one who drives to the staging pose.
        stage: Whether to begin driving to the staging pose.
        ended: How docking ended, None while it continues.
    """

    velocity: Velocity | None = STILL
    stage: bool = False
    ended: DockingError | None = None
    message: str = ""


def docked_pose(dock: SE2, backwards: bool) -> SE2:
    """Return how a robot stands in a dock, whose own heading leads into it.

    It is its own inverse: given how the robot stands, it returns the dock's pose.
    """
    return dock @ SE2(0.0, 0.0, math.pi) if backwards else dock


class _FailedError(Exception):
    """An attempt failed; another may succeed."""

    def __init__(self, error: DockingError, message: str) -> None:
        super().__init__(message)
        self.error = error


class Docking:
    """One order to dock.

    Args:
        config: When to wait, to try again, to give up.
        footprint: The robot; None where nothing counts as obstacle.
        navigate: Whether to drive to the staging pose first.
        max_staging_time: How long that may take [s].
    """

    def __init__(
        self,
        config: DockingConfig,
        kind: DockType,
        footprint: Footprint | None,
        navigate: bool,
        max_staging_time: float,
    ) -> None:
        self._config = config
        self._kind = kind
        self._footprint = footprint
        self._navigate = navigate
        self._max_staging_time = max_staging_time
        self._since = -math.inf
        self._started = False
        self._dock = SE2()
        self._failure = _FailedError(DockingError.UNKNOWN, "")
        self.phase = DockingPhase.NAV_TO_STAGING_POSE
        self.retries = 0

    def tick(self, state: DockingState, nominal: SE2) -> DockingStep:
        """Return what to do."""
        if not self._started:
            return self._begin(state, nominal)
        step = {
            DockingPhase.NAV_TO_STAGING_POSE: self._stage,
            DockingPhase.INITIAL_PERCEPTION: self._perceive,
            DockingPhase.CONTROLLING: self._approach,
            DockingPhase.WAIT_FOR_CHARGE: self._wait_for_charge,
            DockingPhase.RETRY: self._return,
        }[self.phase]
        try:
            return step(state)
        except _FailedError as failure:
            spent = self.retries >= self._config.max_retries
            if spent or self.phase is DockingPhase.RETRY:
                return DockingStep(ended=failure.error, message=str(failure))
            self.retries += 1
            self._failure = failure
            return self._enter(DockingPhase.RETRY, state.now)

    def _begin(self, state: DockingState, nominal: SE2) -> DockingStep:
        self._started, self._dock = True, nominal
        if self._kind.charges and self._kind.is_in(state.senses):
            return DockingStep(ended=DockingError.NONE)
        staging = self._kind.staging_pose(nominal)
        near = state.pose.distance(staging) < self._config.dock_prestaging_tolerance
        if near or not self._navigate:
            return self._enter(DockingPhase.INITIAL_PERCEPTION, state.now)
        self._enter(DockingPhase.NAV_TO_STAGING_POSE, state.now)
        return DockingStep(velocity=None, stage=True)

    def _enter(self, phase: DockingPhase, now: float) -> DockingStep:
        self.phase, self._since = phase, now
        return DockingStep()

    def _stage(self, state: DockingState) -> DockingStep:
        if state.staged:
            return self._enter(DockingPhase.INITIAL_PERCEPTION, state.now)
        late = state.now - self._since > self._max_staging_time
        if state.staged is None and not late:
            return DockingStep(velocity=None)
        why = f"took over {self._max_staging_time:g} s" if late else "failed"
        message = f"driving to the staging pose {why}"
        return DockingStep(ended=DockingError.FAILED_TO_STAGE, message=message)

    def _perceive(self, state: DockingState) -> DockingStep:
        timeout = self._config.initial_perception_timeout
        if state.dock is not None:
            self._dock = state.dock
            return self._enter(DockingPhase.CONTROLLING, state.now)
        if state.now - self._since <= timeout:
            return DockingStep()
        message = f"the dock was not seen within {timeout:g} s"
        return DockingStep(ended=DockingError.FAILED_TO_DETECT_DOCK, message=message)

    def _approach(self, state: DockingState) -> DockingStep:
        if self._kind.is_in(state.senses):
            if self._kind.charges:
                return self._enter(DockingPhase.WAIT_FOR_CHARGE, state.now)
            return DockingStep(ended=DockingError.NONE)
        if state.dock is None:
            raise _FailedError(DockingError.FAILED_TO_DETECT_DOCK, "the dock was lost from sight")
        if state.now - self._since > self._config.dock_approach_timeout:
            message = f"no contact within {self._config.dock_approach_timeout:g} s"
            raise _FailedError(DockingError.FAILED_TO_CONTROL, message)
        self._dock, backward = state.dock, self._kind.backs_in(self._config.dock_backwards)
        target = docked_pose(state.dock, backward)
        ahead = (state.pose.inverse() @ target).x * (-1 if backward else 1)
        # More than 5 cm behind the docked pose, the law would turn the robot round.
        if ahead < -0.05:
            raise _FailedError(DockingError.FAILED_TO_CONTROL, f"passed the dock by {-ahead:.2f} m")
        return self._drive(state, target, backward)

    def _drive(self, state: DockingState, target: SE2, backward: bool) -> DockingStep:
        controller = self._config.controller
        try:
            velocity = towards(
                controller, state.pose, target, backward, self._dock, state.costmap, self._footprint
            )
        except BlockedError as error:
            raise _FailedError(DockingError.FAILED_TO_CONTROL, str(error)) from error
        return DockingStep(velocity)

    def _wait_for_charge(self, state: DockingState) -> DockingStep:
        timeout = self._config.wait_charge_timeout
        if self._kind.is_charging(state.senses):
            return DockingStep(ended=DockingError.NONE)
        if state.now - self._since > timeout:
            message = f"the battery does not charge {timeout:g} s after contact"
            raise _FailedError(DockingError.FAILED_TO_CHARGE, message)
        return DockingStep()

    def _return(self, state: DockingState) -> DockingStep:
        config, staging = self._config, self._kind.staging_pose(self._dock)
        tolerances = config.undock_linear_tolerance, config.undock_angular_tolerance
        backward = not self._kind.backs_in(config.dock_backwards)
        if at_the_end(config.controller, state.pose, staging, tolerances, backward) is not None:
            return self._enter(DockingPhase.INITIAL_PERCEPTION, state.now)
        if state.now - self._since > config.dock_approach_timeout:
            message = f"no path back to the staging pose, after: {self._failure}"
            raise _FailedError(DockingError.FAILED_TO_CONTROL, message)
        return self._drive(state, staging, backward)


class Undocking:
    """One order to undock.

    Args:
        footprint: The robot; None where nothing counts as obstacle.
        max_time: How long it may take [s].
        docked: Whether the robot is known to have docked; else contact or current must show it.
    """

    def __init__(
        self,
        config: DockingConfig,
        kind: DockType,
        footprint: Footprint | None,
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
            if self._kind.charges and not self._docked and not self._kind.is_in(state.senses):
                return DockingStep(ended=DockingError.NONE)
        since, docked = self._start
        backward = not self._kind.backs_in(self._config.dock_backwards)
        target = self._kind.staging_pose(docked_pose(docked, not backward))
        tolerances = self._config.undock_linear_tolerance, self._config.undock_angular_tolerance
        controller = self._config.controller
        last = at_the_end(controller, state.pose, target, tolerances, backward)
        if last == STILL:
            if self._kind.is_charging(state.senses):
                return _failed("the battery still charges at the staging pose")
            return DockingStep(ended=DockingError.NONE)
        if state.now - since > self._max_time:
            return _failed(f"undocking took over {self._max_time:g} s")
        try:
            velocity = last or towards(
                controller, state.pose, target, backward, docked, state.costmap, self._footprint
            )
        except BlockedError as error:
            return _failed(str(error))
        return DockingStep(velocity)


def _failed(message: str) -> DockingStep:
    return DockingStep(ended=DockingError.FAILED_TO_CONTROL, message=message)
