"""Measurements of many sensors in order of time, through one filter; late ones too, if asked."""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from arjuna_core.arrays import Bools, Floats
from arjuna_sim.fusion.filters import Filter, Measurement, Noise
from arjuna_sim.fusion.kinematics import SIZE, TWIST

_ODD_GAP = 1e5  # [s] robot_localization's: a clock that jumped, for which this step stands
_ODD_STEP = 0.01


@dataclass(frozen=True)
class Control:
    """The acceleration of the body by velocity commands.

    Attributes:
        mask: `(6,) bool`, which of the velocities are commanded.
        limits: Greatest accelerations, then greatest decelerations, `(2, 6) float64`.
        gains: Accelerations per difference of velocity, likewise.
        timeout: Age at which a command counts as 0 [s].
    """

    mask: Bools
    limits: Floats
    gains: Floats
    timeout: float

    def accelerations(self, velocity: Floats, command: Floats, age: float) -> Floats:
        """Return the accelerations `(6,)`, NaN of what is not commanded."""
        command = np.zeros(6) if age >= self.timeout else command
        error = command - velocity
        # By 0.01 m/s, robot_localization's, a velocity may pass its command without turning round.
        keeps_sign = np.abs(error) <= np.abs(command) + 0.01
        slows = np.abs(np.where(keeps_sign, command, 0.0)) < np.abs(velocity)
        limit, gain = (np.where(slows, pair[1], pair[0]) for pair in (self.limits, self.gains))
        return np.where(self.mask, np.clip(gain * error, -limit, limit), np.nan)


@dataclass
class Estimator:
    """A filter with a queue of measurements, as robot_localization's node runs it.

    Attributes:
        make_filter: Makes the filter in its first state.
        sensor_timeout: Silence after which the state is predicted on [s].
        history: How late a measurement may come and still count at its own time [s]; 0: not.
        predict_to_now: Whether each update ends at the present.
        stamp: Of the state [s]; None before the first measurement.
    """

    make_filter: Callable[[], Filter]
    noise: Noise
    sensor_timeout: float
    history: float = 0.0
    predict_to_now: bool = False
    control: Control | None = None
    stamp: float | None = None
    _queue: list[tuple[float, int, Measurement]] = field(default_factory=list)
    _past: deque[tuple[float, Floats, Floats]] = field(default_factory=deque)
    _taken: deque[Measurement] = field(default_factory=deque)
    _count: int = 0

    def __post_init__(self) -> None:
        self.filter = self.make_filter()
        self._command, self._commanded_at = np.zeros(6), -np.inf

    def add(self, measured: Measurement) -> None:
        """Queue a measurement."""
        self._count += 1
        heapq.heappush(self._queue, (measured.stamp, self._count, measured))

    def command(self, velocity: Floats, stamp: float) -> None:
        """Note a commanded velocity `(6,)` of a time [s]."""
        self._command, self._commanded_at = velocity, stamp

    def reset(self) -> None:
        """Forget everything."""
        self._clear()
        self.filter, self.stamp = self.make_filter(), None

    def set_pose(self, pose: Floats, covariance: Floats, stamp: float) -> None:
        """Continue from a pose `(6,)` of a covariance `(6, 6)`, at rest.

        Covariances of what else there is are 1e-6, robot_localization's.
        """
        self._clear()
        self.filter.state = np.concatenate((pose, np.zeros(SIZE - 6)))
        self.filter.covariance = np.eye(SIZE) * 1e-6
        self.filter.covariance[:6, :6] = covariance
        self.stamp = stamp

    def update(self, now: float) -> None:
        """Take the measurements up to a time [s]; in silence, predict."""
        due = bool(self._queue) and self._queue[0][0] <= now
        if due and self.history > 0.0:
            self._go_back(self._queue[0][0])
        while self._queue and self._queue[0][0] <= now:
            self._take(heapq.heappop(self._queue)[2])
        if self.stamp is not None:
            silent = not due and now - self.stamp >= self.sensor_timeout
            if (silent or self.predict_to_now) and now > self.stamp:
                self._predict(now)
        while self._past and self._past[0][0] < now - self.history:
            self._past.popleft()
        while self._taken and self._taken[0].stamp < now - self.history:
            self._taken.popleft()

    def at(self, stamp: float) -> tuple[Floats, Floats]:
        """Return state `(15,)` and covariance `(15, 15)`, predicted where a time [s] is later."""
        keeps = self.filter.state.copy(), self.filter.covariance.copy(), self.stamp
        if self.stamp is not None and stamp > self.stamp:
            self._predict(stamp)
        found = self.filter.state, self.filter.covariance
        self.filter.state, self.filter.covariance, self.stamp = keeps
        return found

    def _clear(self) -> None:
        for each in (self._queue, self._past, self._taken):
            each.clear()

    def _go_back(self, stamp: float) -> None:
        """Return to the last state before a time [s]; what was taken since is queued once more."""
        if self.stamp is None or stamp >= self.stamp:
            return
        if not self._past or self._past[0][0] > stamp:
            return  # too late: it counts now
        while self._past and self._past[-1][0] > stamp:
            self._past.pop()
        self.stamp, state, covariance = self._past[-1]
        self.filter.state, self.filter.covariance = state.copy(), covariance.copy()
        later = [one for one in self._taken if one.stamp > self.stamp]
        self._taken = deque(one for one in self._taken if one.stamp <= self.stamp)
        for measured in later:
            self.add(measured)

    def _take(self, measured: Measurement) -> None:
        if self.stamp is None:
            mask = measured.mask & np.isfinite(measured.values)
            self.filter.state[mask] = measured.values[mask]
            block = np.ix_(mask, mask)
            self.filter.covariance[block] = measured.covariance[block]
            self.stamp = measured.stamp
        else:
            if measured.stamp > self.stamp:
                self._predict(measured.stamp)
            self.filter.correct(measured)
        if self.history > 0.0:
            self._taken.append(measured)
            state = self.filter.state.copy(), self.filter.covariance.copy()
            self._past.append((self.stamp, *state))

    def _predict(self, now: float) -> None:
        assert self.stamp is not None
        dt = now - self.stamp
        accelerations = None
        if self.control is not None:
            velocity, age = self.filter.state[TWIST], now - self._commanded_at
            accelerations = self.control.accelerations(velocity, self._command, age)
        self.filter.predict(_ODD_STEP if dt > _ODD_GAP else dt, self.noise, accelerations)
        self.stamp = now
