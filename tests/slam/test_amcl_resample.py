"""Claims: resampling is proportional, of low variance, and as large as KLD sampling asks."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import chi2, norm

from arjuna_slam.amcl.estimate import find_clusters
from arjuna_slam.amcl.resample import (
    bin_codes,
    decode,
    encode,
    kld_count,
    kld_resample,
    low_variance_indices,
)


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
    codes = bin_codes(base)
    assert codes[0] == codes[1]
    assert len(set(codes.tolist())) == 3


def test_bin_codes_can_be_undone() -> None:
    x, y, heading = np.array([-4000, 0, 7]), np.array([3, -1, -9000]), np.array([0, 35, 17])
    for given, back in zip((x, y, heading), decode(encode(x, y, heading)), strict=True):
        np.testing.assert_array_equal(given, back)


def test_a_wide_belief_keeps_more_particles_than_a_narrow_one() -> None:
    rng = np.random.default_rng(1)
    limits = (0.05, 0.99, 100, 2000)
    weights = np.full(2000, 1 / 2000)
    narrow = rng.normal(0.0, 0.05, (2000, 3))
    wide = np.column_stack((rng.uniform(-5, 5, (2000, 2)), rng.uniform(-3, 3, 2000)))
    assert len(kld_resample(narrow, weights, limits, rng)) < 250
    assert len(kld_resample(wide, weights, limits, rng)) == 2000


def test_clusters_are_what_touches_with_headings_wrapped() -> None:
    rng = np.random.default_rng(2)
    first = rng.normal((1.0, 1.0, math.pi), (0.1, 0.1, 0.05), (300, 3))
    second = rng.normal((4.0, 1.0, 0.0), 0.05, (100, 3))
    particles = np.vstack((first, second))
    clusters = find_clusters(particles, np.full(400, 1 / 400), 0.02, 6)
    assert [round(cluster.share, 6) for cluster in clusters] == [0.75, 0.25]
    np.testing.assert_allclose(clusters[0].mean[:2], (1.0, 1.0), atol=0.03)
    assert abs(abs(clusters[0].mean[2]) - math.pi) < 0.02
    deviations = np.sqrt(np.diag(clusters[0].covariance))
    np.testing.assert_allclose(deviations, (0.1, 0.1, 0.05), rtol=0.15)
    np.testing.assert_array_equal(np.sort(clusters[1].members), np.arange(300, 400))
