"""Claims: a closure is not surer than the little that tells it from its neighbours."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_slam.graph.loops import doubted


@pytest.mark.parametrize("angle", [0.0, 0.7, -1.2])
@pytest.mark.parametrize(("along", "claimed"), [(0.02, 0.02), (0.04, 0.1), (0.1, 1.5)])
def test_what_is_hardly_seen_is_doubted_along_its_direction_alone(
    angle: float, along: float, claimed: float
) -> None:
    turn = SE2(0.0, 0.0, angle).matrix()
    covariance = turn @ np.diag([along**2, 0.008**2, 0.004**2]) @ turn.T
    result = turn.T @ doubted(covariance) @ turn
    assert math.sqrt(result[0, 0]) == pytest.approx(claimed, rel=0.6)
    assert math.sqrt(result[0, 0]) >= along
    np.testing.assert_allclose(result[1:, 1:], np.diag([0.008**2, 0.004**2]), atol=1e-12)
