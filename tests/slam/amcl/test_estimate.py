"""The inputs that the filter refuses, and the conclusions it draws."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.grid import FREE, OCCUPIED, GridFrame, OccupancyGrid
from arjuna_core.se2 import IDENTITY, SE2
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
def test_a_pose_off_the_map_is_refused_with_the_map_s_extent(
    x: float, y: float, inside: bool
) -> None:
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
        (None, 0.9, Status.BLIND, "hardly a beam returned; odometry alone"),
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
    assert not estimate.strayed


@pytest.mark.parametrize(
    ("off", "strays"),
    [
        (SE2(0.3, 0.39, 0.0), False),
        (SE2(0.3, -0.41, 0.0), True),
        (SE2(0.0, 0.0, 0.49), False),
        (SE2(0.0, 0.0, -0.51), True),
    ],
)
def test_who_is_lost_elsewhere_than_odometry_led_has_strayed(off: SE2, strays: bool) -> None:
    track, first, step = Track(), SE2(1.0, 2.0, 0.5), SE2(0.4, 0.1, 0.2)
    track.conclude(hypothesis(0.9, SE2(5.0, 5.0, 1.0)), first, CONFIG)
    led = SE2(5.0, 5.0, 1.0) @ step
    odometry = first @ step
    there = hypothesis(0.3, led @ off)
    assert track.conclude(there, odometry, CONFIG).strayed is strays
    assert track.conclude(there, odometry, CONFIG).strayed is strays  # until it is found
    assert track.best is there
    assert not track.conclude(hypothesis(0.9, led), odometry, CONFIG).strayed
    assert not track.conclude(hypothesis(0.9, led @ off), odometry, CONFIG).strayed
    assert not Track().conclude(there, odometry, CONFIG).strayed  # it was nowhere before
