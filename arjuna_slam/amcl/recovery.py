"""Recovery: noticing that the robot is lost, and proposing where it might be."""

from __future__ import annotations

import math

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2, wrap
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.estimate import Hypothesis
from arjuna_slam.amcl.scan_view import ScanView, known_ends, share_agreeing
from arjuna_slam.matching.correlative import GlobalSearch, distinct
from arjuna_slam.matching.map_field import MapField

# Coarse to fine, so that the basin is wide and the end unmoved by what the map does not have [m]
_SCALES = np.array((0.36, 0.36, 0.24, 0.12, 0.12, 0.12, 0.12))
_WITHIN = np.array((0.5, 0.5, math.radians(15.0)))  # a refined pose farther away is another one
_GAIN_MIN = 0.02  # agreement by which another start must be better; less is chance
_STARTS = [SE2(0.2 * math.cos(a), 0.2 * math.sin(a)) for a in np.arange(8) * math.pi / 4]
ANYWHERE = np.array((1.0, 1.0, 1.0))  # deviations of a pose of which little is known [m, m, rad]


class MapMatcher:
    """Matches scans with a map."""

    def __init__(self, config: AmclConfig, field: MapField) -> None:
        self._config = config
        self.field = field

    def agreement(self, pose: SE2, view: ScanView) -> float:
        """Return the share of beams (0..1) that agree with the map at a pose of the base."""
        return share_agreeing(self.field, pose, view, self._config.agreement_distance)

    def explained(self, pose: SE2, view: ScanView) -> float:
        """Return the agreement where what lies in the unknown counts against a pose, 0..1."""
        return share_agreeing(self.field, pose, view, self._config.agreement_distance, True)

    def known(self, pose: SE2, view: ScanView) -> int:
        """Return the number of beams that returned from what the map knows."""
        return known_ends(self.field, pose, view)

    def refined(self, pose: SE2, view: ScanView, deviations: Floats = ANYWHERE) -> SE2:
        """Return the pose at which beams end nearest to obstacles, near a given one of the base.

        Where the map explains that badly, and many beams end near by, the others are tried alone.
        Where the scan says nothing, along a bare corridor, the pose stays, as where none near it
        fits. `deviations` say how far it may be off, `(3,)` [m, m, rad].
        """
        everything, *others = view.readings
        best = self._moved(pose, everything, deviations)
        score = self.agreement(best, view) if others else 1.0
        if score >= self._config.relocalize_doubt:
            return best
        for reading in others:  # people pull the scan to the walls that they stand before
            other = self._moved(pose, reading, deviations)
            if self.agreement(other, view) > score + _GAIN_MIN:
                best = other
        return best

    def _moved(self, pose: SE2, reading: tuple[Floats, Floats], deviations: Floats) -> SE2:
        information = np.diag(1.0 / np.maximum(deviations, 1e-3) ** 2)
        deviation = self._config.match_deviation
        found = self.field.refine(pose, *reading, information, _SCALES, deviation)
        change = (found.x - pose.x, found.y - pose.y, wrap(found.theta - pose.theta))
        return found if (np.abs(change) <= _WITHIN).all() else pose

    def best_near(self, pose: SE2, view: ScanView, deviations: Floats) -> tuple[SE2, float]:
        """Return the refined pose and its agreement; where poor, the best of several starts.

        A wall has two faces, and matching may settle on the wrong one. Arguments as in `refined`.
        """
        best = self.refined(pose, view, deviations)
        score = self.agreement(best, view)
        if score >= self._config.relocalize_doubt:
            return best, score
        for start in _STARTS:
            other = self.refined(SE2(pose.x + start.x, pose.y + start.y, pose.theta), view)
            other_score = self.agreement(other, view)
            if other_score > score + _GAIN_MIN:
                best, score = other, other_score
        return best, score


SEED_COVARIANCE = np.diag([0.05**2, 0.05**2, math.radians(2.0) ** 2])  # of a pose just matched


class LikelihoodAverages:
    """Slow and fast averages of the likelihood, whose ratio says how many particles to inject.

    Source: Thrun, Burgard, Fox, Probabilistic Robotics, 2005, table 8.3 (augmented MCL).
    """

    def __init__(self, alpha_slow: float, alpha_fast: float) -> None:
        self._alphas = (alpha_slow, alpha_fast)
        self._slow = 0.0
        self._fast = 0.0

    def add(self, likelihood: float) -> None:
        """Take in the average likelihood of one update."""
        if self._slow == 0.0:
            self._slow = self._fast = likelihood
        self._slow += self._alphas[0] * (likelihood - self._slow)
        self._fast += self._alphas[1] * (likelihood - self._fast)

    @property
    def injection(self) -> float:
        """Share of particles (0..1) to replace by random ones."""
        if self._slow == 0.0 or min(self._alphas) == 0.0:
            return 0.0
        return max(0.0, 1.0 - self._fast / self._slow)

    def reset(self) -> None:
        """Forget the averages; the next update starts them again."""
        self._slow = self._fast = 0.0


class LostDetector:
    """Says when scans have disagreed with the map for so long that the map must be searched.

    A scan disagrees below the `threshold` (0..1); `patience` is the first wait, `longest` the
    longest between two searches [s].
    """

    def __init__(self, threshold: float, patience: float, longest: float) -> None:
        self._threshold = threshold
        self._patience = patience
        self._longest = longest
        self.reset()

    def reset(self) -> None:
        """Take the next scan as the first."""
        self._since: float | None = None
        self._wait = self._patience

    def observe(self, agreement: float, now: float) -> bool:
        """Take in one scan's agreement (0..1) and stamp [s]; return whether a search is due."""
        if agreement >= self._threshold:
            self.reset()
            return False
        if self._since is None or now < self._since:
            self._since = now
        return now - self._since >= self._wait

    def searched(self, now: float) -> None:
        """Begin the wait for the next search, each twice as long as the one before."""
        self._since = now
        self._wait = min(max(2.0 * self._wait, self._patience), self._longest)


class Recovery:
    """Notices that the robot is lost, and looks for it in the whole map.

    Attributes:
        averages: Of the likelihood.
        lost: Says when to search.
        wanted: Whether to search with the next scan, however well it fits.
    """

    def __init__(self, config: AmclConfig, matcher: MapMatcher) -> None:
        self._config, self._matcher = config, matcher
        self._search: GlobalSearch | None = None
        c = config
        self.averages = LikelihoodAverages(c.recovery_alpha_slow, c.recovery_alpha_fast)
        self.lost = LostDetector(c.relocalize_doubt, c.relocalize_patience, c.relocalize_wait)
        self.wanted = False

    def restart(self, search: bool) -> None:
        """Forget the scans so far; search with the next one if asked to."""
        self.wanted = search
        self.averages.reset()
        self.lost.reset()

    def due(self, agreement: float, now: float) -> bool:
        """Return whether to search the map, from a scan's agreement (0..1) and stamp [s]."""
        lost = self.lost.observe(agreement, now)
        return self.wanted or (lost and self._config.relocalize)

    def search(self, best: Hypothesis, view: ScanView) -> list[Hypothesis]:
        """Return the poses that explain a scan, best first; none if the present one explains it."""
        assert best.agreement is not None
        found = self.propose(view, [] if self.wanted else [best.T_map_base])
        self.lost.searched(view.stamp)
        # What is a gain of some beams of a whole scan is a greater share of the few that return.
        gain = self._config.relocalize_gain / max(view.returned, 1e-3)
        lost_share = 2.0 / 3.0  # of the gain that another pose needs, where the robot is lost
        if best.agreement < self._config.relocalize_agreement:
            gain *= lost_share
        if not self.wanted and (found[0].agreement or 0.0) <= best.agreement + gain:
            return []
        self.wanted = False
        self.averages.reset()
        return found

    def propose(self, view: ScanView, present: list[SE2]) -> list[Hypothesis]:
        """Return poses, those present too, that explain a scan about equally well, best first."""
        if self._search is None:
            self._search = GlobalSearch(self._matcher.field)
        proposals = 24  # refined and compared beam by beam
        found = [self._search.find(ends, proposals) for ends, _ in view.readings]
        starts = present + [SE2.from_array(pose) for pose in np.vstack(found)]
        poses = [self._matcher.refined(start, view) for start in starts]
        scores = np.array([self._matcher.explained(pose, view) for pose in poses])
        most = 6  # each needs its share of the particles
        keep = distinct(np.array([pose.array() for pose in poses]), scores, most)
        margin = 0.1  # agreement by which a proposal may fall short of the best
        keep = keep[scores[keep] >= scores[keep[0]] - margin]
        shares = np.exp(self._config.relocalize_evidence * (scores[keep] - scores[keep[0]]))
        return [
            Hypothesis(poses[i], SEED_COVARIANCE, float(scores[i]), float(share))
            for i, share in zip(keep, shares / shares.sum(), strict=True)
        ]
