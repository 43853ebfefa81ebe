"""The particle filter: AMCL's main flow, one call a scan."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2, wrap
from arjuna_slam.amcl.agreement import Rays, agreement
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.errors import (
    LocalizationError,
    check_finite,
    check_inside,
    check_map,
    check_particle_limits,
    covariance_root,
)
from arjuna_slam.amcl.estimate import Cluster, Estimate, Status, find_clusters
from arjuna_slam.amcl.field import DistanceField
from arjuna_slam.amcl.motion import make_motion
from arjuna_slam.amcl.recovery import (
    EVIDENCE,
    Hypothesis,
    LikelihoodAverages,
    LostDetector,
    propose,
)
from arjuna_slam.amcl.refine import refine
from arjuna_slam.amcl.resample import kld_resample, low_variance_indices
from arjuna_slam.amcl.search import GlobalSearch
from arjuna_slam.amcl.sensor import all_endpoints, make_sensor, select_endpoints

__all__ = ["AmclConfig", "Estimate", "LocalizationError", "ParticleFilter", "Status"]

_BEAMS_MIN = 10  # fewer beams with a return say nothing about where the robot is
_RIVAL = 0.02  # lighter clusters are no hypothesis
_RIVALS_MAX = 6
_SURE = 0.75  # share of the weight above which the heaviest cluster is the answer
_INDIFFERENT = 0.03  # difference of agreement that decides nothing
_SEED_COVARIANCE = np.diag([0.05**2, 0.05**2, math.radians(2.0) ** 2])
_REFINED_WITHIN = np.array([0.5, 0.5, math.radians(15.0)])


@dataclass(frozen=True)
class _Answer:
    """The hypothesis that wins: pose `(3,)`, covariance `(3, 3)`, agreement and share, 0..1."""

    pose: NDArray[np.float64]
    covariance: NDArray[np.float64]
    agreement: float
    share: float


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
        check_particle_limits(config)
        self._config, self._grid, self._rng = config, grid, rng
        self._field = DistanceField(grid, config.laser_likelihood_max_dist)
        self._motion = make_motion(config)
        self._sensor = make_sensor(self._field, config)
        self._search: GlobalSearch | None = None
        self._averages = LikelihoodAverages(config.recovery_alpha_slow, config.recovery_alpha_fast)
        self._lost = LostDetector(config.relocalize_agreement, config.relocalize_patience)
        self._particles = np.empty((0, 3))
        self._weights = np.empty(0)
        self._T_odom_base: SE2 | None = None  # at the last update; None after a new start
        self._T_map_odom = IDENTITY
        self._answer = _Answer(np.zeros(3), np.zeros((3, 3)), 0.0, 0.0)
        self._status = Status.LOST
        self._updates = 0
        self._search_wanted = False

    @property
    def initialized(self) -> bool:
        """Whether a pose was set or a global localization asked for."""
        return len(self._particles) > 0

    @property
    def particles(self) -> NDArray[np.float64]:
        """The particles, `(N, 3) float64` in the map frame [m, m, rad]."""
        return self._particles

    @property
    def weights(self) -> NDArray[np.float64]:
        """The particles' weights, `(N,) float64`, which sum to 1."""
        return self._weights

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
        root = covariance_root(covariance)
        draws = self._rng.standard_normal((self._config.max_particles, 3)) @ root.T
        self._start(pose.array() + draws)

    def globalize(self) -> None:
        """Start anew with no idea of the pose; the next scan is looked for in the whole map."""
        self._start(self._field.sample_free(self._config.max_particles, self._rng))
        self._search_wanted = self._config.relocalize

    def update(self, T_odom_base: SE2, scan: Scan, force: bool = False) -> Estimate | None:
        """Take in a scan.

        Args:
            T_odom_base: Odometry at the scan's stamp.
            scan: The scan.
            force: Whether to update even if the robot has not moved.

        Returns:
            The estimate, or None if there is nothing new to say: the robot moved less than
            `update_min_d` and `update_min_a` and the scan agrees with the last estimate, or no
            pose was set yet.

        Raises:
            LocalizationError: The odometry is not finite.
        """
        check_finite(T_odom_base, "the odometry pose")
        if not self.initialized:
            return None
        endpoints, rays = all_endpoints(scan, self._config), Rays.of(scan, self._config)
        blind = len(endpoints) < _BEAMS_MIN
        if not (self._due(T_odom_base) or force or self._search_wanted):
            return None if blind else self._check(T_odom_base, scan, endpoints, rays)
        self._move(T_odom_base)
        if blind:
            return self._conclude(T_odom_base, self._heaviest(), blind=True)
        self._weigh(select_endpoints(scan, self._config), scan.range_max)
        self._resample()
        answer = self._compare(self._clusters(), endpoints, rays)
        return self._settle(T_odom_base, scan.stamp, answer, endpoints, rays)

    def _start(self, particles: NDArray[np.float64]) -> None:
        self._particles = particles
        self._particles[:, 2] = wrap(particles[:, 2])
        self._weights = np.full(len(particles), 1.0 / len(particles))
        self._T_odom_base = None
        self._search_wanted = False
        self._averages.reset()
        self._lost.reset()

    def _due(self, T_odom_base: SE2) -> bool:
        """Whether the robot moved enough, each coordinate by itself as in nav2_amcl."""
        if self._T_odom_base is None:
            return True
        last, c = self._T_odom_base, self._config
        far = max(abs(T_odom_base.x - last.x), abs(T_odom_base.y - last.y)) > c.update_min_d
        return far or abs(wrap(T_odom_base.theta - last.theta)) > c.update_min_a

    def _move(self, T_odom_base: SE2) -> None:
        if self._T_odom_base is not None:
            delta = self._T_odom_base.inverse() @ T_odom_base
            self._particles = self._motion.sample(self._particles, delta, self._rng)
        self._T_odom_base = T_odom_base

    def _weigh(self, endpoints: NDArray[np.float64], range_max: float) -> None:
        if not len(endpoints):
            return
        likelihood = self._sensor.weigh(self._particles, endpoints, range_max)
        self._averages.add(float(self._weights @ likelihood.levels))
        self._reweigh(likelihood.factors)

    def _reweigh(self, factors: NDArray[np.float64]) -> None:
        weights = self._weights * factors
        self._weights = weights / weights.sum()

    def _resample(self) -> None:
        self._updates += 1
        if self._updates % self._config.resample_interval:
            return
        c = self._config
        limits = (c.pf_err, c.pf_z, c.min_particles, c.max_particles)
        self._particles = kld_resample(self._particles, self._weights, limits, self._rng)
        injected = self._rng.random(len(self._particles)) < self._averages.injection
        if injected.any():
            self._particles[injected] = self._field.sample_free(int(injected.sum()), self._rng)
            self._averages.reset()
        self._weights = np.full(len(self._particles), 1.0 / len(self._particles))

    def _clusters(self) -> list[Cluster]:
        return find_clusters(self._particles, self._weights, _RIVAL, _RIVALS_MAX)

    def _heaviest(self) -> _Answer:
        cluster = self._clusters()[0]
        return _Answer(cluster.mean, cluster.covariance, 0.0, cluster.share)

    def _compare(
        self, clusters: list[Cluster], endpoints: NDArray[np.float64], rays: Rays
    ) -> _Answer:
        """Refine each cluster's mean, weigh clusters by all beams, return the heaviest."""
        poses = [self._refined(cluster.mean, endpoints) for cluster in clusters]
        scores = np.array([agreement(self._field, pose, rays) for pose in poses])
        if len(clusters) > 1:
            factors = np.ones(len(self._particles))
            for cluster, score in zip(clusters, scores, strict=True):
                behind = min(0.0, score - scores.max() + _INDIFFERENT)
                factors[cluster.members] = math.exp(EVIDENCE * behind)
            self._reweigh(factors)
        shares = [float(self._weights[cluster.members].sum()) for cluster in clusters]
        best = int(np.argmax(shares))
        covariance = clusters[best].covariance
        return _Answer(poses[best], covariance, float(scores[best]), shares[best])

    def _refined(
        self, pose: NDArray[np.float64], endpoints: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Refine a pose by scan matching, unless that leads elsewhere."""
        refined = refine(self._field, pose, endpoints)
        change = refined - pose
        change[2] = wrap(change[2])
        return refined if (np.abs(change) <= _REFINED_WITHIN).all() else pose

    def _check(
        self, T_odom_base: SE2, scan: Scan, endpoints: NDArray[np.float64], rays: Rays
    ) -> Estimate | None:
        """Compare a scan with the last estimate while the robot has not moved enough."""
        least = self._config.relocalize_agreement
        pose = (self._T_map_odom @ T_odom_base).array()
        score = agreement(self._field, pose, rays)
        if score >= least and self._status in (Status.TRACKING, Status.AMBIGUOUS):
            self._lost.reset()
            return None
        refined = self._refined(pose, endpoints)
        refined_score = agreement(self._field, refined, rays)
        if refined_score >= least:
            pose, score = refined, refined_score
        answer = replace(self._answer, pose=pose, agreement=score)
        return self._settle(T_odom_base, scan.stamp, answer, endpoints, rays)

    def _settle(
        self,
        T_odom_base: SE2,
        now: float,
        answer: _Answer,
        endpoints: NDArray[np.float64],
        rays: Rays,
    ) -> Estimate:
        """Search the whole map if the answer has been bad for long, then report."""
        due = self._lost.observe(answer.agreement, now) and self._config.relocalize
        if due or self._search_wanted:
            answer = self._relocalize(now, answer, endpoints, rays)
            self._T_odom_base = T_odom_base
        return self._conclude(T_odom_base, answer)

    def _relocalize(
        self, now: float, answer: _Answer, endpoints: NDArray[np.float64], rays: Rays
    ) -> _Answer:
        """Seed particles wherever the scan fits the map, if it fits anywhere better than here."""
        if self._search is None:
            self._search = GlobalSearch(self._field)
        present = answer.pose[np.newaxis][: 0 if self._search_wanted else 1]
        found = propose(self._search, self._field, endpoints, rays, present)
        self._lost.searched(now)
        if not self._search_wanted and found[0].agreement <= answer.agreement:
            return answer
        self._search_wanted = False
        self._seed(found)
        return _Answer(found[0].pose, _SEED_COVARIANCE, found[0].agreement, found[0].share)

    def _seed(self, found: list[Hypothesis]) -> None:
        """Replace the particles by draws around hypotheses, in proportion to their shares."""
        count = self._config.max_particles
        poses = np.array([hypothesis.pose for hypothesis in found])
        shares = np.array([hypothesis.share for hypothesis in found])
        centres = poses[low_variance_indices(shares, count, self._rng)]
        draws = self._rng.standard_normal((count, 3)) @ np.sqrt(_SEED_COVARIANCE)
        self._particles = centres + draws
        self._particles[:, 2] = wrap(self._particles[:, 2])
        self._weights = np.full(count, 1.0 / count)
        self._averages.reset()

    def _conclude(self, T_odom_base: SE2, answer: _Answer, blind: bool = False) -> Estimate:
        """Keep the answer and report it."""
        T_map_base = SE2.from_array(answer.pose)
        self._answer = answer
        self._T_map_odom = T_map_base @ T_odom_base.inverse()
        self._status, reason = self._judge(answer, blind)
        quality = 0.0 if blind else answer.agreement * answer.share
        return Estimate(
            T_map_base, self._T_map_odom, answer.covariance, quality, reason, self._status
        )

    def _judge(self, answer: _Answer, blind: bool) -> tuple[Status, str]:
        if blind:
            return Status.BLIND, f"fewer than {_BEAMS_MIN} beams returned; odometry alone"
        agree = f"{answer.agreement:.0%} of the beams agree with the map"
        if answer.agreement < self._config.relocalize_agreement:
            return Status.LOST, f"only {agree}"
        if answer.share < _SURE:
            return Status.AMBIGUOUS, f"{agree}, but other places explain {1 - answer.share:.0%}"
        return Status.TRACKING, agree
