"""Robots are put on slopes as these lie."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.model.robot import SOLO
from arjuna_sim.physics.placing import Placer
from arjuna_sim.simulator import Simulator
from tests.sim.generated import Chassis, level, slope


def placer(degrees: float) -> Placer:
    world = slope(degrees) if degrees else level()
    sim = Simulator(Chassis().robot(), world, SimulatorConfig(), np.random.default_rng(0))
    return Placer(sim.stage, SOLO)


@pytest.mark.parametrize("degrees", [10.0, 25.0, 34.0])
@pytest.mark.parametrize("turn", [0.0, 1.0, math.pi / 2, math.pi])
def test_it_lies_on_a_slope_whichever_way_it_looks(degrees: float, turn: float) -> None:
    on = placer(degrees)
    root = on.place(SE2(0.2, -0.1, turn))
    up, flat = root.rotation()[:, 2], on.place(SE2(0.2, -0.1)).rotation()[:, 2]
    angle = math.radians(degrees)
    assert up == pytest.approx((-math.sin(angle), 0.0, math.cos(angle)), abs=2e-3)
    assert up == pytest.approx(flat, abs=2e-3)
    assert root.position[:2] == pytest.approx((0.2, -0.1))
    ride = placer(0.0).place(SE2()).position[2]
    above = root.position[2] - 0.2 * math.tan(angle)
    assert above == pytest.approx(ride / math.cos(angle), abs=2e-3)
