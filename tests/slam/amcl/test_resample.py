"""Claims: resampling is proportional, of low variance, and as large as KLD sampling asks."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import chi2, norm

from arjuna_slam.amcl.belief import effective_count, kld_count, kld_indices, low_variance_indices
from arjuna_slam.amcl.clusters import bin_centres, connect, find_clusters, to_bins


@pytest.mark.parametrize("bins", [3, 10, 100, 1000])
def test_kld_count_is_the_chi_square_quantile_over_twice_the_error(bins: int) -> None:
    quantile = float(chi2.ppf(norm.cdf(0.99), bins - 1))  # Fox 2003, eq. 5, which eq. 7 approaches
    assert kld_count(bins, 0.05, 0.99, 1, 10**9) == pytest.approx(quantile / 0.1, rel=0.02)


def test_kld_count_keeps_to_its_limits() -> None:
    assert kld_count(1, 0.05, 0.99, 500, 2000) == 500
    assert kld_count(2, 0.05, 0.99, 500, 2000) == 500
    assert kld_count(10_000, 0.05, 0.99, 500, 2000) == 2000


@pytest.mark.parametrize("seed", range(5))
def test_low_variance_draws_differ_from_proportion_by_less_than_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    weights = rng.random(50) ** 4
    counts = np.bincount(low_variance_indices(weights, 1000, rng), minlength=50)
    assert np.abs(counts - 1000 * weights / weights.sum()).max() < 1.0


def test_low_variance_draws_never_take_a_weight_of_zero() -> None:
    weights = np.array([0.0, 1.0, 0.0, 1.0, 0.0])
    for seed in range(20):
        drawn = low_variance_indices(weights, 64, np.random.default_rng(seed))
        assert set(drawn.tolist()) == {1, 3}


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


def test_bins_touch_across_the_wrap_of_headings_and_not_across_rows() -> None:
    bins = np.array([[0, 0, 0], [1, 1, 35], [3, 0, 0], [0, 9, 5], [1, -9, 5], [3, 1, 1]])
    labels = connect(bins, np.ones(6)).tolist()
    assert labels[0] == labels[1]
    assert labels[2] == labels[5]
    assert len(set(labels)) == 4


def test_modes_that_only_their_tails_join_stay_two() -> None:
    row = np.array([[x, 0, 0] for x in range(7)])
    labels = connect(row, np.array([2.0, 9.0, 2.0, 0.1, 2.0, 8.0, 2.0]))
    assert labels[1] == labels[0] == labels[2]
    assert labels[5] == labels[4] == labels[6]
    assert labels[1] != labels[5]
    assert len(set(connect(row, np.array([2.0, 9.0, 4.0, 3.0, 4.0, 8.0, 2.0])).tolist())) == 1


def test_a_wide_belief_keeps_more_particles_than_a_narrow_one() -> None:
    rng = np.random.default_rng(1)
    limits = (0.05, 0.99, 100, 2000)
    weights = np.full(2000, 1 / 2000)
    narrow = rng.normal(0.0, 0.05, (2000, 3))
    wide = np.column_stack((rng.uniform(-5, 5, (2000, 2)), rng.uniform(-3, 3, 2000)))
    assert len(kld_indices(weights, to_bins(narrow)[0], limits, rng)) < 250
    assert len(kld_indices(weights, to_bins(wide)[0], limits, rng)) == 2000


def test_the_effective_count_is_that_of_equal_weights() -> None:
    assert effective_count(np.full(40, 0.025)) == pytest.approx(40.0)
    assert effective_count(np.array([0.5, 0.0, 0.5, 0.0])) == pytest.approx(2.0)


def test_clusters_are_what_touches_with_headings_wrapped() -> None:
    rng = np.random.default_rng(2)
    first = rng.normal((1.0, 1.0, math.pi), (0.1, 0.1, 0.05), (300, 3))
    second = rng.normal((4.0, 1.0, 0.0), 0.05, (100, 3))
    particles = np.vstack((first, second))
    clusters, rank = find_clusters(particles, np.full(400, 1 / 400), 0.02, 6)
    assert [round(cluster.share, 6) for cluster in clusters] == [0.75, 0.25]
    np.testing.assert_allclose(clusters[0].mean[:2], (1.0, 1.0), atol=0.03)
    assert abs(abs(clusters[0].mean[2]) - math.pi) < 0.02
    deviations = np.sqrt(np.diag(clusters[0].covariance))
    np.testing.assert_allclose(deviations, (0.1, 0.1, 0.05), rtol=0.15)
    np.testing.assert_array_equal(rank, np.repeat((0, 1), (300, 100)))
