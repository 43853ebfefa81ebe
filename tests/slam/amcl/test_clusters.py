"""The clusters of particles, and which poses belong to one."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from arjuna_slam.amcl.clusters import Cluster, bin_centres, connect, find_clusters, to_bins

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
def test_a_cluster_has_the_moments_of_its_particles(seed: int) -> None:
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
    for number, (k, cluster) in enumerate(zip(order, found, strict=True)):
        assert (rank[heap == k] == number).all()
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
    assert len(one) == 1  # the heaviest is kept whatever its weight


def test_bins_touch_at_sides_and_corners_of_position_and_heading() -> None:
    for first in (0, 1, 17, 35):
        for x, y, turn in itertools.product(range(-2, 3), repeat=3):
            bins = np.array([[5, 5, first], [5 + x, 5 + y, (first + turn) % 36], [90, 0, 0]])
            touch = max(abs(x), abs(y), abs(turn)) <= 1
            labels = connect(bins, np.array([0.3, 0.3, 0.4]))
            assert (labels[0] == labels[1]) == touch
            assert labels[2] == 0  # the heaviest is the first


def test_bins_are_half_a_metre_and_ten_degrees() -> None:
    base = np.array([[0.1, 0.1, 0.01], [0.4, 0.4, 0.16], [0.6, 0.1, 0.01], [0.1, 0.1, 0.18]])
    bin_of, bins = to_bins(base)
    assert bin_of.tolist() == [0, 0, 1, 2]
    assert bins.tolist() == [[0, 0, 18], [1, 0, 18], [0, 0, 19]]
    np.testing.assert_allclose(bin_centres(bins)[0], (0.25, 0.25, math.radians(5.0)))


@pytest.mark.parametrize("far", [0.0, 1e6])
def test_bins_are_the_same_whether_tabulated_or_sorted(far: float) -> None:
    rng = np.random.default_rng(6)
    spread = rng.uniform((-20.0, -9.0, -math.pi), (7.0, 30.0, math.pi), (3000, 3))
    particles = np.vstack((spread, [[far, -far, 0.0]]))  # far off: no table is large enough
    bin_of, bins = to_bins(np.asfortranarray(particles))
    expected = np.floor(particles[:, :2] / 0.5).astype(np.int64)
    np.testing.assert_array_equal(bins[bin_of][:, :2], expected)
    assert len({tuple(row) for row in bins.tolist()}) == len(bins)
    assert (np.abs(bin_centres(bins)[bin_of][:, 2] - particles[:, 2]) < math.radians(5.01)).all()


def test_modes_that_only_their_tails_join_stay_two() -> None:
    row = np.array([[x, 0, 0] for x in range(7)])
    labels = connect(row, np.array([2.0, 9.0, 2.0, 0.1, 2.0, 8.0, 2.0]))
    assert labels[1] == labels[0] == labels[2]
    assert labels[5] == labels[4] == labels[6]
    assert labels[1] != labels[5]
    assert len(set(connect(row, np.array([2.0, 9.0, 4.0, 3.0, 4.0, 8.0, 2.0])).tolist())) == 1
