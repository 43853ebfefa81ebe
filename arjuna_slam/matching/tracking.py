"""Tracking: the pose of a scan in a reference, starting from odometry."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import angle_param, length_param, param, speed_param
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatcherConfig, MatchStatus, ScanMatcher, invert
from arjuna_slam.matching.surface import Surface

_SURE = 0.5  # response from which a pose is not searched for farther off
_STRETCHED = 0.03  # deviation of the factor on odometry's distances before any was measured


class Trust:
    """Recent accuracy of odometry's positions, measured where scans see them well."""

    def __init__(self) -> None:
        self._square = 1.0

    def weigh(self, information: Floats) -> Floats:
        """Return the information of a step, `(3, 3)` as configured, as it has proven itself."""
        scale = np.array([self._square, self._square, 1.0]) ** -0.5
        return information * np.outer(scale, scale)

    def judge(self, prior: SE2, match: Match, information: Floats, travel: float) -> None:
        """Compare a step of odometry, of some travel [m], with the pose of the scan after it.

        `information` is that of the step as configured.
        """
        well_seen = 0.015  # [m] deviation of a match that can judge odometry
        seen = np.linalg.eigvalsh(match.covariance[:2, :2])[1] < well_seen**2
        if match.status is not MatchStatus.MATCHED or not seen:
            return
        error = np.array([match.T_field_base.x - prior.x, match.T_field_base.y - prior.y])
        square = 0.5 * float(error @ information[:2, :2] @ error)
        memory = 10.0  # [m] of travel over which odometry is judged
        share = min(1.0, travel / memory)
        deviation_share_min = 0.3  # least share of its configured deviation
        self._square = max(deviation_share_min**2, self._square + share * (square - self._square))


@dataclass(frozen=True)
class _Segment:
    reference: Field
    match: Match
    T_start_base: SE2 = IDENTITY


class Stretch:
    """Scale error of odometry: true by measured distance, by a Kalman filter of one state.

    The true radius of the wheels is never the configured one: that alone makes distances wrong by
    some percent, always to the same side.
    """

    def __init__(self) -> None:
        self.factor = 1.0
        self._variance = _STRETCHED**2
        self._segment: _Segment | None = None

    def of(self, delta: SE2) -> SE2:
        """Return a motion as odometry has it, stretched."""
        return SE2(self.factor * delta.x, self.factor * delta.y, delta.theta)

    def judge(self, reference: Field, match: Match, delta: SE2) -> None:
        """Compare odometry with the distance between two matches in one reference.

        `delta` is the motion since the match before, as odometry has it.
        """
        segment = self._segment
        if match.status is not MatchStatus.MATCHED:
            self._segment = None
            return
        if segment is None or segment.reference is not reference:
            self._segment = _Segment(reference, match)
            return
        self._segment = _Segment(reference, segment.match, segment.T_start_base @ delta)
        measured = math.hypot(self._segment.T_start_base.x, self._segment.T_start_base.y)
        base = 2.0  # [m] over which the factor is measured
        if measured >= base:
            self._measure(segment.match, match, measured)
            self._segment = _Segment(reference, match)

    def _measure(self, start: Match, end: Match, measured: float) -> None:
        gap = end.T_field_base.array()[:2] - start.T_field_base.array()[:2]
        travelled = float(np.hypot(*gap))
        along = gap / max(travelled, 1e-9)
        variances = [float(along @ m.covariance[:2, :2] @ along) for m in (start, end)]
        changes = 500.0  # [m] of travel over which the factor may change as much again
        self._variance += measured / changes * _STRETCHED**2
        seen_along = 0.025  # [m] deviation of a match that can measure the distance
        if max(variances) > seen_along**2:
            return
        innovation = measured**2 * self._variance + sum(variances)
        outlier = 3.0  # deviations beyond which a distance counts for no more
        most = outlier * math.sqrt(innovation)
        error = min(max(travelled - self.factor * measured, -most), most)
        gain = measured * self._variance / innovation
        self.factor += gain * error
        self._variance *= 1.0 - gain * measured


@dataclass(frozen=True)
class TrackerConfig(MatcherConfig):
    """Parameters of tracking, those of scan matching among them."""

    use_scan_matching: bool = param(
        True, "Whether scans correct the odometry; without, it is believed."
    )
    correlation_search_space_dimension: float = length_param(
        1.0, "Width of a keyframe's window.", maximum=10.0
    )
    widest_search_space_dimension: float = length_param(
        2.0,
        "Width up to which the window is doubled, with its angle, while less than half of the"
        " scan's points match: wheels slipped farther.",
        maximum=10.0,
        theirs=0.0,
    )
    slip_speed_max: float = speed_param(
        2.0, "Greatest speed of what is found in a window that was doubled.", minimum=0.01
    )
    coarse_search_angle_offset: float = angle_param(
        0.349, "Half the angle of a keyframe's window.", maximum=6.3
    )
    distance_variance_penalty: float = length_param(
        0.5, "Deviation of the penalty on the distance from the odometry."
    )
    angle_variance_penalty: float = angle_param(
        1.0, "Deviation of the penalty on the turn from the odometry."
    )
    minimum_distance_penalty: float = param(
        0.8, "Least the penalty on distance may become.", minimum=0.0
    )
    minimum_angle_penalty: float = param(
        0.9, "Least the penalty on the turn may become.", minimum=0.0
    )

    @property
    def window(self) -> Window:
        """The search window of a keyframe."""
        deviation_min = 1e-3  # of a penalty [m, rad]: none divides by zero
        return Window(
            0.5 * self.correlation_search_space_dimension,
            min(self.coarse_search_angle_offset, math.pi),
            3,
            max(self.distance_variance_penalty, deviation_min) ** 2,
            max(self.angle_variance_penalty, deviation_min) ** 2,
            self.minimum_distance_penalty,
            self.minimum_angle_penalty,
        )


class Tracker:
    """Tracks the pose in a reference; at keyframes, and when that fails, it searches as well."""

    def __init__(self, config: TrackerConfig, matcher: ScanMatcher) -> None:
        self._config = config
        self._matcher = matcher
        self._trust = Trust()
        self._stretch = Stretch()
        self._unsure = math.inf  # [s] since a scan matched well

    def locate(
        self,
        reference: Field,
        surface: Surface,
        T_field_last: SE2,
        delta: SE2,
        information: Floats,
        search: bool,
        gap: float = math.inf,
    ) -> Match:
        """Return where a scan lies in a reference.

        `delta` is the motion since the last scan by odometry, with its information, `gap` the time
        since then [s]; at `search` the window is searched even if tracking succeeds.
        """
        prior = T_field_last @ self.stretched(delta)
        if not self._config.use_scan_matching:
            return Match(MatchStatus.MATCHED, prior, invert(information), 0.0)
        held = self._trust.weigh(information)
        self._unsure += gap
        match = self._match(reference, surface, prior, held, search)
        if match.status is MatchStatus.MATCHED and match.response >= _SURE:
            self._unsure = 0.0
        self._trust.judge(prior, match, information, math.hypot(delta.x, delta.y))
        self._stretch.judge(reference, match, delta)
        return match

    def stretched(self, delta: SE2) -> SE2:
        """Return a motion as odometry has it, of the length it will have had."""
        return self._stretch.of(delta)

    def _match(
        self, reference: Field, surface: Surface, prior: SE2, information: Floats, search: bool
    ) -> Match:
        if not search:
            tracked = self._matcher.track(reference, surface, prior, information)
            sure = tracked.status is MatchStatus.MATCHED and tracked.response >= _SURE
            if sure or tracked.status is MatchStatus.TOO_FEW_POINTS:
                return tracked
        window, least = self._config.window, self._config.match_minimum_response
        best = self._matcher.match(reference, surface, prior, window, least, information)
        widest = 0.5 * self._config.widest_search_space_dimension
        reach = max(window.xy, self._config.slip_speed_max * self._unsure)
        while best.response < _SURE and 0.0 < window.xy <= 0.5 * widest:
            # A slip is no less likely for its length, nor the turn of a track width too narrow.
            window = replace(
                window,
                xy=2.0 * window.xy,
                theta=min(2.0 * window.theta, math.pi),
                distance_penalty=4.0 * window.distance_penalty,
                angle_penalty=4.0 * window.angle_penalty,
            )
            found = self._matcher.match(reference, surface, prior, window, least, information)
            # A scan of the floor, as the robot tips, fits somewhere: no wheels slip so far so fast.
            if found.response > best.response and prior.distance(found.T_field_base) <= reach:
                best = found
        return best
