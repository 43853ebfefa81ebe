"""MPPI's commands against those of the published algorithm, written apart from ours in C."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.config import load
from arjuna_core.se2 import SE2
from arjuna_nav.controllers.mppi.config import MppiConfig
from arjuna_nav.controllers.mppi.controller import Mppi
from arjuna_nav.costmap.footprint import Footprint
from tests.helpers.nav import mppi_peer
from tests.nav.worlds import Unicycle, block, costmap_of, empty_grid


def test_commands_are_those_of_the_published_algorithm() -> None:
    library = mppi_peer.compiled()
    if library is None:
        pytest.skip("no C compiler")
    grid = empty_grid(5.0, 5.0)
    block(grid, 2.2, 1.7, 0.3, 0.3)
    costmap, along = costmap_of(grid), np.arange(0.5, 4.5, 0.0437)
    path = np.column_stack((along, np.full(len(along), 2.22), np.zeros(len(along))))
    off = []
    for seed in range(20):
        config = load(MppiConfig, {"batch_size": 200, "ax_max": 1.0, "ax_min": -1.0, "seed": seed})
        ours = Mppi(config, Footprint.circle(0.25), 0.2, 0.05)
        peer = mppi_peer.ArrayMppi(library, config)
        robot = Unicycle(SE2(0.5 + 0.15 * seed, 2.3, 0.6))
        for controller in (ours, peer):
            controller.set_path(path)
        for step in range(5):
            command = ours.compute(robot.pose, robot.velocity, costmap, 0.05 * step).velocity
            theirs = peer.compute(robot.pose, robot.velocity, costmap)
            assert theirs is not None
            off.append(max(abs(command.x - theirs.x), abs(command.yaw_rate - theirs.yaw_rate)))
            robot.drive(command)
        peer.close()
    # Where a rollout ends on the bound of a cell, rounding decides by which cell it is judged.
    assert np.quantile(off, 0.9) < 1e-5
    assert max(off) < 0.1
