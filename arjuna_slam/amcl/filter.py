"""The particle filter: AMCL's main flow, one call a scan."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2, wrap
from arjuna_slam.amcl.belief import Belief
from arjuna_slam.amcl.clusters import Cluster
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.estimate import (
    Estimate,
    Hypothesis,
    Status,
    Track,
    check_finite,
    check_inside,
    check_map,
    covariance_root,
)
from arjuna_slam.amcl.recovery import SEED_COVARIANCE, MapMatcher, Recovery
from arjuna_slam.amcl.scan_view import BEAMS_MIN, ScanView
from arjuna_slam.amcl.sensor_models import make_sensor
from arjuna_slam.matching.map_field import MapField
from arjuna_slam.matching.scan_filter import LastOdometry

_WIDE = 0.6  # deviation of a cluster whose mean says little of where its particles fit [m]
_INDIFFERENT = 0.015  # difference of agreement that decides nothing: three beams of 180


class ParticleFilter:
    """Monte Carlo localization with KLD sampling, refinement by scan matching, and recovery.

    Attributes:
        belief: The particles and their weights.

    Raises:
        LocalizationError: The map has no free cell.

    Source: Thrun, Burgard, Fox, Probabilistic Robotics, 2005, table 8.3; nav2_amcl.
    """

    def __init__(self, config: AmclConfig, grid: OccupancyGrid, rng: np.random.Generator) -> None:
        check_map(grid)
        field = MapField(grid, config.laser_likelihood_max_dist)
        self._config = config
        self.belief = Belief(config, field, rng)
        self._sensor = make_sensor(field, config)
        self._matcher = MapMatcher(config, field)
        self._recovery = Recovery(config, self._matcher)
        self._odometry = LastOdometry()
        self._track = Track()

    @property
    def initialized(self) -> bool:
        """True once a pose was set or a global localization was requested."""
        return len(self.belief.particles) > 0

    def set_pose(self, pose: SE2, covariance: Floats) -> None:
        """Start again around a pose [m, m, rad] of the base in the map, with a covariance `(3, 3)`.

        Raises:
            LocalizationError: The pose is not finite or off the map, or the covariance is none.
        """
        check_finite(pose, "the pose")
        check_inside(pose, self._matcher.field.frame)
        self.belief.spread(pose, covariance_root(covariance))
        self._restart(search=False)

    def globalize(self) -> None:
        """Start again with no idea of the pose; the next scan is looked for in the whole map."""
        self.belief.scatter()
        self._restart(search=self._config.relocalize)

    def _restart(self, search: bool) -> None:
        self._track = Track()
        self._recovery.restart(search)

    def update(self, T_odom_base: SE2, scan: Scan, force: bool = False) -> Estimate | None:
        """Take in a scan and the odometry at its stamp.

        The particles are moved and weighed once the robot has moved `update_min_d` or
        `update_min_a`, or at `force`; in between the pose follows by scan matching.

        Returns:
            The estimate, or None if there is nothing new to say: the robot stands and the scan
            agrees with the last estimate, or no pose was set yet.

        Raises:
            LocalizationError: The odometry is not finite.
        """
        check_finite(T_odom_base, "the odometry pose")
        if not self.initialized:
            return None
        view = ScanView.of(self._odometry.with_motion(scan, T_odom_base), self._config)
        self._odometry.advance(scan.stamp, T_odom_base)
        if not (self._track.due(T_odom_base, self._config) or force or self._recovery.wanted):
            follow = self._config.match_scans and not self._blind(T_odom_base, view)
            best = self._follow(T_odom_base, view) if follow else None
            if best is None:
                return None
        else:
            if (step := self._track.step(T_odom_base)) is not None:
                self.belief.move(step)
            if self._blind(T_odom_base, view):
                return self._track.conclude(self._unseen(T_odom_base), T_odom_base, self._config)
            self._weigh(view)
            if self.belief.resample(self._recovery.averages.injection):
                self._recovery.averages.reset()
            best = self._verify(T_odom_base, view)
        best = self._relocalize(best, T_odom_base, view)
        return self._track.conclude(best, T_odom_base, self._config)

    def _blind(self, T_odom_base: SE2, view: ScanView) -> bool:
        """Return whether too few beams returned from what the map knows, if it has obstacles."""
        last = self._track.estimate
        if not self._matcher.field.shows:
            return True
        if view.blind or last is None or self._recovery.wanted or not self._config.match_scans:
            return view.blind
        return self._matcher.known(last.T_map_odom @ T_odom_base, view) < BEAMS_MIN

    def _weigh(self, view: ScanView) -> None:
        if not len(view.few.ranges):
            return
        likelihood = self._sensor.weigh(self.belief.particles, view)
        self._recovery.averages.add(float(self.belief.weights @ likelihood.levels))
        self.belief.reweigh(self.belief.level(likelihood.factors))

    def _verify(self, T_odom_base: SE2, view: ScanView) -> Hypothesis:
        """Match each cluster to the scan, weigh clusters by all beams, return the heaviest."""
        clusters = self.belief.clusters()
        matches = self._config.match_scans
        followed = self._followed(T_odom_base, view) if matches else None
        found = [self._match(one, followed, view) for one in clusters]
        left = None if followed is None else self._left_behind(clusters, found, followed, view)
        if left is not None:
            self.belief.seed([left], SEED_COVARIANCE)
            return left
        scores = np.array([self._matcher.explained(pose, view) for pose, _ in found])
        behind = np.minimum(0.0, view.returned * (scores - scores.max()) + _INDIFFERENT)
        agreeing = np.array([score for _, score in found]) >= self._config.relocalize_agreement
        tied = (behind == 0.0) & agreeing & matches
        evidence = self._config.relocalize_evidence * behind * matches
        shares = self.belief.shift(np.exp(evidence), tied)
        k = int(np.argmax(shares))
        return Hypothesis(found[k][0], clusters[k].covariance, found[k][1], float(shares[k]))

    def _left_behind(
        self, clusters: list[Cluster], found: list[tuple[SE2, float]], followed: SE2, view: ScanView
    ) -> Hypothesis | None:
        """Return the pose followed so far if it explains the scan and no cluster is near it.

        Particles follow odometry: who is pushed aside leaves them, and matching alone goes along.
        """
        if any(one.holds(followed.array()) for one in clusters):
            return None
        agreement = self._matcher.agreement(followed, view)
        if agreement < self._config.relocalize_agreement:
            return None
        others = max(self._matcher.explained(pose, view) for pose, _ in found)
        gain = view.returned * (self._matcher.explained(followed, view) - others)
        is_better = gain > self._config.relocalize_gain
        return Hypothesis(followed, SEED_COVARIANCE, agreement, 1.0) if is_better else None

    def _match(self, cluster: Cluster, followed: SE2 | None, view: ScanView) -> tuple[SE2, float]:
        """Match a cluster to the scan; keep the pose followed so far if it is one of its own.

        Unless that fits worse: the filter is the judge.
        """
        kept, score = None, 0.0
        excellent = 0.95  # agreement that no other pose can clearly exceed
        if followed is not None and cluster.holds(followed.array()):
            kept, score = followed, self._matcher.agreement(followed, view)
            if score >= excellent:
                return kept, score
        mean = SE2.from_array(cluster.mean)
        if not self._config.match_scans:
            return mean, self._matcher.agreement(mean, view)
        deviations = np.sqrt(cluster.covariance.diagonal())
        pose, matched = self._matcher.best_near(mean, view, deviations)
        unlikely = max(matched, score) < self._config.relocalize_doubt
        if unlikely and max(deviations[:2]) > _WIDE:
            pose, matched = self._best_within(cluster, view, pose, matched)
        if kept is None:
            return pose, matched
        fits = view.returned * (matched - score) > _INDIFFERENT
        if fits:  # not for what lies in the unknown alone
            gain = self._matcher.explained(pose, view) - self._matcher.explained(kept, view)
            fits = view.returned * gain > _INDIFFERENT
        return (pose, matched) if fits else (kept, score)

    def _best_within(
        self, cluster: Cluster, view: ScanView, pose: SE2, score: float
    ) -> tuple[SE2, float]:
        """Match from particles of a wide cluster, as after a stretch in the open."""
        starts = 48  # spread over all particles
        particles = self.belief.particles
        for start in particles[:: max(1, len(particles) // starts)]:
            if cluster.holds(start):
                other = self._matcher.refined(SE2.from_array(start), view)
                other_score = self._matcher.agreement(other, view)
                if other_score > score:
                    pose, score = other, other_score
        return pose, score

    def _unseen(self, T_odom_base: SE2) -> Hypothesis:
        """Move the last estimate along; particles that no scan has weighed stray by chance."""
        cluster, last = self.belief.clusters()[0], self._track.estimate
        pose = SE2.from_array(cluster.mean)
        if last is not None and self._config.match_scans:
            pose = last.T_map_odom @ T_odom_base
        return Hypothesis(pose, cluster.covariance, None, cluster.share)

    def _follow(self, T_odom_base: SE2, view: ScanView) -> Hypothesis | None:
        """Move the last estimate along, without the particles; None if there is nothing new."""
        last = self._track.estimate
        if last is None or self._track.best is None:
            return None
        pose = last.T_map_odom @ T_odom_base
        score = self._matcher.agreement(pose, view)
        moved = np.abs((last.T_map_base.inverse() @ pose).array()).max()
        settled = last.status in (Status.TRACKING, Status.AMBIGUOUS)
        still = 1e-3  # [m, rad] below which the robot has not moved since the last scan
        if moved < still and settled and score >= self._config.relocalize_doubt:
            self._recovery.lost.reset()
            return None
        refined = self._followed(T_odom_base, view)
        if refined is not None:
            refined_score = self._matcher.agreement(refined, view)
            if refined_score >= min(score, self._config.relocalize_agreement):
                pose, score = refined, refined_score
        return replace(self._track.best, T_map_base=pose, agreement=score)

    def _followed(self, T_odom_base: SE2, view: ScanView) -> SE2 | None:
        """Return the last estimate moved along by odometry and matched to the scan."""
        last = self._track.estimate
        if last is None:
            return None
        pose = last.T_map_odom @ T_odom_base
        return self._matcher.refined(pose, view, self._drift(last.T_map_base.inverse() @ pose))

    def _drift(self, step: SE2) -> Floats:
        """Return odometry's error over a scan's step, `(3,) float64` [m, m, rad], as by alphas."""
        drift, most = 0.005, 0.2  # at least, and a share at most
        length, turn, c = math.hypot(step.x, step.y), abs(wrap(step.theta)), self._config
        ahead, aside, about, bend = np.minimum(
            most, np.sqrt((c.alpha3, c.alpha5, c.alpha1, c.alpha2))
        )
        position = drift + ahead * length + aside * turn
        return np.array((position, position, drift + about * turn + bend * length))

    def _relocalize(self, best: Hypothesis, T_odom_base: SE2, view: ScanView) -> Hypothesis:
        """Seed particles at poses where the scan fits better, once it has fit badly for long."""
        assert best.agreement is not None
        if view.sparse and not self._recovery.wanted:
            return best
        if not self._recovery.due(best.agreement, view.stamp):
            return best
        found = self._recovery.search(best, view)
        if not found:
            return best
        self.belief.seed(found, SEED_COVARIANCE)
        self._track.updated_at = T_odom_base
        return found[0]
