"""What clusters of particles are, and which poses belong to one."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from arjuna_slam.amcl.clusters import Cluster, connect, find_clusters

SPREAD = Cluster(1.0, np.array([1.0, 2.0, 3.1]), np.diag([0.1**2, 0.2**2, 0.3**2]))


@pytest.mark.parametrize(
    ("axis", "reach"), [(0, 0.3 + 0.05), (1, 0.6 + 0.05), (2, 0.9 + 0.05)], ids=["x", "y", "theta"]
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_cluster_holds_what_lies_within_three_deviations(
    axis: int, reach: float, sign: float
) -> None:
    for part, held in ((0.97, True), (1.03, False)):
        pose = SPREAD.mean.copy()
        pose[axis] += sign * part * reach
        pose[2] = math.remainder(pose[2], math.tau)  # the same heading, however it is written
        assert SPREAD.holds(pose) is held


@pytest.mark.parametrize("seed", range(4))
def test_a_cluster_is_told_by_the_moments_of_its_particles(seed: int) -> None:
    """Five heaps some metres apart, of uneven weights, one around the heading of half a turn."""
    rng = np.random.default_rng(seed)
    middles = np.array([(0, 0, 3.1), (4, 0, 1), (-40, 3, -1), (3, -30, 0), (-5, -5, 2)], np.float64)
    heap = np.repeat(np.arange(5), 200)
    rng.shuffle(heap)
    root = rng.normal(0.0, 0.03, (3, 3))
    off = np.clip(rng.normal(size=(1000, 3)), -2.0, 2.0) @ root.T
    particles = np.asfortranarray(middles[heap] + off)
    particles[:, 2] = np.remainder(particles[:, 2] + math.pi, math.tau) - math.pi
    weights = rng.random(1000) * np.array([5.0, 1.0, 3.0, 0.02, 2.0])[heap]
    weights /= weights.sum()
    shares = np.bincount(heap, weights)
    found, rank = find_clusters(particles, weights, 0.02, 10)
    order = [k for k in np.argsort(-shares).tolist() if shares[k] >= 0.02]
    assert len(found) == 4
    for place, (k, cluster) in enumerate(zip(order, found, strict=True)):
        assert (rank[heap == k] == place).all()
        assert cluster.share == pytest.approx(shares[k])
        mean = middles[k] + np.average(off[heap == k], axis=0, weights=weights[heap == k])
        assert cluster.mean[:2] == pytest.approx(mean[:2])
        assert math.remainder(cluster.mean[2] - mean[2], math.tau) == pytest.approx(0.0, abs=1e-9)
        assert abs(cluster.mean[2]) <= math.pi
        expected = np.cov(off[heap == k].T, aweights=weights[heap == k], ddof=0)
        np.testing.assert_allclose(cluster.covariance, expected, atol=1e-9)
    assert (rank[~np.isin(heap, order)] == 4).all()
    two, rank = find_clusters(particles, weights, 0.02, 2)
    assert [one.share for one in two] == [one.share for one in found[:2]]
    assert (rank[~np.isin(heap, order[:2])] == 2).all()
    one, _ = find_clusters(particles, weights, 0.99, 10)
    assert len(one) == 1  # the heaviest is told whatever its weight


def test_bins_touch_at_sides_and_corners_of_place_and_heading() -> None:
    for first in (0, 1, 17, 35):
        for x, y, turn in itertools.product(range(-2, 3), repeat=3):
            bins = np.array([[5, 5, first], [5 + x, 5 + y, (first + turn) % 36], [90, 0, 0]])
            touch = max(abs(x), abs(y), abs(turn)) <= 1
            labels = connect(bins, np.array([0.3, 0.3, 0.4]))
            assert (labels[0] == labels[1]) == touch
            assert labels[2] == 0  # the heaviest is the first
