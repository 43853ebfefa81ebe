"""Claims: odometry's ways are learnt to be too short where scans see along them, nowhere else."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatchStatus
from arjuna_slam.matching.tracking import Stretch

_SEEN, _UNSEEN = np.diag([1e-4, 1e-4, 1e-6]), np.diag([1.0, 1e-4, 1e-6])
_PIECE = 6.0  # way matched against one reference [m]


def driven(
    told: float, true: float, *, way: float = 100.0, covariance: NDArray[np.float64] = _SEEN
) -> Stretch:
    """Return what is learnt of steps that odometry told and that were another length [m]."""
    stretch, rng = Stretch(), np.random.default_rng(1)
    reference, x = Field(0.05, 0.05), 0.0
    for _ in range(round(way / true)):
        x += true
        if x > _PIECE:
            reference, x = Field(0.05, 0.05), 0.0
        pose = SE2(x + rng.normal(0.0, 0.01), rng.normal(0.0, 0.01), 0.0)
        stretch.judge(reference, Match(MatchStatus.MATCHED, pose, covariance, 1.0), SE2(told))
    return stretch


@pytest.mark.parametrize(("told", "true"), [(1.0, 1.02), (1.0, 0.97), (0.05, 0.051), (1.0, 1.0)])
def test_the_length_of_a_metre_is_learnt(told: float, true: float) -> None:
    stretch = driven(told, true)
    assert stretch.factor == pytest.approx(true / told, abs=0.005)
    assert stretch.of(SE2(told, 0.0, 0.3)).x == pytest.approx(true, abs=0.01)
    assert stretch.of(SE2(told, 0.0, 0.3)).theta == 0.3


def test_a_way_along_which_nothing_is_seen_tells_nothing() -> None:
    assert driven(1.0, 1.02, covariance=_UNSEEN).factor == 1.0


def test_a_slip_does_not_spoil_what_was_learnt() -> None:
    stretch, reference = driven(1.0, 1.02), Field(0.05, 0.05)
    for pose, told in ((SE2(), 0.0), (SE2(0.2, 0.0, 0.0), 3.0)):
        match = Match(MatchStatus.MATCHED, pose, _SEEN, 1.0)
        stretch.judge(reference, match, SE2(told))
    assert stretch.factor == pytest.approx(1.02, abs=0.01)


def test_a_failed_match_measures_no_way() -> None:
    stretch, reference = Stretch(), Field(0.05, 0.05)
    for x, status in ((0.0, "matched"), (2.5, "low response"), (9.0, "matched")):
        match = Match(MatchStatus(status), SE2(x, 0.0, 0.0), _SEEN, 1.0)
        stretch.judge(reference, match, SE2(2.5))
    assert stretch.factor == 1.0
