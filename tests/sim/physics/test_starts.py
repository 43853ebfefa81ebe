"""200 starts, asked for at random and two in five within things, are on the ground."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.simulation import Simulation, solo
from tests.sim.builders import ROBOT, run
from tests.sim.generated import Chassis, level
from tests.sim.start_cases import WORLDS, Ground, start_case

CHASSIS = (Chassis(), Chassis(axles=1), Chassis(mass=40.0, radius=0.1, axles=3))


@pytest.mark.parametrize("number", range(WORLDS))
def test_it_starts_on_the_ground_near_what_was_asked(number: int) -> None:
    case, rng = start_case(number), np.random.default_rng(number)
    robot = CHASSIS[number % 4 - 1].robot() if number % 4 else load_robot(ROBOT)
    flat = Simulation(solo(robot), level(), SimulatorConfig(), np.random.default_rng(0))
    run(flat, 1.0)
    for asked in case.asked(rng):
        sim = Simulation(solo(robot, asked), case.world, SimulatorConfig(), rng)
        spawn = sim.robot.spawn
        assert case.clearance(asked.x, asked.y) < 0.6 or spawn == asked
        assert (spawn != asked) is any("the robot starts at" in note for note in sim.notes)
        assert math.hypot(spawn.x - asked.x, spawn.y - asked.y) <= 3.01
        begun = sim.robot.truth()
        run(sim, 1.0)
        rests, slope = sim.robot.truth(), steepness(case.ground, spawn)
        at = rests.pose
        assert math.hypot(at.x - spawn.x, at.y - spawn.y) < 0.03
        assert abs(rests.z - begun.z) < 0.03
        height = case.ground(at.x, at.y) + flat.robot.truth().z
        assert rests.z == pytest.approx(height, abs=0.03 + 0.02 * slope)
        assert math.hypot(rests.roll, rests.pitch) < math.atan(slope) + 0.06


def steepness(ground: Ground, at: SE2) -> float:
    dx = ground(at.x + 0.1, at.y) - ground(at.x - 0.1, at.y)
    dy = ground(at.x, at.y + 0.1) - ground(at.x, at.y - 0.1)
    return math.hypot(dx, dy) / 0.2
