"""Walkers: many actors at once are where each would be alone; whom they meet."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_sim.model.actors import Trajectory, person
from arjuna_sim.model.entities import Entity
from arjuna_sim.physics.walkers import Walkers
from tests.sim.builders import simulator


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


@pytest.mark.parametrize("speed", [0.8, 1.2])
@pytest.mark.parametrize(("turn", "beside"), [(0.0, 0.2), (60.0, 0.1), (135.0, 0.0), (180.0, 0.2)])
def test_who_walks_into_a_robot_pushes_it_aside_and_does_not_overturn_it(
    turn: float, beside: float, speed: float
) -> None:
    sim = simulator(spawn=SE2(0.0, 0.0, math.radians(turn)))
    way = Trajectory.along(np.array([[1.0, beside], [-2.0, beside]]), speed)
    sim.stage.spawn(Entity("walker", person(), trajectory=way, spawned=True))
    leans = 0.0
    for _ in range(round(2.5 / speed / sim.config.tick)):
        sim.step()
        leans = max(leans, *map(abs, (sim.truth().roll, sim.truth().pitch)))
    assert math.hypot(sim.truth().pose.x, sim.truth().pose.y) > 0.1
    assert leans < math.radians(30.0)
