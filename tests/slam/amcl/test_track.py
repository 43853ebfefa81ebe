"""When the particles are updated, what a hypothesis amounts to, and who has strayed."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.estimate import Hypothesis, Status, Track

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
        (0.7, 0.74, Status.AMBIGUOUS, "70% .*, but other places explain 26%"),
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
