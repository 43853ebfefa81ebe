"""Tracking: where a scan lies in a reference, from odometry's word."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatchStatus, ScanMatcher, invert
from arjuna_slam.matching.surface import Surface


class Tracker:
    """Tracks the pose in a reference; at keyframes, and when that fails, it searches as well.

    Args:
        config: The parameters.
        matcher: The scan matcher.
    """

    def __init__(self, config: SlamConfig, matcher: ScanMatcher) -> None:
        self._config = config
        self._matcher = matcher

    def locate(
        self,
        reference: Field,
        surface: Surface,
        prior: SE2,
        information: NDArray[np.float64],
        search: bool,
    ) -> Match:
        """Return where a scan lies in a reference.

        Args:
            reference: The field.
            surface: What the scan saw.
            prior: Robot in the field's frame, as odometry has it.
            information: Of the prior, `(3, 3) float64`.
            search: Whether to search the window even if tracking succeeds.
        """
        if not self._config.use_scan_matching:
            return Match(MatchStatus.MATCHED, prior, invert(information), 0.0)
        if not search:
            tracked = self._matcher.track(reference, surface, prior, information)
            if tracked.status in (MatchStatus.MATCHED, MatchStatus.TOO_FEW_POINTS):
                return tracked
        config = self._config
        return self._matcher.match(
            reference, surface, prior, config.window, config.match_minimum_response, information
        )
