"""Robots in a batch drive as one does."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("warp", reason="the extra 'gpu' is not installed")

from arjuna_core.errors import ConfigError, RobotError, WorldError
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.batch.batch import Batch, Variation
from arjuna_sim.batch.drive import BatchDrive
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.driving.bases import WheelSpeeds, base_of
from arjuna_sim.devices.driving.controller import CommandError, Drive, limited
from arjuna_sim.devices.odometry import Odometry, OdometryConfig
from arjuna_sim.devices.sensors.lidar import LidarConfig, LidarSettings
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.world_file import load_world
from arjuna_sim.simulation import Simulation, solo
from tests.bench.batch import agreement
from tests.sim.builders import EMPTY, ROBOT, ROOM, ROOT, first, saved_world
from tests.sim.drive_cases import mecanum
from tests.sim.world_cases import write_stl

# One process for all: each would compile Warp's kernels, for up to a minute, where none has yet.
pytestmark = pytest.mark.xdist_group("batch")
QUIET = SimulatorConfig(lidar=LidarConfig(noise=0.0))
STARTS = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.5], [1.0, -1.0, 2.0]])
AHEAD = np.array([0.4, 0.0, 0.3])


@pytest.fixture(scope="module")
def batch() -> Batch:
    """Make three robots in the room, of different masses, on different floors."""
    varied = Variation(friction=(0.4, 0.9), mass=(0.8, 1.5))
    return Batch(load_robot(ROBOT), load_world(ROOM), STARTS, variation=varied, seed=5)


def drive(batch: Batch, ticks: int) -> list[bytes]:
    """Return all that the same commands bring from the start."""
    batch.put(STARTS)
    states = [batch.step(np.tile(AHEAD, (3, 1))) for _ in range(ticks)]
    return [field.tobytes() for state in states for field in state]


def test_the_shipped_robot_moves_and_sees_as_in_the_simulation() -> None:
    found = agreement(load_robot(ROBOT), load_world(ROOM), 3.0, SE2(0.0, 0.0, 0.0))
    assert found.position < 0.001
    assert found.heading < math.radians(0.05)
    assert found.beams >= 0.99
    assert found.beams_there >= 0.999
    assert found.touched == 0


def test_a_robot_that_runs_into_a_box_touches_it_when_the_simulations_does() -> None:
    start = SE2(1.7, 0.0, 0.0)  # the red box begins at 2.25 m
    world = load_world(ROOM)
    sim = Simulation(solo(load_robot(ROBOT), start), world, QUIET, np.random.default_rng(0))
    batch = Batch(load_robot(ROBOT), world, start.array()[None])
    ahead, touches = np.array([[0.5, 0.0, 0.0]]), []
    for _ in range(100):
        seen, state = sim.drive(Velocity(0.5)), batch.step(ahead)
        touches.append((bool(seen.contacts), bool(state.touched[0])))
        assert not state.lost.any()
    simulated, found = np.array(touches).argmax(axis=0).tolist()
    assert simulated > 10
    assert abs(found - simulated) <= 1
    np.testing.assert_allclose(state.poses[0], seen.truth.pose.array(), atol=0.02)


def test_a_robot_that_is_lost_is_marked_until_it_is_put_down_again(batch: Batch) -> None:
    drive(batch, 0)
    nowhere = STARTS.copy()
    nowhere[1, 0] = np.inf
    batch.put(nowhere)
    assert batch.step(np.tile(AHEAD, (3, 1))).lost.tolist() == [False, True, False]
    batch.put(STARTS, np.array([False, True, False]))
    assert not batch.step(np.tile(AHEAD, (3, 1))).lost.any()


def test_a_heavier_robot_on_another_floor_moves_as_in_the_simulation(batch: Batch) -> None:
    drive(batch, 0)
    sims = []
    for row, mass, friction in zip(STARTS, batch.mass, batch.friction, strict=True):
        start = solo(load_robot(ROBOT), SE2.from_array(row))
        sims.append(Simulation(start, load_world(ROOM), QUIET, np.random.default_rng(0)))
        model = sims[-1].stage.scene.model
        model.geom_friction[:, 0] *= friction
        for field in (model.body_mass, model.body_inertia, model.body_subtreemass):
            field *= mass
    assert len({*batch.mass, *batch.friction}) == 6
    for _ in range(50):
        state = batch.step(np.tile(AHEAD, (3, 1)))
        found = [sim.drive(Velocity(AHEAD[0], yaw_rate=AHEAD[2])).truth.pose for sim in sims]
    expected = np.array([pose.array() for pose in found])
    np.testing.assert_allclose(state.poses, expected, atol=1e-3)
    moved = np.linalg.norm(expected[:, :2] - STARTS[:, :2], axis=1)
    assert np.ptp(moved) > 1e-3  # so that the masses and floors tell


def test_the_same_commands_bring_the_same_bytes(batch: Batch) -> None:
    assert drive(batch, 30) == drive(batch, 30)


def test_some_are_put_down_and_the_others_drive_on(batch: Batch) -> None:
    whole = drive(batch, 10)
    before = drive(batch, 5)
    elsewhere = np.array([[-1.0, 0.0, 1.0], [np.nan] * 3, [np.nan] * 3])
    batch.put(elsewhere, np.array([True, False, False]))
    states = [batch.step(np.tile(AHEAD, (3, 1))) for _ in range(5)]
    np.testing.assert_allclose(states[0].poses[0], elsewhere[0], atol=0.01)
    assert np.abs(states[0].velocities[0]).max() < 0.1
    assert before == whole[: len(before)]
    last = np.frombuffer(whole[-5]).reshape(3, 3)
    np.testing.assert_array_equal(states[-1].poses[1:], last[1:])


def test_noise_is_each_robots_own_and_comes_again_with_the_seed(batch: Batch) -> None:
    batch.put(np.zeros((3, 3)))
    noise = first(load_robot(ROBOT), LidarSettings).noise
    scans = np.array([batch.scan() for _ in range(4)]).astype(np.float64)
    for one, other in ((scans[:, 0], scans[:, 1]), (scans[:-1], scans[1:])):
        apart = (one - other)[np.isfinite(one) & np.isfinite(other)]
        assert apart.std() == pytest.approx(math.sqrt(2.0) * noise, rel=0.1)
        assert abs(apart.mean()) < noise / 5.0
    again = Batch(load_robot(ROBOT), load_world(ROOM), np.zeros((2, 3)), seed=5)
    np.testing.assert_array_equal(again.scan(), scans[0, :2].astype(np.float32))


def test_velocities_are_measured_at_the_wheels(batch: Batch) -> None:
    drive(batch, 0)
    for _ in range(50):
        state = batch.step(np.tile(AHEAD, (3, 1)))
    np.testing.assert_allclose(state.measured, np.tile(AHEAD, (3, 1)), atol=0.02)
    assert not state.touched.any()


CRATE = """<model name="crate"><pose>2 0 0.2 0 0 0</pose><link name="l"><inertial><mass>1</mass>
</inertial><collision name="c"><geometry><box><size>0.4 0.4 0.4</size></box></geometry></collision>
</link></model>"""
PERSON = """<actor name="anna"><script><trajectory id="0" type="walk"><waypoint><time>0</time>
<pose>3 0 0 0 0 0</pose></waypoint><waypoint><time>5</time><pose>8 0 0 0 0 0</pose></waypoint>
</trajectory></script></actor>"""


@pytest.mark.parametrize(
    ("inside", "problem"),
    [(CRATE, "'crate', which moves; valid: static"), (PERSON, "'anna', a person; valid: static")],
)
def test_moving_entities_are_refused_by_name(inside: str, problem: str, tmp_path: Path) -> None:
    world = load_world(saved_world(tmp_path, inside))
    with pytest.raises(WorldError, match=problem):
        Batch(load_robot(ROBOT), world, np.zeros((1, 3)))


def test_a_mesh_in_a_world_is_refused_by_name(tmp_path: Path) -> None:
    write_stl(tmp_path / "wall.stl", np.array([[[0.0, 0, 0], [1, 0, 0], [0, 0, 1]]]))
    mesh = "<geometry><mesh><uri>wall.stl</uri></mesh></geometry>"
    inside = f"<collision name='c'>{mesh}</collision>"
    model = f"<model name='ruin'><static>true</static><link name='l'>{inside}</link></model>"
    with pytest.raises(WorldError, match="'ruin', a mesh; valid: boxes"):
        Batch(load_robot(ROBOT), load_world(saved_world(tmp_path, model)), np.zeros((1, 3)))


def test_robots_of_another_kind_are_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(RobotError, match="mecanum wheels; valid: differential or skid-steer"):
        Batch(load_robot(mecanum().write(tmp_path)), load_world(EMPTY), np.zeros((1, 3)))
    robot = load_robot(ROBOT)
    blind = replace(robot, settings=replace(robot.settings, sensors=()))
    with pytest.raises(RobotError, match="without a planar lidar"):
        Batch(blind, load_world(EMPTY), np.zeros((1, 3)))


@pytest.mark.parametrize(
    ("given", "problem"),
    [
        ({"config": SimulatorConfig(lidar=LidarConfig(sweep=True))}, "'lidar.sweep' is true"),
        (
            {"config": SimulatorConfig(odometry=OdometryConfig(encoder_noise=1.0))},
            "'odometry.encoder_noise' is above 0",
        ),
        ({"device": "cuda:17"}, "device 'cuda:17' is not there; valid: cpu"),
    ],
)
def test_what_a_batch_does_not_do_is_refused(given: dict[str, Any], problem: str) -> None:
    with pytest.raises(ConfigError, match=problem):
        Batch(load_robot(ROBOT), load_world(EMPTY), np.zeros((1, 3)), **given)


def test_factors_that_no_robot_can_have_are_refused() -> None:
    with pytest.raises(ConfigError, match="'mass' is 0 to 1; valid: 0 < low <= high"):
        Variation(mass=(0.0, 1.0))


CONFIG = SimulatorConfig()
ROBOTS = ("urdf/arjuna.urdf", "urdf/burger.urdf", "urdf/udacity_bot.xacro")
TICK_ANGLE = 2.0 * math.pi / CONFIG.odometry.ticks_per_revolution


@pytest.mark.parametrize("file", ROBOTS)
def test_each_robot_is_driven_and_measured_as_alone(file: str) -> None:
    robot = load_robot(ROOT / file)
    base, limits = base_of(robot, CONFIG.drive), limited(CONFIG.drive, robot.drive, 1.5)
    wheels = [robot.urdf.joints[name].max_speed or np.inf for name in robot.drive.wheels]
    rng, tick = np.random.default_rng(3), CONFIG.tick
    batch = BatchDrive(base, limits, np.array(wheels), tick, TICK_ANGLE, 2)
    drives = [Drive(limits), Drive(limits)]
    slower = WheelSpeeds(robot, base)
    counted = [Odometry(CONFIG.odometry, base, rng) for _ in range(2)]
    for one in counted:
        one.reset(base.encoders(np.zeros(len(wheels))).tolist())
    angles = np.zeros((2, len(wheels)))
    for i in range(100):
        commands = rng.uniform(-3.0, 3.0, (2, 3)) * [1.0, 0.0, 2.0]
        speeds = batch.speeds(commands)
        for k, (v, _, w) in enumerate(commands.tolist()):
            drives[k].command(Velocity(v, yaw_rate=w), i * tick)
            wanted = slower.slowed(base.reachable(drives[k].velocity(i * tick, tick)))
            np.testing.assert_allclose(speeds[k], base.speeds(wanted), atol=1e-12)
        angles += speeds * tick
        moved = batch.velocities(angles)
        for k, odometry in enumerate(counted):
            found = odometry.update(base.encoders(angles[k]), tick)
            np.testing.assert_allclose(moved[k], (found.v, found.side, found.w), atol=1e-9)


def test_commands_that_are_not_finite_are_refused() -> None:
    robot = load_robot(ROOT / ROBOTS[0])
    base, limits = base_of(robot, CONFIG.drive), limited(CONFIG.drive, robot.drive, 1.5)
    batch = BatchDrive(base, limits, np.full(4, np.inf), CONFIG.tick, TICK_ANGLE, 3)
    with pytest.raises(CommandError, match=r"robots \[1\] must be finite"):
        batch.speeds(np.array([[0.1, 0.0, 0.0], [np.nan, 0.0, 0.0], [0.1, 0.0, 0.0]]))


def test_a_robot_that_is_put_down_starts_from_rest_and_the_others_drive_on() -> None:
    robot = load_robot(ROOT / ROBOTS[0])
    base, limits = base_of(robot, CONFIG.drive), limited(CONFIG.drive, robot.drive, 1.5)
    most = np.full(len(robot.drive.wheels), np.inf)
    batch = BatchDrive(base, limits, most, CONFIG.tick, TICK_ANGLE, 2)
    ahead = np.tile([0.5, 0.0, 0.0], (2, 1))
    first = batch.speeds(ahead)[0]
    for _ in range(5):
        batch.speeds(ahead)
    batch.restart(np.array([True, False]))
    speeds = batch.speeds(ahead)
    np.testing.assert_allclose(speeds[0], first)
    assert (speeds[1] > 2.0 * first).all()
