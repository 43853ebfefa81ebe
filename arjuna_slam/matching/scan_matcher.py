"""Scan matching: where a scan lies in a reference field, and how certain that is."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats
from arjuna_core.config import angle_param, length_param, param, share_param
from arjuna_core.se2 import SE2, wrap
from arjuna_slam.matching.correlative import Window, search
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.refinement import observed, refine, solve
from arjuna_slam.matching.surface import Surface

_UNKNOWN_INFORMATION = np.diag(
    [1.0, 1.0, 1.0]
)  # 1 m, 1 rad: information on a direction that is never seen
_FLAT = np.zeros((3, 3))


class MatchStatus(enum.Enum):
    """Outcome of a match."""

    MATCHED = "matched"
    TOO_FEW_POINTS = "too few points"
    LOW_RESPONSE = "low response"
    NOT_CONVERGED = "not converged"


@njit(cache=True)
def invert(matrix: Floats) -> Floats:
    """Return the inverse of a covariance or information matrix, `(3, 3) float64`."""
    result = np.empty((3, 3))
    for k in range(3):
        unit = np.zeros(3)
        unit[k] = 1.0
        result[k] = solve(matrix, unit)
    return result


@dataclass(frozen=True)
class Match:
    """The result of matching one scan."""

    status: MatchStatus  # whether the pose can be used
    # robot in the field's frame; the prior where the status says it cannot be used
    T_field_base: SE2
    # of `x, y, theta` in the field's frame, `(3, 3) float64` [m^2, m rad, rad^2]
    covariance: Floats
    response: float  # share (0..1) of the scan's points that lie on the reference's surfaces

    @property
    def information(self) -> Floats:
        """The inverse of the covariance, `(3, 3) float64`."""
        return invert(self.covariance)

    def covariance_in(self, T_other_field: SE2) -> Floats:
        """Return the covariance in the axes of another frame, `(3, 3) float64`."""
        turn = SE2(0.0, 0.0, T_other_field.theta).matrix()
        turned: Floats = turn @ self.covariance @ turn.T
        return turned

    def unseen(self, prior: Floats) -> Floats:
        """Return the covariance of the direction that is hardly seen, `(3, 3) float64`; or zero.

        Of the heading as well where the match failed: then nothing is seen. `prior` is the
        information on the step to the scan.
        """
        if self.status is not MatchStatus.MATCHED:
            return invert(prior)
        covariance = invert(prior + self.information)
        values, axes = np.linalg.eigh(covariance[:2, :2])
        result = np.zeros((3, 3))
        hardly_seen = 0.05  # [m] deviation from which a direction counts as not seen
        for value, axis in zip(values, axes.T, strict=True):
            if value > hardly_seen**2:
                result[:2, :2] += value * np.outer(axis, axis)
        return result


@dataclass(frozen=True)
class MatcherConfig:
    """Parameters of scan matching."""

    match_minimum_points: int = param(
        10, "Valid points below which a scan is not matched.", minimum=3, maximum=10000
    )
    match_minimum_response: float = share_param(
        0.3, "Share of points on surfaces below which it fails."
    )
    match_iterations: int = param(20, "Most Gauss-Newton steps.", minimum=1, maximum=1000)
    match_robust_scale: float = length_param(
        0.05, "Distance of a quarter of the weight.", minimum=1e-3, maximum=1.0
    )
    range_deviation: float = length_param(
        0.02, "Deviation of a point from its surface.", minimum=1e-4, maximum=1.0
    )
    beam_correlation: float = param(10.0, "Points that share one error.", minimum=1.0, maximum=1e4)
    match_position_floor: float = length_param(
        0.005, "Least deviation of a match in position.", minimum=1e-5, maximum=1.0
    )
    match_heading_floor: float = angle_param(
        0.002, "Least deviation of a match in heading.", minimum=1e-5, maximum=1.0
    )


def score(field: Field, points: Floats, prior: SE2, pose: SE2, window: Window) -> float:
    """Return the response that `search` would give a pose; arguments as there."""
    likelihood = float(field.likelihood(pose.apply(points)).mean())
    gap = (pose.x - prior.x) ** 2 + (pose.y - prior.y) ** 2
    distance = max(1.0 - 0.2 * gap / window.distance_penalty, window.floor_xy)
    turn = float(wrap(pose.theta - prior.theta))
    angle = max(1.0 - 0.2 * turn * turn / window.angle_penalty, window.floor_theta)
    return likelihood * distance * angle


class ScanMatcher:
    """Matches surfaces against fields."""

    def __init__(self, config: MatcherConfig) -> None:
        self._config = config
        self._scales = np.full(config.match_iterations, config.match_robust_scale)
        self._floor = np.diag(
            [
                config.match_position_floor**2,
                config.match_position_floor**2,
                config.match_heading_floor**2,
            ]
        )

    def track(
        self, field: Field, surface: Surface, prior: SE2, information: Floats = _FLAT
    ) -> Match:
        """Refine a pose known to some centimetres, with the information on it; zero for none."""
        if len(surface) < self._config.match_minimum_points:
            return self._failed(MatchStatus.TOO_FEW_POINTS, prior, 0.0)
        return self._refine(field, surface, prior, prior, information)

    def match(
        self,
        field: Field,
        surface: Surface,
        prior: SE2,
        window: Window,
        least: float,
        information: Floats = _FLAT,
    ) -> Match:
        """Track a pose from the prior, and search a window for a better one.

        `least` is the response (0..1) that a pose must exceed in the search, `information` that of
        the prior in the refinement, zero for none.
        """
        if len(surface) < self._config.match_minimum_points:
            return self._failed(MatchStatus.TOO_FEW_POINTS, prior, 0.0)
        most = 360  # points that the search scores; the refinement takes all
        points = surface.points[:: math.ceil(len(surface) / most)]
        tracked = self._refine(field, surface, prior, prior, information)
        gain = 0.02  # what a searched pose's response must gain on the tracked one
        if tracked.status is MatchStatus.MATCHED:
            reached = score(field, points, prior, tracked.T_field_base, window)
            if reached > least:
                least = reached + gain
            else:
                tracked = self._failed(MatchStatus.LOW_RESPONSE, prior, tracked.response)
        found = search(field, points, prior, window, least)
        if found is None:
            return tracked
        match = self._refine(field, surface, found[0], prior, information)
        if not self._outweighs(match, tracked, prior, information, len(surface)):
            return tracked
        if tracked.status is not MatchStatus.MATCHED:
            return match
        return match if match.response > tracked.response + gain else tracked

    def _outweighs(
        self, match: Match, tracked: Match, prior: SE2, information: Floats, count: int
    ) -> bool:
        """Return whether the points that a searched pose gains speak louder than its prior.

        Of a wall's end, some points fit at other poses as well; slips are rare, not impossible.
        """
        gap = match.T_field_base.array() - prior.array()
        gap[2] = wrap(gap[2])
        doubted, of_point = 3.0, 3.0  # deviations as of loops; log ratio of a point that fits
        unlikely = math.log1p(float(gap @ information @ gap) / doubted**2)
        gain = max(0.0, match.response - tracked.response)
        return of_point * gain * count / self._config.beam_correlation >= unlikely

    def _refine(
        self, field: Field, surface: Surface, start: SE2, prior: SE2, information: Floats
    ) -> Match:
        """Refine a pose with the information of its prior.

        A scan's points share errors (`beam_correlation`). Where it says less of the heading than
        the prior does, as of a single box in a hall, the prior must not be outvoted by them.
        """
        match = self._settle(field, surface, start, prior, information)
        if match.covariance[2, 2] * information[2, 2] <= 1.0:
            return match
        correlated = self._config.beam_correlation * information
        return self._settle(field, surface, start, prior, correlated)

    def _settle(
        self, field: Field, surface: Surface, start: SE2, prior: SE2, information: Floats
    ) -> Match:
        config = self._config
        reference = field.index, field.planes, field.resolution, field.origin
        pose, _, total, square, steps = refine(
            reference,
            surface.points, surface.normals,
            start.array(), prior.array(), information + 1e-6 * _UNKNOWN_INFORMATION,
            self._scales, config.range_deviation,
        )  # fmt: skip
        response = total / len(surface)
        if response < config.match_minimum_response:
            return self._failed(MatchStatus.LOW_RESPONSE, prior, response)
        if steps < 0:
            return self._failed(MatchStatus.NOT_CONVERGED, prior, response)
        seen = observed(reference, surface.points, surface.normals, pose, float(self._scales[-1]))
        information = seen / config.range_deviation**2
        covariance = self._covariance(information, square)
        return Match(MatchStatus.MATCHED, SE2.from_array(pose), covariance, response)

    def _covariance(self, h: Floats, square: float) -> Floats:
        """Return the inverse of the information, scaled up where points fit worse than assumed."""
        config = self._config
        misfit = max(1.0, square / config.range_deviation**2)
        information = h / (config.beam_correlation * misfit) + _UNKNOWN_INFORMATION
        return invert(information) + self._floor

    def _failed(self, status: MatchStatus, prior: SE2, response: float) -> Match:
        return Match(status, prior, invert(_UNKNOWN_INFORMATION), response)
