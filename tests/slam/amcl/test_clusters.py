"""Which poses belong to a cluster of particles."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_slam.amcl.particles.clusters import Cluster

SPREAD = Cluster(1.0, np.array([1.0, 2.0, 3.1]), np.diag([0.1**2, 0.2**2, 0.3**2]))


@pytest.mark.parametrize(
    ("axis", "reach"), [(0, 0.3 + 0.05), (1, 0.6 + 0.05), (2, 0.9 + 0.05)], ids=["x", "y", "theta"]
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_cluster_holds_what_lies_within_three_deviations(
    axis: int, reach: float, sign: float
) -> None:
    for part, held in ((0.97, True), (1.03, False)):
        pose = SPREAD.mean.copy()
        pose[axis] += sign * part * reach
        pose[2] = math.remainder(pose[2], math.tau)  # the same heading, however it is written
        assert SPREAD.holds(pose) is held
