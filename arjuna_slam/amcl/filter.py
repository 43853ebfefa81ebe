"""The particle filter: AMCL's main flow, one call a scan."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2, wrap
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.errors import (
    LocalizationError,
    check_finite,
    check_inside,
    check_map,
    covariance_root,
)
from arjuna_slam.amcl.estimate import Answer, Estimate, Status, conclude
from arjuna_slam.amcl.field import DistanceField
from arjuna_slam.amcl.particles.belief import SEED_COVARIANCE, Belief
from arjuna_slam.amcl.particles.clusters import Cluster
from arjuna_slam.amcl.recovery import EVIDENCE, LikelihoodAverages, LostDetector, propose
from arjuna_slam.amcl.refine import refine, refine_around
from arjuna_slam.amcl.search import GlobalSearch
from arjuna_slam.amcl.sensors.agreement import agreement
from arjuna_slam.amcl.sensors.models import make_sensor
from arjuna_slam.amcl.sensors.observation import Observation
from arjuna_slam.matching.deskew import motion_within

__all__ = ["AmclConfig", "Estimate", "LocalizationError", "ParticleFilter", "Status"]

_INDIFFERENT = 0.015  # difference of agreement that decides nothing
_STILL = np.array((1e-3, 1e-3, 1e-3))  # a robot that moved less since the last scan stands [m, rad]
_EXCELLENT = 0.95  # agreement that leaves nothing to look for
_BETTER, _BETTER_IF_LOST = 0.15, 0.1  # agreement by which another place must be better
_DRIFT = np.array(
    (0.005, 0.005, 0.005)
)  # by which odometry may err from scan to scan [m, m, rad] ...
_DRIFT_SHARE = 0.2  # ... and per unit of motion


class ParticleFilter:
    """Monte Carlo localization with KLD sampling, refinement by scan matching, and recovery.

    Args:
        config: Parameters.
        grid: The map.
        rng: Source of all chance.

    Raises:
        LocalizationError: The map has no free or no occupied cell, or the particle limits cross.

    Source: Thrun, Burgard, Fox, Probabilistic Robotics, 2005, table 8.3; nav2_amcl.
    """

    def __init__(self, config: AmclConfig, grid: OccupancyGrid, rng: np.random.Generator) -> None:
        check_map(grid)
        self._config, self._grid = config, grid
        self._field = DistanceField(grid, config.laser_likelihood_max_dist)
        self._belief = Belief(config, self._field, rng)
        self._sensor = make_sensor(self._field, config)
        self._search: GlobalSearch | None = None
        self._averages = LikelihoodAverages(config.recovery_alpha_slow, config.recovery_alpha_fast)
        self._lost = LostDetector(config.relocalize_doubt, config.relocalize_patience)
        self._updated_at: SE2 | None = None  # odometry at the last update; None after a new start
        self._seen_at = IDENTITY  # odometry at the last estimate
        self._last: tuple[float, SE2] | None = None  # stamp [s] of and odometry at the last scan
        self._estimate: Estimate | None = None
        self._answer = Answer(np.zeros(3), np.zeros((3, 3)), None, 0.0)
        self._tied = np.zeros(0, bool)
        self._search_wanted = False

    @property
    def initialized(self) -> bool:
        """Whether a pose was set or a global localization asked for."""
        return len(self._belief.particles) > 0

    @property
    def particles(self) -> NDArray[np.float64]:
        """The particles, `(N, 3) float64` in the map frame [m, m, rad]."""
        return self._belief.particles

    @property
    def weights(self) -> NDArray[np.float64]:
        """The particles' weights, `(N,) float64`, which sum to 1."""
        return self._belief.weights

    def set_pose(self, pose: SE2, covariance: NDArray[np.float64]) -> None:
        """Start anew around a pose of the base in the map.

        Args:
            pose: [m, m, rad].
            covariance: Of x, y, theta, `(3, 3) float64`.

        Raises:
            LocalizationError: The pose is not finite or off the map, or the covariance is none.
        """
        check_finite(pose, "the pose")
        check_inside(pose, self._grid)
        self._belief.spread(pose, covariance_root(covariance))
        self._begin(search=False)

    def globalize(self) -> None:
        """Start anew with no idea of the pose; the next scan is looked for in the whole map."""
        self._belief.scatter()
        self._begin(search=self._config.relocalize)

    def _begin(self, search: bool) -> None:
        self._updated_at = self._estimate = None
        self._tied = np.zeros(0, bool)
        self._search_wanted = search
        self._averages.reset()
        self._lost.reset()

    def update(self, T_odom_base: SE2, scan: Scan, force: bool = False) -> Estimate | None:
        """Take in a scan.

        The particles are moved and weighed once the robot has moved `update_min_d` or
        `update_min_a`; from one such update to the next the pose follows by scan matching.

        Args:
            T_odom_base: Odometry at the scan's stamp.
            scan: The scan.
            force: Whether to update the particles even if the robot has not moved.

        Returns:
            The estimate, or None if there is nothing new to say: the robot stands and the scan
            agrees with the last estimate, or no pose was set yet.

        Raises:
            LocalizationError: The odometry is not finite.
        """
        check_finite(T_odom_base, "the odometry pose")
        if not self.initialized:
            return None
        seen = Observation.of(self._straightened(T_odom_base, scan), self._config)
        if not (self._due(T_odom_base) or force or self._search_wanted):
            return self._follow(T_odom_base, seen)
        if self._updated_at is not None:
            self._belief.move(self._updated_at.inverse() @ T_odom_base)
        self._updated_at = T_odom_base
        if seen.blind:
            return self._report(T_odom_base, self._unseen(self._belief.clusters()[0]))
        self._weigh(seen)
        if self._belief.resample(self._averages.injection):
            self._averages.reset()
        return self._settle(
            T_odom_base, seen, self._compare(self._belief.clusters(), T_odom_base, seen)
        )

    def _straightened(self, T_odom_base: SE2, scan: Scan) -> Scan:
        """Return the scan with the motion within it, at the velocity since the last one."""
        before, self._last = self._last, (scan.stamp, T_odom_base)
        if scan.time_increment == 0.0 or before is None:
            return scan
        delta, gap = before[1].inverse() @ T_odom_base, scan.stamp - before[0]
        return replace(scan, motion=motion_within(scan, delta, gap))

    def _due(self, T_odom_base: SE2) -> bool:
        """Whether the robot moved enough, each coordinate by itself as in nav2_amcl."""
        if self._updated_at is None:
            return True
        last, c = self._updated_at, self._config
        far = max(abs(T_odom_base.x - last.x), abs(T_odom_base.y - last.y)) > c.update_min_d
        return far or abs(wrap(T_odom_base.theta - last.theta)) > c.update_min_a

    def _follow(self, T_odom_base: SE2, seen: Observation) -> Estimate | None:
        """Move the last estimate along, without the particles."""
        if seen.blind or self._estimate is None:
            return None
        moved = np.abs((self._seen_at.inverse() @ T_odom_base).array())
        pose = (self._estimate.T_map_odom @ T_odom_base).array()
        score, enough = agreement(self._field, pose, seen), self._config.relocalize_doubt
        settled = self._estimate.status in (Status.TRACKING, Status.AMBIGUOUS)
        if (moved < _STILL).all() and settled and score >= enough:
            self._lost.reset()
            return None
        refined = self._followed(T_odom_base, seen)
        refined_score = agreement(self._field, refined, seen)
        if refined_score >= min(score, self._config.relocalize_agreement):
            pose, score = refined, refined_score
        return self._settle(T_odom_base, seen, replace(self._answer, pose=pose, agreement=score))

    def _followed(self, T_odom_base: SE2, seen: Observation) -> NDArray[np.float64]:
        """Return the last estimate moved along by odometry and matched to the scan."""
        assert self._estimate is not None
        moved = np.abs((self._seen_at.inverse() @ T_odom_base).array())
        pose = (self._estimate.T_map_odom @ T_odom_base).array()
        drift = _DRIFT + _DRIFT_SHARE * moved.max()
        return refine(self._field, pose, seen.many.endpoints, drift)

    def _weigh(self, seen: Observation) -> None:
        if not len(seen.few.ranges):
            return
        likelihood = self._sensor.weigh(self._belief.particles, seen)
        self._averages.add(float(self._belief.weights @ likelihood.levels))
        self._belief.reweigh(self._belief.level(likelihood.factors, self._tied))

    @staticmethod
    def _unseen(cluster: Cluster) -> Answer:
        return Answer(cluster.mean, cluster.covariance, None, cluster.share)

    def _compare(self, clusters: list[Cluster], T_odom_base: SE2, seen: Observation) -> Answer:
        """Match each cluster to the scan, weigh clusters by all beams, return the heaviest."""
        followed = None if self._estimate is None else self._followed(T_odom_base, seen)
        found = [self._match(one, followed, seen) for one in clusters]
        scores = np.array([score for _, score in found])
        behind = np.minimum(0.0, scores - scores.max() + _INDIFFERENT)
        shares = self._belief.shift(np.exp(EVIDENCE * behind))
        self._tied = (behind == 0.0) & (scores >= self._config.relocalize_agreement)
        best = int(np.argmax(shares))
        return Answer(
            found[best][0], clusters[best].covariance, found[best][1], float(shares[best])
        )

    def _match(
        self, cluster: Cluster, followed: NDArray[np.float64] | None, seen: Observation
    ) -> tuple[NDArray[np.float64], float]:
        """Match a cluster to the scan; keep the pose followed so far if it is one of its own.

        Unless that fits worse: the filter is the judge.
        """
        kept = followed is not None and cluster.holds(followed)
        score = agreement(self._field, followed, seen) if kept and followed is not None else 0.0
        if followed is not None and score >= _EXCELLENT:
            return followed, score
        deviations = np.sqrt(cluster.covariance.diagonal())
        pose, matched = refine_around(self._field, cluster.mean, seen, deviations)
        if followed is not None and kept and score >= matched - _INDIFFERENT:
            return followed, score
        return pose, matched

    def _settle(self, T_odom_base: SE2, seen: Observation, answer: Answer) -> Estimate:
        """Search the whole map if the answer has been bad for long, then report."""
        assert answer.agreement is not None
        due = self._lost.observe(answer.agreement, seen.stamp) and self._config.relocalize
        if due or self._search_wanted:
            answer = self._relocalize(answer, seen)
            self._updated_at = T_odom_base
        return self._report(T_odom_base, answer)

    def _relocalize(self, answer: Answer, seen: Observation) -> Answer:
        """Seed particles wherever the scan fits the map, if it fits anywhere better than here."""
        assert answer.agreement is not None
        if self._search is None:
            self._search = GlobalSearch(self._field)
        present = answer.pose[np.newaxis][: 0 if self._search_wanted else 1]
        found = propose(self._search, self._field, seen, present)
        self._lost.searched(seen.stamp)
        lost = answer.agreement < self._config.relocalize_agreement
        better = answer.agreement + (_BETTER_IF_LOST if lost else _BETTER)
        if not self._search_wanted and found[0].agreement <= better:
            return answer
        self._search_wanted = False
        poses = np.array([hypothesis.pose for hypothesis in found])
        self._belief.seed(poses, np.array([hypothesis.share for hypothesis in found]))
        self._tied = np.zeros(0, bool)
        self._averages.reset()
        return Answer(found[0].pose, SEED_COVARIANCE, found[0].agreement, found[0].share)

    def _report(self, T_odom_base: SE2, answer: Answer) -> Estimate:
        """Keep the answer and say what it amounts to."""
        self._answer, self._seen_at = answer, T_odom_base
        self._estimate = conclude(answer, T_odom_base, self._config.relocalize_agreement)
        return self._estimate
