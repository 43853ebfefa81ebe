"""Several robots in one world: they meet, sense each other, come and go, and repeat themselves."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import RobotError
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.lidar import Cloud
from arjuna_sim.devices.sensors.lidar import CloudSettings, LidarConfig
from arjuna_sim.driven_robot import Observation
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.entities import BlockedPoseError, Entity
from arjuna_sim.model.robot import SOLO, RobotModel
from arjuna_sim.physics.robot_body import ROBOTS_MAX
from arjuna_sim.simulation import Simulation, Start
from tests.sim import drive_cases as cases
from tests.sim.arms import CONTROLLERS, write_arm
from tests.sim.builders import EMPTY, ROBOT, ROOM, ROOT, simulator
from tests.sim.robot_files.tags import sides

ARJUNA = load_robot(ROBOT)
BURGER = load_robot(ROOT / "urdf" / "burger.urdf")
EXACT = SimulatorConfig(lidar=LidarConfig(noise=0.0))
SIDES = (("left", 0.14), ("right", -0.14))
HALF = 0.2  # of Arjuna's length, about [m]


def together(
    starts: Mapping[str, Start], seed: int = 0, config: SimulatorConfig = EXACT
) -> Simulation:
    """Return robots by name in the empty world."""
    return Simulation(starts, load_world(EMPTY), config, np.random.default_rng(seed))


def pair(seed: int = 0, config: SimulatorConfig = EXACT, second: RobotModel = ARJUNA) -> Simulation:
    """Return `a` at the origin, and `b` 2 m before it that faces it."""
    behind = Start(second, SE2(2.0, 0.0, math.pi))
    return together({"a": Start(ARJUNA), "b": behind}, seed, config)


def run(
    simulation: Simulation, seconds: float, commands: Mapping[str, Velocity] | None = None
) -> dict[str, Observation]:
    """Step for a time, repeating commands; return the last observations."""
    for _ in range(round(seconds / simulation.config.tick)):
        last = simulation.step(commands or {})
    return last


def ahead(seen: Observation) -> float:
    """Return the range ahead [m]."""
    assert seen.scan is not None
    return float(seen.scan.ranges[len(seen.scan.ranges) // 2])


def sensed(seen: Mapping[str, Observation]) -> bytes:
    """Return all that robots sensed in a tick."""
    parts = []
    for one in seen.values():
        odometry, truth = one.odometry, one.truth
        parts += [odometry.T_odom_base.array(), odometry.covariance, truth.pose.array()]
        parts += [np.array([one.time, odometry.v, odometry.w, truth.v, truth.w, truth.z])]
        parts += [one.joints.positions, one.joints.velocities]
        if one.imu is not None:
            parts += [one.imu.linear_acceleration, one.imu.angular_velocity, np.array(one.imu.rpy)]
        parts += [] if one.scan is None else [one.scan.ranges]
    return b"".join(np.ascontiguousarray(part).tobytes() for part in parts)


def test_each_lidar_sees_the_other_robot_and_not_its_own() -> None:
    simulation = pair()
    seen = run(simulation, 0.1)
    for name in ("a", "b"):
        assert 2.0 - 2.0 * HALF < ahead(seen[name]) < 2.0
        scan = seen[name].scan
        assert scan is not None
        assert np.isfinite(scan.ranges).sum() < 40  # the other alone: nothing else is there
    simulation.remove("b")
    assert ahead(run(simulation, 0.1)["a"]) == math.inf


def test_a_lidar_of_several_rows_sees_the_other_robot_and_not_its_own() -> None:
    rows = CloudSettings(
        link="lidar_link",
        frame="lidar_link",
        rate=10.0,
        topic="cloud",
        name="rows",
        samples=361,
        angle_min=-math.pi,
        angle_max=math.pi,
        range_min=0.1,
        range_max=10.0,
        noise=0.0,
        rows=5,
        tilt_min=-0.2,
        tilt_max=0.2,
    )
    settings = dataclasses.replace(ARJUNA.settings, sensors=(*ARJUNA.settings.sensors, rows))
    robot = dataclasses.replace(ARJUNA, settings=settings)
    simulation = together({"a": Start(robot), "b": Start(ARJUNA, SE2(2.0))})
    run(simulation, 0.02)
    cloud = simulation.robots["a"].sense(rows, 0.02)
    assert isinstance(cloud, Cloud)
    above = cloud.points[cloud.points[:, 2] > -0.1]  # lower ones are of the ground
    assert len(above) > 0
    assert ((above[:, 0] > 1.5) & (above[:, 0] < 2.3)).all()


def test_a_robot_that_runs_into_another_feels_it_and_stops() -> None:
    simulation = pair(second=BURGER)
    seen = run(simulation, 6.0, {"a": Velocity(0.4), "b": Velocity(0.2)})
    assert (seen["a"].contacts, seen["b"].contacts) == (("b",), ("a",))
    gap = seen["b"].truth.pose.x - seen["a"].truth.pose.x
    assert gap > 0.15
    assert seen["b"].truth.pose.x > 0.5  # else it went through


def test_a_command_moves_only_its_own_robot() -> None:
    simulation = pair()
    run(simulation, 0.2)
    seen = run(simulation, 1.0, {"b": Velocity(0.2)})
    assert seen["a"].truth.pose.distance(SE2()) < 1e-4
    assert seen["b"].truth.pose.x == pytest.approx(1.83, abs=0.03)
    seen = run(simulation, 1.0)  # the watchdog
    assert abs(seen["b"].truth.v) < 1e-3


def test_robots_of_every_shipped_file_share_a_world() -> None:
    files = sorted(p for p in (ROOT / "urdf").iterdir() if p.suffix in (".urdf", ".xacro"))
    robots = {f"r{i}": load_robot(path) for i, path in enumerate(files)}
    starts = {n: Start(r, SE2(3.0 * i)) for i, (n, r) in enumerate(robots.items())}
    simulation = together(starts)
    seen = run(simulation, 2.0, dict.fromkeys(starts, Velocity(0.2)))
    for name in starts:
        direction = seen[name].truth.pose.x - simulation.robots[name].spawn.x
        alone = simulator(robot=files[list(starts).index(name)])
        for _ in range(100):
            last = alone.drive(Velocity(0.2))
        assert direction == pytest.approx(last.truth.pose.x, abs=1e-3)
        assert seen[name].joints.names == last.joints.names


def test_each_robot_has_noise_of_its_own_whoever_else_is_there() -> None:
    config = SimulatorConfig()
    both = run(pair(config=config), 0.2)
    assert both["a"].imu is not None
    assert both["b"].imu is not None
    assert both["a"].imu.rpy[:2] != both["b"].imu.rpy[:2]
    only = {"b": Start(ARJUNA, SE2(2.0, 0.0, math.pi))}
    alone = run(together(only, config=config), 0.2)["b"].imu
    assert alone is not None
    assert both["b"].imu.angular_velocity == pytest.approx(alone.angular_velocity, abs=1e-9)


def _coming_and_going(seed: int) -> bytes:
    simulation = pair(seed, SimulatorConfig())
    drive = {
        "a": Velocity(0.2, yaw_rate=0.3),
        "b": Velocity(0.1, yaw_rate=-0.2),
        "c": Velocity(0.2),
    }
    parts = [sensed(simulation.step(drive)) for _ in range(20)]
    simulation.add("c", Start(BURGER, SE2(0.0, 1.5, 1.0)))
    parts += [sensed(simulation.step(drive)) for _ in range(20)]
    simulation.remove("a")
    parts += [sensed(simulation.step(drive)) for _ in range(20)]
    simulation.reset()
    assert set(simulation.robots) == {"a", "b"}
    again = [sensed(simulation.step(drive)) for _ in range(20)]
    assert again == parts[:20]
    return b"".join(parts)


def test_robots_that_come_and_go_repeat_themselves() -> None:
    first = _coming_and_going(3)
    assert first == _coming_and_going(3)
    assert first != _coming_and_going(4)


def test_a_robot_continues_when_another_comes_or_leaves() -> None:
    simulation = pair()
    run(simulation, 0.5, {"a": Velocity(0.3, yaw_rate=0.5)})
    before, wheels = simulation.robots["a"].truth(), simulation.robots["a"].wheel_angles()
    simulation.add("c", Start(ARJUNA, SE2(0.0, 2.0)))
    assert simulation.robots["a"].truth() == before
    simulation.remove("b")
    assert simulation.robots["a"].truth() == before
    assert simulation.robots["a"].wheel_angles() == wheels
    seen = run(simulation, 0.2, {"a": Velocity(0.3, yaw_rate=0.5)})
    assert seen["a"].truth.v == pytest.approx(0.3, abs=0.02)


def test_robots_that_start_at_one_pose_stand_beside_each_other() -> None:
    simulation = together({"a": Start(ARJUNA), "b": Start(ARJUNA)})
    first, second = (robot.spawn for robot in simulation.robots.values())
    assert first == SE2()
    assert 0.3 < second.distance(first) < 1.0
    assert any(note.startswith("b: the start (0, 0) is inside a") for note in simulation.notes)


def test_a_pose_that_is_taken_is_refused_and_nothing_changes() -> None:
    simulation = pair()
    with pytest.raises(BlockedPoseError, match="'c' would stand in b there"):
        simulation.add("c", Start(BURGER, SE2(2.05)))
    assert set(simulation.robots) == set(simulation.stage.robots) == {"a", "b"}
    simulation.add("c", Start(BURGER, SE2(3.0)))
    simulation.stage.spawn(Entity("post", (), start=Pose3((5.0, 0.0, 0.0)), spawned=True))
    simulation.clear_spawned()
    assert simulation.stage.entities == ()
    assert set(simulation.robots) == {"a", "b"}


def test_a_robot_beside_one_without_a_name_comes_and_goes() -> None:
    sim = simulator()
    sim.add("b", Start(ARJUNA, SE2(2.0)))
    assert set(sim.step({"b": Velocity(0.1)})) == {SOLO, "b"}
    seen = run(sim, 6.0, {SOLO: Velocity(0.4)})
    assert (seen[SOLO].contacts, seen["b"].contacts) == (("b",), ("arjuna",))
    sim.remove("b")
    assert set(sim.step({})) == {SOLO}


def test_more_robots_than_there_are_bits_are_refused() -> None:
    starts = {f"r{i}": Start(BURGER, SE2(i)) for i in range(ROBOTS_MAX + 1)}
    with pytest.raises(RobotError, match=f"at most {ROBOTS_MAX} can be in one world"):
        together(starts)


@pytest.mark.parametrize(
    ("at", "is_said"), [((-8.0, 0.5), True), ((5.4, -5.4), True), ((0.0, 0.0), False)]
)
def test_a_start_outside_is_noted_with_one_inside(at: tuple[float, float], is_said: bool) -> None:
    sim = simulator(ROOM, spawn=SE2(*at))
    assert sim.robot.spawn == SE2(*at)
    said = [note for note in sim.notes if "outside the world's walls" in note]
    assert len(said) == is_said
    for note in said:
        assert f"the start ({at[0]:g}, {at[1]:g})" in note
        x, y = map(float, note.rpartition("inside is (")[2].rstrip(")").split(","))
        assert simulator(ROOM, spawn=SE2(x, y)).notes == simulator(ROOM).notes


def balancing(folder: Path) -> Path:
    """Write a robot on one axle."""
    wheels = tuple(cases.Wheel(f"one_{side}_wheel", 0.0, y) for side, y in SIDES)
    drive = cases.plugin("gz-sim-diff-drive-system", sides("one"))
    return cases.Robot(wheels, drive, radius=0.1).write(folder)


@pytest.mark.parametrize(
    ("write", "tick", "wanted"),
    [
        (balancing, 0.02, 0.004),
        (balancing, 0.012, 0.012),
        (lambda folder: write_arm(folder, {"efforts": CONTROLLERS["efforts"]}), 0.02, 0.004),
        (lambda folder: write_arm(folder, CONTROLLERS), 0.02, 0.02),  # others hold its joints
        (lambda _: ROBOT, 0.02, 0.02),
    ],
)
def test_who_is_held_upright_or_pushed_from_outside_has_a_short_tick(
    tmp_path: Path, write: Callable[[Path], Path], tick: float, wanted: float
) -> None:
    starts = {"": Start(load_robot(write(tmp_path)))}
    sim = together(starts, config=SimulatorConfig(tick=tick))
    sim.adjust(SimulatorConfig(tick=tick))
    before = sim.time
    sim.drive()
    assert sim.config.tick == sim.time - before == wanted
