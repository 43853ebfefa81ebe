"""Clusters of poses and the estimate."""

from __future__ import annotations

import itertools
import math
import re

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.grid import FREE, OCCUPIED, GridFrame, OccupancyGrid
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.amcl.clusters import Cluster, bin_centres, connect, find_clusters, to_bins
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.estimate import (
    Hypothesis,
    LocalizationError,
    Status,
    Track,
    check_finite,
    check_inside,
    check_map,
    covariance_root,
)

TURNED = GridFrame(0.5, 4, 3, SE2(1.0, 2.0, math.pi / 2))  # x from -0.5 to 1 m, y from 2 to 4 m


@pytest.mark.parametrize("resolution", [0.0, -0.05, math.inf, math.nan])
def test_cells_of_no_size_make_no_map(resolution: float) -> None:
    data = np.array([[FREE, OCCUPIED]], np.int8)
    check_map(OccupancyGrid(GridFrame(0.05, 2, 1), data, 0.0))
    with pytest.raises(LocalizationError, match="resolution must be positive, got"):
        check_map(OccupancyGrid(GridFrame(resolution, 2, 1), data, 0.0))


@pytest.mark.parametrize("pose", [SE2(math.nan), SE2(0.0, math.inf), SE2(0.0, 0.0, -math.inf)])
def test_a_pose_that_is_not_finite_is_named(pose: SE2) -> None:
    check_finite(SE2(1e9, -1e9, 99.0), "the pose")
    with pytest.raises(LocalizationError, match=r"^the odometry must be finite, got SE2"):
        check_finite(pose, "the odometry")


@pytest.mark.parametrize(
    ("x", "y", "inside"),
    [
        (-0.49, 2.01, True),
        (0.99, 3.99, True),
        (-0.51, 3.0, False),
        (1.01, 3.0, False),
        (0.0, 1.99, False),
        (0.0, 4.01, False),
    ],
)
def test_a_pose_off_the_map_is_refused_with_its_extent(x: float, y: float, inside: bool) -> None:
    if inside:
        check_inside(SE2(x, y), TURNED)
        return
    spans = rf"pose \({x:.2f}, {y:.2f}\) m .* x -0\.50 to 1\.00 m, y 2\.00 to 4\.00 m$"
    with pytest.raises(LocalizationError, match=spans):
        check_inside(SE2(x, y), TURNED)


@pytest.mark.parametrize("seed", range(3))
def test_the_root_times_itself_is_the_covariance(seed: int) -> None:
    part = np.random.default_rng(seed).normal(size=(3, 3 - seed))  # of full rank and of less
    covariance = np.asarray(part @ part.T, np.float64)
    root = covariance_root(covariance)
    np.testing.assert_allclose(root @ root.T, covariance, atol=1e-12)
    hardly = covariance + np.diag([0.0, 0.0, -1e-10])
    assert np.isfinite(covariance_root(hardly)).all()


@pytest.mark.parametrize(
    ("covariance", "problem"),
    [
        (np.eye(2), r"must be a finite \(3, 3\) matrix"),
        (np.full((3, 3), np.nan), r"must be a finite \(3, 3\) matrix"),
        (np.eye(3) + 0.1 * np.eye(3, k=1), "must be symmetric"),
        (np.eye(3) + 1e-8 * np.eye(3, k=2), "must be symmetric"),
        (np.diag([1.0, -0.5, 1.0]), "its least eigenvalue is -0.5"),
        (np.diag([1.0, 1.0, -2e-9]), "its least eigenvalue is -2e-09"),
    ],
)
def test_what_is_no_covariance_is_refused(covariance: Floats, problem: str) -> None:
    with pytest.raises(LocalizationError, match=problem):
        covariance_root(covariance)


CONFIG = AmclConfig()  # lost below an agreement of 0.7, sure from a share of 0.75
KNOWN = np.diag([0.01, 0.02, 0.003])


def hypothesis(agreement: float | None, pose: SE2 = IDENTITY, share: float = 0.9) -> Hypothesis:
    return Hypothesis(pose, KNOWN, agreement, share)


@pytest.mark.parametrize(
    ("at", "due"),
    [
        (SE2(0.24, -0.24, 0.19), False),  # each coordinate by itself
        (SE2(0.26, 0.0, 0.0), True),
        (SE2(0.0, -0.26, 0.0), True),
        (SE2(0.0, 0.0, -0.21), True),
        (SE2(0.0, 0.0, 2.0 * math.pi - 0.19), False),
    ],
)
def test_an_update_is_due_when_the_robot_has_moved(at: SE2, due: bool) -> None:
    track, start = Track(), SE2(3.0, -2.0, 3.1)
    assert track.due(start, CONFIG)
    assert track.step(start) is None
    assert not track.due(start, CONFIG)
    moved = SE2(start.x + at.x, start.y + at.y, start.theta + at.theta)
    assert track.due(moved, CONFIG) is due
    step = track.step(moved)
    assert step is not None
    assert (start @ step).distance(moved) < 1e-12


@pytest.mark.parametrize(
    ("agreement", "share", "status", "reason"),
    [
        (None, 0.9, Status.BLIND, "hardly a beam shows what the map knows; odometry alone"),
        (0.69, 0.9, Status.LOST, "only 69% of the beams agree with the map"),
        (0.7, 0.74, Status.AMBIGUOUS, "70% .*, but other poses explain 26%"),
        (0.7, 0.75, Status.TRACKING, "^70% of the beams agree with the map$"),
    ],
)
def test_what_a_hypothesis_amounts_to(
    agreement: float | None, share: float, status: Status, reason: str
) -> None:
    odometry, pose = SE2(1.0, 2.0, 0.5), SE2(-3.0, 1.0, -2.0)
    estimate = Track().conclude(hypothesis(agreement, pose, share), odometry, CONFIG)
    assert estimate.status is status
    assert re.search(reason, estimate.reason)
    assert estimate.quality == pytest.approx((agreement or 0.0) * share)
    assert estimate.covariance is KNOWN
    assert estimate.T_map_base == pose
    assert (estimate.T_map_odom @ odometry).array() == pytest.approx(pose.array())


@pytest.mark.parametrize(
    ("off", "stays"),
    [
        (SE2(0.3, 0.39, 0.0), False),
        (SE2(0.3, -0.41, 0.0), True),
        (SE2(0.0, 0.0, 0.49), False),
        (SE2(0.0, 0.0, -0.51), True),
    ],
)
def test_who_is_lost_stays_where_odometry_leads_until_scans_agree(off: SE2, stays: bool) -> None:
    track, first, step = Track(), SE2(1.0, 2.0, 0.5), SE2(0.4, 0.1, 0.2)
    track.conclude(hypothesis(0.9, SE2(5.0, 5.0, 1.0)), first, CONFIG)
    led, odometry = SE2(5.0, 5.0, 1.0) @ step, first @ step
    there = hypothesis(0.3, led @ off)
    for _ in range(2):
        lost = track.conclude(there, odometry, CONFIG)
        assert lost.T_map_base.distance(led if stays else led @ off) < 1e-9
        assert (lost.T_map_odom @ odometry).distance(lost.T_map_base) < 1e-9
        assert lost.status is Status.LOST
        assert lost.quality == pytest.approx(0.27)
        assert track.best is not None
        assert track.best.T_map_base == lost.T_map_base
    found = track.conclude(hypothesis(0.9, led @ off), odometry, CONFIG)
    assert found.T_map_base == led @ off
    assert Track().conclude(there, odometry, CONFIG).T_map_base == led @ off  # it was nowhere


SPREAD = Cluster(1.0, np.array([1.0, 2.0, 3.1]), np.diag([0.1**2, 0.2**2, 0.3**2]))


@pytest.mark.parametrize(
    ("axis", "reach"), [(0, 0.3 + 0.05), (1, 0.6 + 0.05), (2, 0.9 + 0.05)], ids=["x", "y", "theta"]
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_cluster_spans_three_deviations(axis: int, reach: float, sign: float) -> None:
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
