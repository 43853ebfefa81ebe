"""Claims: the belief resamples when it should, and chance decides nothing among poses that tie."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_slam.amcl.belief import (
    Belief,
    effective_count,
    kld_count,
    kld_indices,
    low_variance_indices,
)
from arjuna_slam.amcl.clusters import find_clusters, to_bins
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.estimate import Hypothesis
from arjuna_slam.amcl.recovery import SEED_COVARIANCE
from arjuna_slam.matching.map_field import MapField
from tests.slam.amcl.room import room_map

FIELD = MapField(room_map(), 2.0)
TIED = [
    Hypothesis(SE2(*pose), SEED_COVARIANCE, 1.0, share)
    for pose, share in zip(
        ((2.0, 2.0, 0.0), (-2.0, 2.0, 1.5), (-2.0, -3.5, 3.0)), (0.5, 0.3, 0.2), strict=True
    )
]


def belief(config: AmclConfig = AmclConfig(), seed: int = 0) -> Belief:  # noqa: B008
    return Belief(config, FIELD, np.random.default_rng(seed))


def test_selective_resampling_waits_until_few_particles_carry_the_weight() -> None:
    some = belief(AmclConfig(selective_resampling=True))
    some.spread(SE2(), 0.1 * np.eye(3))
    before = some.particles.copy()
    some.reweigh(np.linspace(1.0, 1.5, 2000))
    some.resample(0.0)
    np.testing.assert_array_equal(some.particles, before)
    some.reweigh(np.where(np.arange(2000) < 400, 1.0, 1e-6))
    some.resample(0.0)
    assert len(some.particles) < 2000
    assert len(np.unique(some.particles, axis=0)) <= 400
    np.testing.assert_allclose(some.weights, 1.0 / len(some.particles))


def test_resampling_keeps_to_its_interval() -> None:
    some = belief(AmclConfig(resample_interval=3))
    some.spread(SE2(), 0.1 * np.eye(3))
    counts = []
    for _ in range(6):
        some.resample(0.0)
        counts.append(len(some.particles))
    assert counts == [2000, 2000, 500, 500, 500, 500]


def test_injected_particles_come_from_anywhere_free() -> None:
    some = belief()
    some.spread(SE2(), 0.01 * np.eye(3))
    assert some.resample(0.3)
    far = np.hypot(*some.particles[:, :2].T) > 0.5
    assert far.mean() == pytest.approx(0.3, abs=0.08)


@pytest.mark.parametrize("tied", [(True, True, True), (True, True, False)])
def test_a_scan_that_fits_alike_leaves_the_shares(tied: tuple[bool, bool, bool]) -> None:
    some = belief()
    some.seed(TIED, SEED_COVARIANCE)
    clusters = some.clusters()
    assert [round(one.share, 2) for one in clusters] == [0.5, 0.3, 0.2]
    nearest = np.argmin(
        [np.hypot(*(some.particles - at.T_map_base.array())[:, :2].T) for at in TIED], axis=0
    )
    factors = np.array([1.0, 1.3, 1.3])[nearest]
    some.shift(np.ones(3), np.array(tied))
    some.reweigh(some.level(factors))
    shares = np.bincount(nearest, some.weights)
    assert shares[0] / shares[1] == pytest.approx(5.0 / 3.0, rel=0.01)
    if not tied[2]:
        assert shares[2] / shares[1] > 1.1 * 2.0 / 3.0


@pytest.mark.parametrize("gone", [(0,), (1, 2), (0, 1, 2)])
def test_weights_that_run_out_leave_a_belief(gone: tuple[int, ...]) -> None:
    """As at a pose that a scan rules out: 0 of 0 would make every weight NaN, for good."""
    some = belief()
    some.seed(TIED, SEED_COVARIANCE)
    some.clusters()
    some.shift(np.ones(3), np.ones(3, bool))
    nearest = np.argmin(
        [np.hypot(*(some.particles - at.T_map_base.array())[:, :2].T) for at in TIED], axis=0
    )
    factors = np.where(np.isin(nearest, gone), 0.0, 1.0)
    for _ in range(2):
        some.reweigh(some.level(factors))
        assert some.weights.sum() == pytest.approx(1.0)
    shares = np.bincount(nearest, some.weights)
    assert (shares[list(gone)] == 0.0).all() or len(gone) == 3


def test_shifting_clusters_changes_their_shares_by_the_factors() -> None:
    some = belief()
    some.seed(TIED, SEED_COVARIANCE)
    some.clusters()
    shares = some.shift(np.array([1.0, 0.5, 0.25]), np.zeros(3, bool))
    np.testing.assert_allclose(shares, np.array([0.5, 0.15, 0.05]) / 0.7, atol=0.002)
    assert some.weights.sum() == pytest.approx(1.0)


def test_downsampled_free_space_is_each_second_row_and_column() -> None:
    drawn = FIELD.sample_free(500, np.random.default_rng(0), step=2)
    cells = FIELD.frame.to_cells(drawn[:, :2])
    assert (cells % 2 == 0).all()
    assert FIELD.free[cells[:, 0], cells[:, 1]].all()


def test_clusters_are_six_at_most_and_none_of_little_weight() -> None:
    some = belief()
    poses = [
        Hypothesis(SE2(1.2 * k - 4.5, 2.0, 0.0), SEED_COVARIANCE, 1.0, share)
        for k, share in enumerate((0.2, 0.17, 0.16, 0.15, 0.14, 0.1, 0.07, 0.01))
    ]
    some.seed(poses, SEED_COVARIANCE)
    found = some.clusters()
    assert [round(one.mean[0] + 4.5, 1) for one in found] == [0.0, 1.2, 2.4, 3.6, 4.8, 6.0]
    some.seed([poses[0], poses[-1]], SEED_COVARIANCE)
    assert len(some.clusters()) == 2  # a twentieth of the weight
    some.seed([replace(poses[0], share=0.985), replace(poses[-1], share=0.015)], SEED_COVARIANCE)
    assert len(some.clusters()) == 1


def test_where_nothing_is_tied_or_injected_nothing_is_done() -> None:
    some = belief(AmclConfig(freespace_downsampling=True, resample_interval=2))
    some.scatter()
    cells = FIELD.frame.to_cells(some.particles[:, :2])
    assert (cells % 2 == 0).all()
    factors = np.linspace(1.0, 2.0, 2000)
    assert some.level(factors) is factors  # no clusters yet
    some.seed(TIED, SEED_COVARIANCE)
    some.clusters()
    some.shift(np.ones(3), np.array([True, False, False]))
    assert some.level(factors) is factors  # one is tied with no other
    assert [some.resample(0.0), some.resample(0.0)] == [False, False]
    assert some.resample(1.0) is False  # not due
    assert some.resample(1.0) is True
    some.spread(SE2(), 0.01 * np.eye(3))
    some.clusters()
    some.reweigh(np.linspace(1.0, 2.0, len(some.weights)))
    before = some.weights.copy()
    np.testing.assert_allclose(some.shift(np.array([0.5]), np.zeros(1, bool)), [1.0])
    np.testing.assert_array_equal(some.weights, before)


@pytest.mark.parametrize("bins", [3, 10, 100, 1000])
def test_kld_count_is_the_chi_square_quantile_over_twice_the_error(bins: int) -> None:
    from scipy.stats import chi2, norm  # half a second to import

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
