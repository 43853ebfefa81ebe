"""Claims: odometry counts for what it has proven to be worth, where scans cannot tell better."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatcherConfig, MatchStatus, ScanMatcher
from arjuna_slam.matching.surface import Surface
from arjuna_slam.matching.tracking import Trust

_STEP = np.diag([100.0, 100.0, 400.0])  # 0.1 m, 0.05 rad
_SEEN, _UNSEEN = np.diag([1e-5, 1e-5, 1e-6]), np.diag([1e-5, 1.0, 1e-6])


def judged(trust: Trust, error: float, covariance: NDArray[np.float64], steps: int) -> float:
    """Return what a metre's step is worth after as many that were off [deviations^-2]."""
    match = Match(MatchStatus.MATCHED, SE2(error, 0.0, 0.0), covariance, 1.0)
    for _ in range(steps):
        trust.judge(SE2(), match, _STEP, 1.0)
    return float(trust.weigh(_STEP)[0, 0])


def test_good_odometry_comes_to_count_for_more_and_a_slip_takes_that_away() -> None:
    trust = Trust()
    assert judged(trust, 0.0, _SEEN, 1) < judged(trust, 0.0, _SEEN, 50) < 20.0 * _STEP[0, 0]
    assert judged(trust, 1.0, _SEEN, 1) < _STEP[0, 0]
    assert trust.weigh(_STEP)[2, 2] == _STEP[2, 2]


def test_a_match_that_does_not_see_all_judges_nothing() -> None:
    assert judged(Trust(), 0.0, _UNSEEN, 50) == _STEP[0, 0]


@pytest.mark.parametrize(("deviation", "held"), [(0.01, True), (0.1, False)])
def test_one_corner_does_not_outweigh_good_odometry(deviation: float, held: bool) -> None:
    """Two walls along x, and a few points of one across; the scan lies 0.05 m off along them."""
    x = np.arange(-4.0, 4.0, 0.05)
    walls = np.concatenate((np.column_stack((x, 0 * x + 1.0)), np.column_stack((x, 0 * x - 1.0))))
    across = np.column_stack((np.full(6, 3.0), np.linspace(0.7, 0.95, 6)))
    points = np.concatenate((walls, across))
    facing = np.column_stack((0.0 * walls[:, 0], -np.sign(walls[:, 1])))
    normals = np.concatenate((facing, np.tile([-1.0, 0.0], (6, 1))))
    field = Field(0.05, 0.05)
    field.add(points, normals)
    scan = Surface(points - [[0.05, 0.0]], normals, np.zeros(len(points), np.bool_))
    information = np.diag([deviation**-2, deviation**-2, 400.0])
    found = ScanMatcher(MatcherConfig()).track(field, scan, SE2(), information)
    assert found.status is MatchStatus.MATCHED
    assert (abs(found.T_field_base.x) < 0.02) is held
