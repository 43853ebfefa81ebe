"""What odometry is worth: how far its positions are off, and by how much its ways are too short.

Along a corridor only odometry knows how far the robot went; so what it does wrong is learnt where
scans see that as well.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatchStatus

_WELL_SEEN = 0.015  # deviation of a match up to which it judges odometry [m]
_MEMORY = 10.0  # way over which odometry is judged [m]
_LEAST = 0.3  # share of its configured deviation that odometry is at least expected to have
_STRETCHED = 0.03  # deviation of the factor on odometry's ways before any was measured
_CHANGES = 500.0  # way over which the factor may change as much again [m]
_BASE = 2.0  # way over which a factor is measured [m]
_SEEN_ALONG = 0.025  # deviation of a match along a way up to which it measures the way [m]
_OUTLIER = 3.0  # deviations beyond which a measured way counts for no more


class Trust:
    """How good odometry's positions have been of late, where scans saw them well."""

    def __init__(self) -> None:
        self._square = 1.0

    def weigh(self, information: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the information of an odometry step as it has proven itself.

        Args:
            information: As configured, `(3, 3) float64`.
        """
        scale = np.array([self._square, self._square, 1.0]) ** -0.5
        return information * np.outer(scale, scale)

    def judge(self, prior: SE2, match: Match, information: NDArray[np.float64], way: float) -> None:
        """Compare a step with where the scan then lay.

        Args:
            prior: Where odometry put the robot.
            match: Where it was.
            information: Of the step, as configured, `(3, 3) float64`.
            way: Its length [m].
        """
        seen = np.linalg.eigvalsh(match.covariance[:2, :2])[1] < _WELL_SEEN**2
        if match.status is not MatchStatus.MATCHED or not seen:
            return
        error = np.array([match.T_field_base.x - prior.x, match.T_field_base.y - prior.y])
        square = 0.5 * float(error @ information[:2, :2] @ error)
        share = min(1.0, way / _MEMORY)
        self._square = max(_LEAST**2, self._square + share * (square - self._square))


@dataclass(frozen=True)
class _Way:
    """A way since a match, as odometry has it."""

    reference: Field
    match: Match
    T_start_base: SE2 = IDENTITY


class Stretch:
    """The factor by which ways are longer than odometry says, by a Kalman filter of one state.

    Wheels are never as large as is believed: that alone makes ways wrong by some percent, always
    to the same side.
    """

    def __init__(self) -> None:
        self.factor = 1.0
        self._variance = _STRETCHED**2
        self._way: _Way | None = None

    def of(self, delta: SE2) -> SE2:
        """Return a motion as odometry has it, stretched."""
        return SE2(self.factor * delta.x, self.factor * delta.y, delta.theta)

    def judge(self, reference: Field, match: Match, delta: SE2) -> None:
        """Compare the way with that between two matches in one reference.

        Args:
            reference: What was matched against.
            match: Where the robot then was.
            delta: Its motion as odometry has it, since the match before.
        """
        way = self._way
        if match.status is not MatchStatus.MATCHED:
            self._way = None
            return
        if way is None or way.reference is not reference:
            self._way = _Way(reference, match)
            return
        self._way = _Way(reference, way.match, way.T_start_base @ delta)
        told = math.hypot(self._way.T_start_base.x, self._way.T_start_base.y)
        if told >= _BASE:
            self._measure(way.match, match, told)
            self._way = _Way(reference, match)

    def _measure(self, start: Match, end: Match, told: float) -> None:
        gap = end.T_field_base.array()[:2] - start.T_field_base.array()[:2]
        went = float(np.hypot(*gap))
        along = gap / max(went, 1e-9)
        variances = [float(along @ m.covariance[:2, :2] @ along) for m in (start, end)]
        self._variance += told / _CHANGES * _STRETCHED**2
        if max(variances) > _SEEN_ALONG**2:
            return
        innovation = told**2 * self._variance + sum(variances)
        most = _OUTLIER * math.sqrt(innovation)
        error = min(max(went - self.factor * told, -most), most)
        gain = told * self._variance / innovation
        self.factor += gain * error
        self._variance *= 1.0 - gain * told
