"""Walkers: manners of one and steps of many."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.model.entities import Entity
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.world import Actor, Trajectory, person
from arjuna_sim.physics.ground import Ground
from arjuna_sim.physics.walkers import Manners, Walkers
from arjuna_sim.simulation import Simulation, solo
from tests.sim.builders import run, simulator
from tests.sim.generated import Chassis
from tests.sim.start_cases import start_case


def test_walkers_walk_together_as_one_by_one() -> None:
    rng = np.random.default_rng(3)
    paths = [
        Trajectory.along(rng.uniform(-5.0, 5.0, (count, 2)), speed, loop)
        for count, speed, loop in ((2, 0.5, True), (7, 1.2, False), (4, 2.0, True))
    ]
    paths.append(dataclasses.replace(paths[0], delay=1.5))
    data = SimpleNamespace(mocap_pos=np.zeros((4, 3)), mocap_quat=np.zeros((4, 4)))
    plane = simulator().stage
    walkers = Walkers([2, 0, 3, 1], paths, Ground(plane.scene.model, plane.data))
    for elapsed in (0.0, 0.7, 3.3, 9.9, 41.0):
        walkers.put(data, np.full(4, elapsed))
        for body, path in zip((2, 0, 3, 1), paths, strict=True):
            one = Pose3.from_se2(path.pose(elapsed))
            assert data.mocap_pos[body] == pytest.approx(one.position, abs=1e-12)
            assert abs(data.mocap_quat[body] @ one.quaternion) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("number", [4, 5, 6])  # terrain, a hill, a raised floor
def test_people_stand_and_walk_on_the_ground(number: int) -> None:
    case = start_case(number)
    walks = Trajectory.along(np.array([[-5.5, -5.5], [5.5, -5.6], [5.5, 5.5]]), 1.2, loop=False)
    people = (
        Actor("walks", person(), SE2(), walks),
        Actor("stands", person(), SE2(-5.6, 5.6, 1.0), None),
    )
    world = dataclasses.replace(case.world, actors=people)
    starts = solo(Chassis().robot(), SE2(7.0, 7.0))
    stage = Simulation(starts, world, SimulatorConfig(), np.random.default_rng(0)).stage
    for _ in range(60):  # it has arrived by the 46th
        for name in ("walks", "stands"):
            x, y, z = stage.motion(name).pose.position
            assert z == pytest.approx(case.ground(x, y), abs=0.02)
        stage.advance(100)


@pytest.mark.parametrize(
    ("turn", "beside", "speed"),
    [(0.0, 0.2, 0.8), (60.0, 0.1, 1.2), (135.0, 0.0, 0.8), (180.0, 0.2, 1.2)],
)
def test_walkers_push_a_robot_aside(turn: float, beside: float, speed: float) -> None:
    sim = simulator(spawn=SE2(0.0, 0.0, math.radians(turn)))
    direction = Trajectory.along(np.array([[1.0, beside], [-2.0, beside]]), speed)
    sim.stage.spawn(Entity("walker", person(), trajectory=direction, spawned=True))
    leans = 0.0
    for _ in range(round(2.5 / speed / sim.config.tick)):
        sim.drive()
        leans = max(leans, *map(abs, (sim.robot.truth().roll, sim.robot.truth().pitch)))
    assert math.hypot(sim.robot.truth().pose.x, sim.robot.truth().pose.y) > 0.1
    assert leans < math.radians(30.0)


@pytest.mark.parametrize(("turn", "towards"), [(2.2, 60.0), (0.4, 90.0), (-2.0, 120.0)])
def test_a_walker_at_a_wall_steps_over_the_robot(turn: float, towards: float) -> None:
    sim = simulator(spawn=SE2(0.0, 0.0, turn))
    wall = (Part(Shape(Kind.BOX, (3.2, 0.2, 1.0)), Pose3((0.0, 0.0, 0.5))),)
    sim.stage.spawn(Entity("wall", wall, start=Pose3((0.8, 0.5, 0.0)), spawned=True))
    ahead = np.array([math.cos(math.radians(towards)), math.sin(math.radians(towards))])
    direction = Trajectory.along(np.array([-1.0 * ahead, 1.5 * ahead]), 1.2, loop=False)
    sim.stage.spawn(Entity("walker", person(), trajectory=direction, spawned=True))
    run(sim, 6.0)
    assert sim.stage.motion("walker").pose.position[:2] == pytest.approx(1.5 * ahead)
    moved = []
    for v in (0.2, -0.2):
        before = sim.robot.truth().pose
        run(sim, 1.5, Velocity(v))
        moved.append(sim.robot.truth().pose.distance(before))
    assert max(moved) > 0.15


def test_a_person_stopped_and_released_presses_as_before() -> None:
    sim = simulator()
    direction = Trajectory.along(np.array([[1.0, 0.0], [-4.0, 0.0]]), 1.2, loop=False)
    sim.stage.spawn(Entity("walker", person(), trajectory=direction, spawned=True))
    usual = sim.stage.scene.model.geom_solref.copy()
    run(sim, 9.0)
    assert sim.stage.motion("walker").pose.position[0] == -4.0
    assert (sim.stage.scene.model.geom_solref == usual).all()


def test_what_pressed_before_a_reset_is_forgotten() -> None:
    sim = simulator()
    wall = (Part(Shape(Kind.BOX, (0.2, 3.2, 1.0)), Pose3((0.0, 0.0, 0.5))),)
    sim.stage.spawn(Entity("wall", wall, start=Pose3((-0.6, 0.0, 0.0)), spawned=True))
    direction = Trajectory.along(np.array([[0.6, 0.0], [-2.0, 0.0]]), 1.2, loop=False)
    sim.stage.spawn(Entity("walker", person(), trajectory=direction, spawned=True))
    ends = []
    for _ in range(2):  # the first ends while the walker presses the robot against the wall
        sim.stage.rewind()
        sim.robot.set_pose(SE2())
        run(sim, 1.0)
        ends.append((sim.stage.motion("walker").pose, sim.robot.truth().pose))
    assert ends[0] == ends[1]


STEP = 0.004


class Scales:
    """Boxes that lie on walkers, pressing as gravity says.

    Args:
        gravity: Of each box's weight [m/s^2].
        masses: Of the box on each walker [kg].
    """

    def __init__(self, gravity: float, masses: tuple[float, ...] = (2.0,)) -> None:
        bodies = "".join(
            f"<body mocap='true' pos='{3 * i} 0 0'>"
            "<geom type='box' size='1 1 0.5' mass='0'/></body>"
            f"<body pos='{3 * i} 0 0.75'><freejoint/><geom type='box' size='.25 .25 .25'"
            f" mass='{mass}'/></body>"
            for i, mass in enumerate(masses)
        )
        text = (
            f"<option timestep='{STEP}' gravity='0 0 {-gravity}'/><worldbody>{bodies}</worldbody>"
        )
        self.model = mujoco.MjModel.from_xml_string(f"<mujoco>{text}</mujoco>")
        self.data = mujoco.MjData(self.model)
        self.manners = Manners(self.model, list(range(len(masses))), STEP)
        self.usual = self.model.geom_solref.copy()

    def settle(self) -> None:
        """Let the boxes come to rest."""
        for _ in range(200):
            mujoco.mj_step(self.model, self.data)

    def stopped(self) -> list[int]:
        """Step once, and return who stops."""
        mujoco.mj_step(self.model, self.data)
        return list(map(int, self.manners.stopped(self.data)))

    def until(self, stop: bool) -> int:
        """Step until somebody stops, or continues; return how many steps it took."""
        for count in range(1000):
            if bool(self.stopped()) is stop:
                return count
        raise AssertionError("nothing has changed")

    def lift(self, box: int) -> None:
        """Take a box off its walker."""
        self.data.qpos[7 * box + 2] += 5000.0


@pytest.mark.parametrize("mass", [0.5, 2.0, 80.0])
def test_a_push_is_by_the_mass_of_what_is_pushed_averaged_over_a_twentieth(mass: float) -> None:
    scales = Scales(60.0, (mass,))
    scales.settle()
    share = STEP / 0.05
    # 60 (1 - (1 - share)^n) > 50
    first = math.ceil(math.log(1.0 - 50.0 / 60.0) / math.log(1.0 - share))
    found = [scales.stopped() for _ in range(first + 1)]
    assert found[: first - 1] == [[]] * (first - 1)
    assert found[first:] == [[0]]


def test_what_tyres_hold_stops_nobody() -> None:
    scales = Scales(49.0)
    scales.settle()
    assert all(scales.stopped() == [] for _ in range(300))


def test_who_waited_two_seconds_presses_lightly_until_nothing_is_there() -> None:
    scales = Scales(60.0)
    scales.settle()
    scales.until(True)
    assert scales.until(False) == round(2.0 / STEP) - 2
    own = np.flatnonzero(scales.model.geom_bodyid == 1)
    others = np.flatnonzero(scales.model.geom_bodyid != 1)
    assert (scales.model.geom_solref[own, 0] == 1.0).all()
    assert (scales.model.geom_solref[others] == scales.usual[others]).all()
    assert (scales.model.geom_solref[own, 1] == scales.usual[own, 1]).all()
    assert all(scales.stopped() == [] for _ in range(20))
    scales.lift(0)
    assert scales.stopped() == []
    assert (scales.model.geom_solref == scales.usual).all()


def test_a_released_person_has_forgotten() -> None:
    scales = Scales(60.0)
    scales.settle()
    scales.until(True)
    scales.lift(0)
    assert scales.stopped() == []
    scales.lift(0)
    for _ in range(3):
        assert scales.stopped() == []


def test_walkers_are_judged_each_alone() -> None:
    """Of three one meets nothing, one what it must not push, one becomes free meanwhile."""
    scales = Scales(60.0, (1.0, 5.0, 2.0))
    scales.lift(0)
    scales.settle()
    scales.lift(0)
    scales.until(True)
    assert scales.stopped() == [1, 2]
    scales.lift(2)
    assert scales.stopped() == [1]
    usual = scales.usual[:, 0]
    scales.until(False)
    changed = np.flatnonzero(scales.model.geom_solref[:, 0] != usual)
    assert scales.model.geom_bodyid[changed].tolist() == [3]


def test_what_is_heavier_counts_where_two_things_are_one() -> None:
    """A pushed link weighs with all that is attached to it."""
    text = f"""<mujoco><option timestep='{STEP}' gravity='0 0 -60'/><worldbody>
    <body mocap='true'><geom type='box' size='1 1 0.5' mass='0'/></body>
    <body pos='0 0 0.75'><freejoint/><geom type='box' size='.25 .25 .25' mass='1'/>
    <body pos='0 0 0.4'><geom type='box' size='.1 .1 .1' mass='9'/></body></body>
    </worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    for _ in range(200):
        mujoco.mj_step(model, data)
    manners = Manners(model, [0], STEP)
    found = []
    for _ in range(40):
        mujoco.mj_step(model, data)
        found.append(len(manners.stopped(data)))
    assert 19 <= found.index(1) <= 23  # 21, as of a single body of 10 kg
