"""Claims: the belief resamples when it should, and chance decides nothing among places that tie."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_slam.amcl.belief import Belief
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.estimate import Hypothesis
from arjuna_slam.amcl.recovery import SEED_COVARIANCE
from arjuna_slam.matching.map_field import MapField
from tests.slam.amcl.room import room_map

FIELD = MapField(room_map(), 2.0)
PLACES = [
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
def test_a_scan_that_fits_places_alike_leaves_their_shares_alone(
    tied: tuple[bool, bool, bool],
) -> None:
    some = belief()
    some.seed(PLACES, SEED_COVARIANCE)
    clusters = some.clusters()
    assert [round(one.share, 2) for one in clusters] == [0.5, 0.3, 0.2]
    place = np.argmin(
        [np.hypot(*(some.particles - at.T_map_base.array())[:, :2].T) for at in PLACES], axis=0
    )
    factors = np.array([1.0, 1.3, 1.3])[place]
    some.shift(np.ones(3), np.array(tied))
    some.reweigh(some.level(factors))
    shares = np.bincount(place, some.weights)
    assert shares[0] / shares[1] == pytest.approx(5.0 / 3.0, rel=0.01)
    if not tied[2]:
        assert shares[2] / shares[1] > 1.1 * 2.0 / 3.0


def test_shifting_clusters_changes_their_shares_by_the_factors() -> None:
    some = belief()
    some.seed(PLACES, SEED_COVARIANCE)
    some.clusters()
    shares = some.shift(np.array([1.0, 0.5, 0.25]), np.zeros(3, bool))
    np.testing.assert_allclose(shares, np.array([0.5, 0.15, 0.05]) / 0.7, atol=0.002)
    assert some.weights.sum() == pytest.approx(1.0)


def test_downsampled_free_space_is_each_second_row_and_column() -> None:
    drawn = FIELD.sample_free(500, np.random.default_rng(0), step=2)
    cells = FIELD.frame.to_cells(drawn[:, :2])
    assert (cells % 2 == 0).all()
    assert FIELD.free[cells[:, 0], cells[:, 1]].all()


def test_particles_are_spread_as_the_covariance_says() -> None:
    some, root = belief(), np.array([[0.3, 0.0, 0.0], [0.1, 0.2, 0.0], [0.02, -0.05, 0.1]])
    some.spread(SE2(1.0, -2.0, 0.5), root)
    np.testing.assert_allclose(some.particles.mean(axis=0), (1.0, -2.0, 0.5), atol=0.03)
    np.testing.assert_allclose(np.cov(some.particles.T), root @ root.T, atol=0.01)
    np.testing.assert_allclose(some.weights, 1.0 / 2000.0)


def test_six_places_are_told_at_most_and_none_of_little_weight() -> None:
    some = belief()
    places = [
        Hypothesis(SE2(1.2 * k - 4.5, 2.0, 0.0), SEED_COVARIANCE, 1.0, share)
        for k, share in enumerate((0.2, 0.17, 0.16, 0.15, 0.14, 0.1, 0.07, 0.01))
    ]
    some.seed(places, SEED_COVARIANCE)
    found = some.clusters()
    assert [round(one.mean[0] + 4.5, 1) for one in found] == [0.0, 1.2, 2.4, 3.6, 4.8, 6.0]
    some.seed([places[0], places[-1]], SEED_COVARIANCE)
    assert len(some.clusters()) == 2  # a twentieth of the weight
    some.seed([replace(places[0], share=0.985), replace(places[-1], share=0.015)], SEED_COVARIANCE)
    assert len(some.clusters()) == 1


def test_where_nothing_is_tied_or_injected_nothing_is_done() -> None:
    some = belief(AmclConfig(freespace_downsampling=True, resample_interval=2))
    some.scatter()
    cells = FIELD.frame.to_cells(some.particles[:, :2])
    assert (cells % 2 == 0).all()
    factors = np.linspace(1.0, 2.0, 2000)
    assert some.level(factors) is factors  # no clusters yet
    some.seed(PLACES, SEED_COVARIANCE)
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
