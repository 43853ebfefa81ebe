"""Tracking: where a scan lies in a reference, from odometry's word."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.odometry import Stretch, Trust
from arjuna_slam.matching.scan_matcher import Match, MatcherConfig, MatchStatus, ScanMatcher, invert
from arjuna_slam.matching.surface import Surface

_LEAST = 1e-3  # deviation of a penalty [m, rad]: 0 leaves the prior alone, and divides by no zero


@dataclass(frozen=True)
class TrackerConfig(MatcherConfig):
    """Parameters of tracking, those of scan matching among them."""

    use_scan_matching: bool = param(
        True, "Whether scans correct the odometry; without, it is believed."
    )
    correlation_search_space_dimension: float = param(
        1.0,
        "Width of the search window of a keyframe; slam_toolbox's 0.5 loses slipping wheels.",
        unit="m",
        minimum=0.0,
        maximum=10.0,
    )
    coarse_search_angle_offset: float = param(
        0.349,
        "Half the angle of the search window of a keyframe.",
        unit="rad",
        minimum=0.0,
        maximum=6.3,
    )
    distance_variance_penalty: float = param(
        0.5, "Deviation of the penalty on the distance from the odometry.", unit="m", minimum=0.0
    )
    angle_variance_penalty: float = param(
        1.0, "Deviation of the penalty on the turn from the odometry.", unit="rad", minimum=0.0
    )
    minimum_distance_penalty: float = param(
        0.8, "Least the penalty on distance may become.", minimum=0.0
    )
    minimum_angle_penalty: float = param(
        0.9, "Least the penalty on the turn may become.", minimum=0.0
    )

    @property
    def window(self) -> Window:
        """Where a keyframe is searched."""
        return Window(
            0.5 * self.correlation_search_space_dimension,
            min(self.coarse_search_angle_offset, math.pi),
            3,
            max(self.distance_variance_penalty, _LEAST) ** 2,
            max(self.angle_variance_penalty, _LEAST) ** 2,
            self.minimum_distance_penalty,
            self.minimum_angle_penalty,
        )


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
        self._stretch = Stretch()

    def locate(
        self,
        reference: Field,
        surface: Surface,
        T_field_last: SE2,
        delta: SE2,
        information: NDArray[np.float64],
        search: bool,
    ) -> Match:
        """Return where a scan lies in a reference.

        Args:
            reference: The field.
            surface: What the scan saw.
            T_field_last: Robot in the field's frame at the last scan.
            delta: Its motion since, as odometry has it.
            information: Of the motion, `(3, 3) float64`.
            search: Whether to search the window even if tracking succeeds.
        """
        prior = T_field_last @ self.stretched(delta)
        if not self._config.use_scan_matching:
            return Match(MatchStatus.MATCHED, prior, invert(information), 0.0)
        held = self._trust.weigh(information)
        match = self._match(reference, surface, prior, held, search)
        self._trust.judge(prior, match, information, math.hypot(delta.x, delta.y))
        self._stretch.judge(reference, match, delta)
        return match

    def stretched(self, delta: SE2) -> SE2:
        """Return a motion as odometry has it, of the length it will have had."""
        return self._stretch.of(delta)

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
