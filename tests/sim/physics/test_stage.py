"""Entities come, go and move while the simulation runs, and nothing else notices."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.sensors.lidar import LidarSettings
from arjuna_sim.files.library import Library
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.spawned import read_entity
from arjuna_sim.model.entities import BlockedPoseError, Entity, UnknownEntityError
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.world import Trajectory
from arjuna_sim.physics.contacts import ContactLog
from arjuna_sim.simulation import Simulation
from tests.sim.builders import EMPTY, ROOM, ROOT, first, run, simulator

QUIET = SimulatorConfig(lidar=dataclasses.replace(SimulatorConfig().lidar, noise=0.0))


def _entity(text: str, name: str, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Entity:
    read = read_entity(text, "", Library(ROOT, SearchPath()))
    return dataclasses.replace(read, name=name, start=Pose3((x, y, z)))


def _ahead(sim: Simulation) -> float:
    """Return what the beam straight ahead reads [m]."""
    sim.reset_time()
    scan = next(o.scan for o in (sim.drive() for _ in range(10)) if o.scan is not None)
    return float(scan.ranges[len(scan.ranges) // 2])


def test_spawned_box_is_seen_at_its_pose_and_gone_when_deleted() -> None:
    sim = simulator(EMPTY, QUIET)
    run(sim, 0.1)
    assert math.isinf(_ahead(sim))
    sim.stage.spawn(_entity("box:0.4,0.4,1", "crate", x=2.0))
    seen = _ahead(sim)
    lidar = sim.robot.model.urdf.T_root(first(sim.robot.model, LidarSettings).link).position[0]
    assert seen == pytest.approx(2.0 - 0.2 - sim.robot.truth().pose.x - lidar, abs=2e-3)
    sim.stage.move("crate", Pose3((3.0, 0.0, 0.0)))
    assert _ahead(sim) == pytest.approx(seen + 1.0, abs=2e-3)
    sim.stage.delete("crate")
    assert math.isinf(_ahead(sim))


def test_nothing_jumps_when_something_is_spawned_far_away() -> None:
    """A twin without the spawn drives the same, bit by bit, and its sensors read the same."""
    plain, changed = simulator(ROOM, seed=3), simulator(ROOM, seed=3)
    for sim in (plain, changed):
        run(sim, 1.0, Velocity(0.5, yaw_rate=0.4))
    changed.stage.spawn(_entity("sphere:0.1", "ball", x=4.0, y=4.0))
    changed.stage.delete("ball")
    changed.stage.spawn(_entity("box:0.1,0.1,0.1?mass=1", "die", x=4.0, y=4.0))
    for _ in range(50):
        a, b = plain.drive(Velocity(0.5, yaw_rate=0.4)), changed.drive(Velocity(0.5, yaw_rate=0.4))
        assert a.truth.pose.distance(b.truth.pose) < 1e-9
        assert a.odometry.T_odom_base.distance(b.odometry.T_odom_base) < 1e-9
        assert a.imu is not None
        assert b.imu is not None
        assert np.allclose(a.imu.linear_acceleration, b.imu.linear_acceleration, atol=1e-6)
    assert changed.time == plain.time


def test_models_of_the_world_can_be_moved_and_deleted_and_come_back() -> None:
    sim = simulator(ROOM, QUIET)
    seen = _ahead(sim)  # the red box
    names = [entity.name for entity in sim.stage.entities]
    point = sim.stage.motion("obstacle_red").pose
    sim.stage.move("obstacle_red", Pose3((point.position[0] + 0.5, *point.position[1:])))
    assert _ahead(sim) == pytest.approx(seen + 0.5, abs=2e-3)
    sim.stage.delete("obstacle_red")
    assert _ahead(sim) > seen + 1.0
    with pytest.raises(UnknownEntityError, match="'obstacle_red' does not exist"):
        sim.stage.motion("obstacle_red")
    sim.reset()
    assert [entity.name for entity in sim.stage.entities] == names
    assert sim.stage.motion("obstacle_red").pose == point
    assert _ahead(sim) == pytest.approx(seen, abs=2e-3)


def test_what_was_spawned_survives_a_reset_of_the_state_at_its_start_only() -> None:
    sim = simulator(EMPTY)
    sim.stage.spawn(_entity("box:0.4,0.4,1", "crate", x=2.0))
    sim.stage.move("crate", Pose3((3.0, 1.0, 0.0)))
    run(sim, 0.5, Velocity(0.5))
    sim.reset_state()
    assert sim.time == 0.5
    assert sim.robot.truth().pose.distance(SE2()) < 1e-9
    assert sim.stage.motion("crate").pose.position == (2.0, 0.0, 0.0)
    sim.reset()
    assert sim.stage.entities == ()


def test_run_after_a_reset_is_the_first_run_whatever_was_spawned() -> None:
    def drive(sim: Simulation) -> list[bytes]:
        steps = [sim.drive(Velocity(0.6, yaw_rate=0.5)) for _ in range(60)]
        return [o.truth.pose.array().tobytes() + repr(o.contacts).encode() for o in steps]

    sim = simulator(ROOM, seed=5)
    first = drive(sim)
    sim.stage.spawn(_entity("box:0.4,0.4,1", "crate", x=-2.0))
    sim.stage.delete("obstacle_red")
    drive(sim)
    sim.reset()
    assert drive(sim) == first


def test_time_alone_can_be_reset_and_the_robot_drives_on() -> None:
    sim = simulator(EMPTY)
    run(sim, 2.0, Velocity(0.5))
    x = sim.robot.truth().pose.x
    sim.reset_time()
    assert sim.time == 0.0
    assert sim.drive().truth.v == pytest.approx(0.5, abs=0.02)
    assert sim.robot.truth().pose.x == pytest.approx(x + 0.01, abs=2e-3)


@pytest.mark.parametrize("x", [0.0, 0.2])
def test_nothing_can_be_put_into_the_robot(x: float) -> None:
    sim = simulator(EMPTY)
    before = sim.robot.truth()
    with pytest.raises(BlockedPoseError, match="'crate' would stand in the robot"):
        sim.stage.spawn(_entity("box:0.4,0.4,1", "crate", x=x))
    assert sim.stage.entities == ()
    sim.stage.spawn(_entity("box:0.4,0.4,1", "crate", x=2.0))
    with pytest.raises(BlockedPoseError, match="'crate' would stand in the robot"):
        sim.stage.move("crate", Pose3((x, 0.0, 0.0)))
    assert sim.stage.motion("crate").pose.position == (2.0, 0.0, 0.0)
    assert sim.robot.truth() == before


def test_robot_stops_at_a_held_box_and_pushes_a_free_one() -> None:
    held, free = simulator(EMPTY), simulator(EMPTY)
    held.stage.spawn(_entity("box:0.4,0.4,0.4", "crate", x=1.0))
    free.stage.spawn(_entity("box:0.4,0.4,0.4?mass=1", "crate", x=1.0))
    last = run(held, 4.0, Velocity(0.5))
    assert last.contacts == ("crate",)
    assert last.truth.pose.x < 0.8
    assert held.stage.motion("crate").pose.position == (1.0, 0.0, 0.0)
    run(free, 4.0, Velocity(0.5))
    assert free.stage.motion("crate").pose.position[0] > 1.2
    assert free.stage.motion("crate").pose.position[2] == pytest.approx(0.0, abs=0.01)


def test_box_at_rest_on_the_ground_is_no_contact_of_the_robot() -> None:
    sim = simulator(EMPTY)
    sim.stage.spawn(_entity("box:0.4,0.4,0.4?mass=2", "crate", x=2.0))
    assert run(sim, 1.0).contacts == ()
    assert sim.stage.motion("crate").pose.position[0] == pytest.approx(2.0, abs=1e-3)


def _walker(points: list[list[float]], speed: float, loop: bool = False) -> Entity:
    path = Trajectory.along(np.array(points), speed, loop)
    return dataclasses.replace(_entity("person", "walker"), trajectory=path)


def test_actor_walks_its_path_shows_in_the_lidar_and_bumps_the_robot() -> None:
    sim = simulator(EMPTY, QUIET)
    sim.stage.spawn(_walker([[4.0, 0.0], [-4.0, 0.0]], 1.0))
    ranges, bumped = [], False
    for _ in range(250):
        observation = sim.drive()
        bumped = bumped or "walker" in observation.contacts
        if observation.scan is not None:
            ranges.append(float(observation.scan.ranges[180]))
    motion = sim.stage.motion("walker")
    assert motion.pose.position[0] == pytest.approx(4.0 - 5.0, abs=1e-9)
    assert motion.linear == pytest.approx((-1.0, 0.0, 0.0), abs=1e-6)
    assert np.diff(ranges[:20]) == pytest.approx(-0.1, abs=1e-3)
    assert bumped
    assert sim.robot.truth().pose.x < -0.2  # it was pushed along, not run through
    assert abs(sim.robot.truth().z) < 0.05


@pytest.mark.parametrize("speed", [0.5, 1.5])
def test_robot_between_a_person_and_a_wall_stays_in_the_room(speed: float) -> None:
    sim = simulator(ROOM, spawn=SE2(4.0, 1.0, 0.0))
    sim.stage.spawn(_walker([[2.0, 1.0], [4.4, 1.0], [2.0, 1.05]], speed, loop=True))
    for _ in range(500):
        truth = sim.drive().truth
        assert truth.pose.x < 4.9  # the wall's face, less than half the robot's width
        assert abs(truth.z) < 0.15
    assert sim.robot.truth().pose.x > 4.3  # it was pushed there


def test_path_of_what_is_spawned_begins_when_it_is() -> None:
    sim = simulator(EMPTY)
    run(sim, 1.0)
    sim.stage.spawn(_walker([[3.0, 0.0], [3.0, 2.0]], 0.5))
    run(sim, 1.0)
    assert sim.stage.motion("walker").pose.position == pytest.approx((3.0, 0.5, 0.0))
    further = dataclasses.replace(_walker([[5.0, 0.0], [5.0, 2.0]], 0.5), name="further")
    sim.stage.spawn(further, walked=2.0)
    assert sim.stage.motion("further").pose.position == pytest.approx((5.0, 1.0, 0.0))
    run(sim, 1.0)
    assert sim.stage.motion("further").pose.position == pytest.approx((5.0, 1.5, 0.0))
    assert sim.stage.walking_time("further") == pytest.approx(3.0)


def test_actors_of_a_world_walk_from_the_start_and_again_after_a_reset(tmp_path: Path) -> None:
    path = tmp_path / "a.world"
    path.write_text(
        '<sdf version="1.7"><world name="w"><actor name="walker"><script><trajectory id="0"'
        ' type="walk"><waypoint><time>0</time><pose>2 0 0 0 0 0</pose></waypoint><waypoint>'
        "<time>10</time><pose>2 5 0 0 0 0</pose></waypoint></trajectory></script></actor>"
        "</world></sdf>"
    )
    sim = simulator(path)
    for _ in range(2):
        run(sim, 2.0)
        assert sim.stage.motion("walker").pose.position == pytest.approx((2.0, 1.0, 0.0))
        sim.reset()
    assert sim.stage.motion("walker").pose.position == pytest.approx((2.0, 0.0, 0.0))


def test_contacts_are_counted_when_they_begin() -> None:
    log = ContactLog()
    changes = [log.update(touched) for touched in ((), ("a",), ("a",), ("a", "b"), (), ("a",))]
    assert changes == [False, True, False, True, True, True]
    assert (log.counts, log.total) == ({"a": 2, "b": 1}, 3)


def _block(name: str, point: tuple[float, float, float]) -> Entity:
    part = Part(Shape(Kind.BOX, (0.3, 0.3, 0.3)), Pose3((0.0, 0.0, 0.15)))
    return Entity(name, (part,), start=Pose3(point), mass=2.0)


def _awake(sim: Simulation) -> int:
    """Return how many things the physics moves, the robot among them."""
    return int(sim.stage.data.ntree_awake)


def test_what_lies_still_sleeps_until_it_is_moved_or_loses_its_support() -> None:
    sim = simulator(EMPTY)
    for block in (_block("low", (2.0, 0.0, 0.0)), _block("high", (2.0, 0.0, 0.3))):
        sim.stage.spawn(block)
    run(sim, 2.0)
    assert _awake(sim) == 1
    sim.stage.move("low", Pose3((4.0, 0.0, 1.0)))
    run(sim, 1.5)
    positions = [sim.stage.motion(name).pose.position for name in ("low", "high")]
    assert positions[0] == pytest.approx((4.0, 0.0, 0.0), abs=1e-3)
    assert positions[1] == pytest.approx((2.0, 0.0, 0.0), abs=1e-3)
    run(sim, 1.0)
    assert _awake(sim) == 1


def test_robot_does_not_notice_what_falls_asleep() -> None:
    plain, beside = simulator(EMPTY), simulator(EMPTY)
    for i in range(3):
        beside.stage.spawn(_block(f"block{i}", (5.0 + i, 3.0, 0.001 * i)))
    for _ in range(60):
        a, b = plain.drive(Velocity(0.5, yaw_rate=0.4)), beside.drive(Velocity(0.5, yaw_rate=0.4))
        assert a.truth.pose.distance(b.truth.pose) < 1e-9
    assert _awake(beside) == 1


def test_person_wakes_what_it_walks_into() -> None:
    sim = simulator(EMPTY)
    sim.stage.spawn(_block("block", (4.0, 0.0, 0.0)))
    path = Trajectory.along(np.array([[4.0, -3.0], [4.0, 3.0]]), 1.0, False)
    sim.stage.spawn(dataclasses.replace(_entity("person", "walker"), trajectory=path))
    run(sim, 2.0)
    assert _awake(sim) == 1
    run(sim, 1.5)
    assert sim.stage.motion("block").pose.position[1] > 0.3
