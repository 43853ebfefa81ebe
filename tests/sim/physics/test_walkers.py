"""Walkers: many actors at once are where each would be alone; whom they meet."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.model.entities import Entity
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.world import Trajectory, person
from arjuna_sim.physics.walkers import Walkers
from tests.sim.builders import run, simulator


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
        sim.drive()
        leans = max(leans, *map(abs, (sim.robot.truth().roll, sim.robot.truth().pitch)))
    assert math.hypot(sim.robot.truth().pose.x, sim.robot.truth().pose.y) > 0.1
    assert leans < math.radians(30.0)


@pytest.mark.parametrize(("turn", "towards"), [(2.2, 60.0), (0.4, 90.0), (-2.0, 120.0)])
def test_who_walks_at_a_wall_steps_over_the_robot_between_which_drives_away_after(
    turn: float, towards: float
) -> None:
    sim = simulator(spawn=SE2(0.0, 0.0, turn))
    wall = (Part(Shape(Kind.BOX, (3.2, 0.2, 1.0)), Pose3((0.0, 0.0, 0.5))),)
    sim.stage.spawn(Entity("wall", wall, start=Pose3((0.8, 0.5, 0.0)), spawned=True))
    ahead = np.array([math.cos(math.radians(towards)), math.sin(math.radians(towards))])
    way = Trajectory.along(np.array([-1.0 * ahead, 1.5 * ahead]), 1.2, loop=False)
    sim.stage.spawn(Entity("walker", person(), trajectory=way, spawned=True))
    run(sim, 6.0)
    assert sim.stage.motion("walker").pose.position[:2] == pytest.approx(1.5 * ahead)
    moved = []
    for v in (0.2, -0.2):
        before = sim.robot.truth().pose
        run(sim, 1.5, Velocity(v))
        moved.append(sim.robot.truth().pose.distance(before))
    assert max(moved) > 0.15


def test_who_was_stopped_and_let_go_presses_as_before() -> None:
    sim = simulator()
    way = Trajectory.along(np.array([[1.0, 0.0], [-4.0, 0.0]]), 1.2, loop=False)
    sim.stage.spawn(Entity("walker", person(), trajectory=way, spawned=True))
    usual = sim.stage.scene.model.geom_solref.copy()
    run(sim, 9.0)
    assert sim.stage.motion("walker").pose.position[0] == -4.0
    assert (sim.stage.scene.model.geom_solref == usual).all()


def test_what_pressed_before_a_reset_is_forgotten() -> None:
    sim = simulator()
    wall = (Part(Shape(Kind.BOX, (0.2, 3.2, 1.0)), Pose3((0.0, 0.0, 0.5))),)
    sim.stage.spawn(Entity("wall", wall, start=Pose3((-0.6, 0.0, 0.0)), spawned=True))
    way = Trajectory.along(np.array([[0.6, 0.0], [-2.0, 0.0]]), 1.2, loop=False)
    sim.stage.spawn(Entity("walker", person(), trajectory=way, spawned=True))
    ends = []
    for _ in range(2):  # the first ends while the walker presses the robot against the wall
        sim.stage.rewind()
        sim.robot.set_pose(SE2())
        run(sim, 1.0)
        ends.append((sim.stage.motion("walker").pose, sim.robot.truth().pose))
    assert ends[0] == ends[1]
