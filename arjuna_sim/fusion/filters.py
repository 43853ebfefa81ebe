"""The Kalman filters of robot_localization: extended, and unscented."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Floats
from arjuna_sim.fusion.kinematics import (
    ACCELERATION,
    ANGLES,
    SIZE,
    TWIST,
    jacobian,
    transition,
    wrapped,
)

# robot_localization's: no measurement is without an error, or the gain's inverse does not exist
_LEAST_VARIANCE = 1e-9


@dataclass(frozen=True)
class Measurement:
    """Some of the states, measured.

    Attributes:
        stamp: Time [s].
        values: `(15,) float64`; those that are not finite do not count.
        covariance: `(15, 15) float64`.
        mask: `(15,) bool`, which states are measured.
        threshold: Mahalanobis distance beyond which it is an outlier.
        source: Topic and part of it, which orders measurements of one time.
    """

    stamp: float
    values: Floats
    covariance: Floats
    mask: Bools
    threshold: float = np.inf
    source: str = ""


@dataclass(frozen=True)
class Noise:
    """The process's noise.

    Attributes:
        covariance: Of one second, `(15, 15) float64`.
        dynamic: Whether that of the pose grows with the square of the velocity.
    """

    covariance: Floats
    dynamic: bool = False

    def after(self, state: Floats, dt: float) -> Floats:
        """Return what a time [s] adds to the covariance."""
        noise = self.covariance * dt
        if self.dynamic:
            noise[:6, :6] *= float(state[TWIST] @ state[TWIST])
        return noise


@dataclass
class Filter(ABC):
    """A Kalman filter that measures states themselves, so that all its kinds correct alike.

    Attributes:
        state: `(15,) float64`.
        covariance: `(15, 15) float64`.
    """

    state: Floats = field(default_factory=lambda: np.zeros(SIZE))
    covariance: Floats = field(default_factory=lambda: np.eye(SIZE) * _LEAST_VARIANCE)

    @abstractmethod
    def predict(self, dt: float, noise: Noise, accelerations: Floats | None = None) -> None:
        """Advance by a time [s], under a command's accelerations `(6,)`."""

    def correct(self, measured: Measurement) -> bool:
        """Take a measurement; return whether it was no outlier."""
        index, innovation, noise = _innovation(measured, self.state)
        columns = self.covariance[:, index]
        inverse = np.linalg.inv(columns[index] + noise)
        if innovation @ inverse @ innovation >= measured.threshold**2:
            return False
        gain = columns @ inverse
        self.state = self.state + gain @ innovation
        self.state[ANGLES] = wrapped(self.state[ANGLES])
        rest = np.eye(SIZE)
        rest[:, index] -= gain
        self.covariance = rest @ self.covariance @ rest.T + gain @ noise @ gain.T
        return True


class ExtendedFilter(Filter):
    """The extended Kalman filter of Moore and Stouch, 2014."""

    def predict(self, dt: float, noise: Noise, accelerations: Floats | None = None) -> None:
        """Advance by a time [s], under a command's accelerations `(6,)`."""
        matrix = transition(self.state, dt)
        derivative = jacobian(self.state, dt, matrix)
        added = noise.after(self.state, dt)
        self.state = matrix @ _driven(self.state, dt, accelerations)
        self.state[ANGLES] = wrapped(self.state[ANGLES])
        self.covariance = derivative @ self.covariance @ derivative.T + added


@dataclass
class UnscentedFilter(Filter):
    """The unscented Kalman filter.

    Source: Wan and van der Merwe, The unscented Kalman filter for nonlinear estimation, 2000.

    Attributes:
        alpha: Spread of the sigma points.
        kappa: Their second scale.
        beta: What is known of the distribution; 2 of a Gaussian one.
    """

    alpha: float = 1e-3
    kappa: float = 0.0
    beta: float = 2.0

    def predict(self, dt: float, noise: Noise, accelerations: Floats | None = None) -> None:
        """Advance by a time [s], under a command's accelerations `(6,)`."""
        added = noise.after(self.state, dt)
        driven = (_driven(point, dt, accelerations) for point in self._points())
        points = np.array([transition(point, dt) @ point for point in driven])
        self.state, deviations = self._mean(points)
        self.covariance = (deviations.T * self._weights()[1]) @ deviations + added

    @property
    def _scale(self) -> float:
        return self.alpha**2 * (SIZE + self.kappa)

    def _points(self) -> Floats:
        values, vectors = np.linalg.eigh(self.covariance * self._scale)
        root = (vectors * np.sqrt(np.maximum(values, 0.0))).T
        return np.concatenate((self.state[None], self.state + root, self.state - root))

    def _weights(self) -> tuple[Floats, Floats]:
        mean = np.full(2 * SIZE + 1, 0.5 / self._scale)
        mean[0] = 1.0 - SIZE / self._scale
        covariance = mean.copy()
        covariance[0] += 1.0 - self.alpha**2 + self.beta
        return mean, covariance

    def _mean(self, points: Floats) -> tuple[Floats, Floats]:
        """Return the mean of sigma points and their deviations; angles differ from the first's."""
        offsets = points - points[0]
        offsets[:, ANGLES] = wrapped(offsets[:, ANGLES])
        mean = self._weights()[0] @ offsets
        state = points[0] + mean
        state[ANGLES] = wrapped(state[ANGLES])
        return state, offsets - mean


def _driven(state: Floats, dt: float, accelerations: Floats | None) -> Floats:
    """Return a state under a command: its accelerations, and turn rates that a time [s] changed."""
    if accelerations is None:
        return state
    result: Floats = state.copy()
    result[9:12] += np.nan_to_num(accelerations[3:]) * dt
    known = np.isfinite(accelerations[:3])
    result[ACCELERATION][known] = accelerations[:3][known]
    return result


def _innovation(measured: Measurement, state: Floats) -> tuple[NDArray[np.intp], Floats, Floats]:
    """Return the measured states' indices, how they differ from a state, and their covariance."""
    index = np.flatnonzero(measured.mask & np.isfinite(measured.values))
    noise = measured.covariance[np.ix_(index, index)]
    diagonal = np.arange(len(index))
    noise[diagonal, diagonal] = np.maximum(np.abs(noise.diagonal()), _LEAST_VARIANCE)
    innovation = measured.values[index] - state[index]
    angles = (index >= ANGLES.start) & (index < ANGLES.stop)
    innovation[angles] = wrapped(innovation[angles])
    return index, innovation, noise
