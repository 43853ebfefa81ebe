"""When a keyframe is due, and how far odometry may err."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_slam.config import SlamConfig


@pytest.mark.parametrize(
    ("delta", "due"),
    [
        (SE2(0.14, 0.14, 0.19), False),
        (SE2(0.15, -0.15, 0.0), True),
        (SE2(0.2, 0.0, 0.0), True),
        (SE2(0.0, 0.0, -0.21), True),
        (SE2(0.0, 0.0, 2.0 * math.pi - 0.1), False),
    ],
)
def test_a_keyframe_is_due_after_travel_or_a_turn(delta: SE2, due: bool) -> None:
    assert SlamConfig().keyframe_due(delta) is due


@pytest.mark.parametrize("odometry", [0.1, 0.2])
def test_odometry_errs_with_travel_and_turn(odometry: float) -> None:
    """Travel of 5 m and a turn of 2 rad: 0.01 m and 5.4 parts of a metre, 0.005 rad and 4.5."""
    known = SlamConfig(odometry_deviation=odometry).odometry_covariance(SE2(3.0, -4.0, -2.0))
    position, heading = 0.01 + 5.4 * odometry, 0.005 + 4.5 * odometry
    np.testing.assert_allclose(known, np.diag([position**2, position**2, heading**2]))
