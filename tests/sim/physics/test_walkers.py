"""Walkers: many actors at once are where each would be alone."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.actors import Trajectory
from arjuna_sim.physics.walkers import Walkers


def test_walkers_walk_together_as_one_by_one() -> None:
    rng = np.random.default_rng(3)
    paths = [
        Trajectory.along(rng.uniform(-5.0, 5.0, (count, 2)), speed, loop)
        for count, speed, loop in ((2, 0.5, True), (7, 1.2, False), (4, 2.0, True))
    ]
    paths.append(dataclasses.replace(paths[0], delay=1.5))
    data = SimpleNamespace(mocap_pos=np.zeros((4, 3)), mocap_quat=np.zeros((4, 4)))
    walkers = Walkers([2, 0, 3, 1], paths)
    for elapsed in (0.0, 0.7, 3.3, 9.9, 41.0):
        walkers.put(data, np.full(4, elapsed))
        for body, path in zip((2, 0, 3, 1), paths, strict=True):
            one = Pose3.from_se2(path.pose(elapsed))
            assert data.mocap_pos[body] == pytest.approx(one.position, abs=1e-12)
            assert abs(data.mocap_quat[body] @ one.quaternion) == pytest.approx(1.0, abs=1e-12)
