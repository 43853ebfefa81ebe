"""Claims: scan matching finds the pose near by and anywhere; agreement tells right from wrong."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.estimate import LocalizationError
from arjuna_slam.amcl.recovery import LikelihoodAverages, LostDetector, MapMatcher, Recovery
from arjuna_slam.amcl.scan_view import ScanView
from arjuna_slam.matching.global_search import GlobalSearch
from arjuna_slam.matching.map_field import MapField
from tests.slam.amcl.room import error, random_pose, room_map, scan_at

CONFIG = AmclConfig()
MATCHER = MapMatcher(CONFIG, MapField(room_map(), CONFIG.laser_likelihood_max_dist))


@pytest.mark.parametrize("seed", range(10))
def test_refinement_returns_to_the_true_pose(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = random_pose(rng)
    view = ScanView.of(scan_at(truth, 0.0, rng), CONFIG)
    offset = rng.uniform((-0.2, -0.2, -0.1), (0.2, 0.2, 0.1))
    start = truth @ SE2.from_array(offset)
    found = MATCHER.refined(start, view)
    off, turned = error(found, truth)
    assert off < 0.03
    assert turned < math.radians(1.0)


def test_refinement_works_on_a_rotated_map() -> None:
    rng = np.random.default_rng(3)
    field = MapField(room_map(SE2(-0.9, -10.2, math.radians(40.0)), 290), 2.0)
    truth = random_pose(rng)
    start = truth @ SE2(0.15, -0.1, 0.05)
    view = ScanView.of(scan_at(truth, 0.0, rng), CONFIG)
    found = MapMatcher(CONFIG, field).refined(start, view)
    assert error(found, truth)[0] < 0.03


def test_refinement_without_anything_to_match_returns_the_given_pose() -> None:
    pose = SE2(50.0, 50.0, 0.3)
    view = ScanView.of(scan_at(SE2(), 0.0, np.random.default_rng(0)), CONFIG)
    np.testing.assert_allclose(MATCHER.refined(pose, view).array(), pose.array(), atol=1e-12)


@pytest.mark.parametrize("seed", range(10))
def test_agreement_is_high_at_the_truth_and_low_elsewhere(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth, other = random_pose(rng), random_pose(rng)
    view = ScanView.of(scan_at(truth, 0.0, rng), CONFIG)
    assert MATCHER.agreement(truth, view) > 0.95
    assert MATCHER.agreement(other, view) < 0.7


def test_a_beam_without_return_speaks_only_where_the_map_has_an_obstacle() -> None:
    rng = np.random.default_rng(1)
    scan = scan_at(SE2(), 0.0, rng)
    silent = replace(scan, ranges=np.where(np.arange(360) < 90, np.inf, scan.ranges))
    assert MATCHER.agreement(SE2(), ScanView.of(silent, CONFIG)) == pytest.approx(0.75, abs=0.02)
    short = replace(silent, range_max=3.0, ranges=np.where(scan.ranges < 3.0, scan.ranges, np.inf))
    assert MATCHER.agreement(SE2(), ScanView.of(short, CONFIG)) > 0.9


@pytest.mark.parametrize("origin", [SE2(-5.187, -5.213, 0.0), SE2(-0.9, -10.2, 0.7)])
def test_search_finds_the_pose_anywhere(origin: SE2) -> None:
    field = MapField(room_map(origin, 290), 2.0)
    recovery = Recovery(CONFIG, MapMatcher(CONFIG, field))
    for seed in range(8):
        rng = np.random.default_rng(seed)
        truth = random_pose(rng)
        scan = scan_at(truth, 0.0, rng)
        found = recovery.propose(ScanView.of(scan, CONFIG), [])
        off, turned = error(found[0].T_map_base, truth)
        assert off < 0.05
        assert turned < math.radians(1.5)
        assert (found[0].agreement or 0.0) > 0.95
        assert sum(hypothesis.share for hypothesis in found) == pytest.approx(1.0)


def test_search_looks_through_a_map_of_many_rooms_in_bounded_steps() -> None:
    grid = room_map(SE2(-40.0, -40.0, 0.0), 1600)
    field = MapField(grid, 2.0)
    rng = np.random.default_rng(4)
    truth = random_pose(rng)
    found = GlobalSearch(field).find(scan_at(truth, 0.0, rng).points(), 10)
    errors = [error(SE2.from_array(pose), truth) for pose in found]
    assert min(errors)[0] < 0.15


def test_lost_is_called_after_patience_then_ever_more_rarely() -> None:
    detector = LostDetector(0.7, 1.0, 8.0)
    calls = []
    for tick in range(200):
        if detector.observe(0.3, 0.1 * tick):
            calls.append(tick)
            detector.searched(0.1 * tick)
    assert calls == [10, 30, 70, 150]
    assert not detector.observe(0.9, 20.0)
    assert not detector.observe(0.3, 20.1)
    assert detector.observe(0.3, 21.2)


def test_lost_detector_survives_a_clock_set_back() -> None:
    detector = LostDetector(0.7, 1.0, 8.0)
    assert not detector.observe(0.3, 100.0)
    assert not detector.observe(0.3, 5.0)
    assert detector.observe(0.3, 6.0)


def test_injection_follows_the_ratio_of_the_averages() -> None:
    averages = LikelihoodAverages(0.001, 0.1)
    for _ in range(50):
        averages.add(8.0)
    assert averages.injection == 0.0
    averages.add(2.0)
    assert averages.injection == pytest.approx(1.0 - (8.0 - 0.6) / (8.0 - 0.006))
    averages.reset()
    assert averages.injection == 0.0


def test_uniform_samples_lie_in_free_cells() -> None:
    grid = room_map(SE2(-0.9, -10.2, 0.7), 290)
    field = MapField(grid, 2.0)
    samples = field.sample_free(2000, np.random.default_rng(0))
    cells = grid.frame.to_cells(samples[:, :2])
    assert (grid.data[cells[:, 0], cells[:, 1]] == 0).all()
    assert np.abs(samples[:, 2]).max() <= math.pi


def test_errors_are_arjunas() -> None:
    assert issubclass(LocalizationError, ValueError)
