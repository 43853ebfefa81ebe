"""Recovery: noticing that the robot is lost, and proposing where it might be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_slam.amcl.field import DistanceField
from arjuna_slam.amcl.refine import refine
from arjuna_slam.amcl.search import GlobalSearch, distinct
from arjuna_slam.amcl.sensors.agreement import agreement
from arjuna_slam.amcl.sensors.observation import Observation

EVIDENCE = 40.0  # log-likelihood of one more unit of agreement: so many beams are independent
_PROPOSALS = 24  # poses of the search that are refined and compared beam by beam
_MARGIN = 0.1  # agreement by which a proposal may fall short of the best and be kept
_HYPOTHESES = 6
_BACKOFF_MAX = 8.0  # longest wait between two searches [s]


class LikelihoodAverages:
    """Slow and fast averages of the likelihood, whose ratio says how much chance to inject.

    Args:
        alpha_slow: Decay rate of the long-term average.
        alpha_fast: Decay rate of the short-term average.

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
        """Forget the averages; the next update starts them anew."""
        self._slow = self._fast = 0.0


class LostDetector:
    """Says when scans have disagreed with the map for so long that the map must be searched.

    Args:
        threshold: Agreement (0..1) below which a scan disagrees.
        patience: How long scans must disagree [s].
    """

    def __init__(self, threshold: float, patience: float) -> None:
        self._threshold = threshold
        self._patience = patience
        self.reset()

    def reset(self) -> None:
        """Take the next scan as the first."""
        self._since: float | None = None
        self._wait = self._patience

    def observe(self, agreement: float, now: float) -> bool:
        """Take in one scan; return whether a search is due.

        Args:
            agreement: Of the scan with the map at the present estimate, 0..1.
            now: Stamp of the scan [s].
        """
        if agreement >= self._threshold:
            self.reset()
            return False
        if self._since is None or now < self._since:
            self._since = now
        return now - self._since >= self._wait

    def searched(self, now: float) -> None:
        """Begin the wait for the next search, each twice as long as the one before."""
        self._since = now
        self._wait = min(max(2.0 * self._wait, self._patience), _BACKOFF_MAX)


@dataclass(frozen=True)
class Hypothesis:
    """A place where the robot may be.

    Attributes:
        pose: `(3,) float64` in the map frame [m, m, rad].
        agreement: Share of beams that agree with the map there, 0..1.
        share: Its probability among the hypotheses, 0..1.
    """

    pose: NDArray[np.float64]
    agreement: float
    share: float


def propose(
    search: GlobalSearch,
    field: DistanceField,
    seen: Observation,
    present: NDArray[np.float64],
) -> list[Hypothesis]:
    """Return the places that explain a scan about equally well, best first.

    Args:
        search: Of the map.
        field: The map's distances.
        seen: The scan.
        present: Poses that compete with those found, `(K, 3) float64` [m, m, rad].
    """
    found = np.vstack((present, search.find(seen.many.endpoints, _PROPOSALS)))
    poses = np.array([refine(field, pose, seen.many.endpoints) for pose in found])
    scores = np.array([agreement(field, pose, seen) for pose in poses])
    keep = distinct(poses, scores, _HYPOTHESES)
    keep = keep[scores[keep] >= scores[keep[0]] - _MARGIN]
    shares = np.exp(EVIDENCE * (scores[keep] - scores[keep[0]]))
    shares /= shares.sum()
    return [
        Hypothesis(poses[i], float(scores[i]), float(share))
        for i, share in zip(keep, shares, strict=True)
    ]
