"""Tracking: where a scan lies in a reference, from odometry's word."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatcherConfig, MatchStatus, ScanMatcher, invert
from arjuna_slam.matching.surface import Surface

_WELL_SEEN = 0.015  # deviation of a match up to which it judges odometry [m]
_MEMORY = 10.0  # way over which odometry is judged [m]
_LEAST = 0.3  # share of its configured deviation that odometry is at least expected to have


@dataclass(frozen=True)
class TrackerConfig(MatcherConfig):
    """Parameters of tracking, those of scan matching among them."""

    use_scan_matching: bool = param(
        True, "Whether scans correct the odometry; without, it is believed."
    )
    correlation_search_space_dimension: float = param(
        1.0,
        "Width of the search window of a keyframe; 0.5 (slam_toolbox) loses slipping wheels.",
        unit="m",
        minimum=0.0,
        maximum=10.0,
    )
    coarse_search_angle_offset: float = param(
        0.349,
        "Half the angle of the search window of a keyframe.",
        unit="rad",
        minimum=0.0,
        maximum=3.15,
    )
    distance_variance_penalty: float = param(
        0.5, "Deviation of the penalty on the distance from the odometry.", unit="m", minimum=1e-3
    )
    angle_variance_penalty: float = param(
        1.0, "Deviation of the penalty on the turn from the odometry.", unit="rad", minimum=1e-3
    )
    minimum_distance_penalty: float = param(
        0.8, "Least the penalty on distance may become.", minimum=0.0, maximum=1.0
    )
    minimum_angle_penalty: float = param(
        0.9, "Least the penalty on the turn may become.", minimum=0.0, maximum=1.0
    )

    @property
    def window(self) -> Window:
        """Where a keyframe is searched."""
        return Window(
            0.5 * self.correlation_search_space_dimension,
            self.coarse_search_angle_offset,
            3,
            self.distance_variance_penalty**2,
            self.angle_variance_penalty**2,
            self.minimum_distance_penalty,
            self.minimum_angle_penalty,
        )


class Trust:
    """How good odometry's positions have been of late, where scans saw them well.

    Along a corridor only odometry knows how far the robot went, so that it matters how well.
    """

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


class Tracker:
    """Tracks the pose in a reference; at keyframes, and when that fails, it searches as well.

    Args:
        config: The parameters.
        matcher: The scan matcher.
    """

    def __init__(self, config: TrackerConfig, matcher: ScanMatcher) -> None:
        self._config = config
        self._matcher = matcher
        self._trust = Trust()

    def locate(
        self,
        reference: Field,
        surface: Surface,
        prior: SE2,
        information: NDArray[np.float64],
        way: float,
        search: bool,
    ) -> Match:
        """Return where a scan lies in a reference.

        Args:
            reference: The field.
            surface: What the scan saw.
            prior: Robot in the field's frame, as odometry has it.
            information: Of the prior, `(3, 3) float64`.
            way: How far it has come since the last scan [m].
            search: Whether to search the window even if tracking succeeds.
        """
        if not self._config.use_scan_matching:
            return Match(MatchStatus.MATCHED, prior, invert(information), 0.0)
        held = self._trust.weigh(information)
        match = self._match(reference, surface, prior, held, search)
        self._trust.judge(prior, match, information, way)
        return match

    def _match(
        self,
        reference: Field,
        surface: Surface,
        prior: SE2,
        information: NDArray[np.float64],
        search: bool,
    ) -> Match:
        if not search:
            tracked = self._matcher.track(reference, surface, prior, information)
            if tracked.status in (MatchStatus.MATCHED, MatchStatus.TOO_FEW_POINTS):
                return tracked
        config = self._config
        return self._matcher.match(
            reference, surface, prior, config.window, config.match_minimum_response, information
        )
