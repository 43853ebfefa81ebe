"""Every robot in urdf/ loads clean, and drives, turns and senses as its file says."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from arjuna_core.twist import Velocity
from arjuna_sim.check import describe_file
from arjuna_sim.devices.sensors.imu import ImuSettings
from arjuna_sim.devices.sensors.lidar import LidarSettings
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.simulation import Simulation
from scripts import fusion_meshes
from tests.sim.builders import ROOT, first, run, simulator

pytestmark = pytest.mark.usefixtures("without_sills")

ROBOTS = sorted(
    path
    for path in (ROOT / "urdf").rglob("*")
    if path.suffix in (".urdf", ".xacro") and "<joint " in path.read_text(encoding="utf-8")
)
EACH = pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.name)
FOUND = {
    "arjuna.urdf",
    "arjuna.urdf.xacro",
    "burger.urdf",
    "diffbot.urdf",
    "fusion.xacro",
    "udacity_bot.xacro",
}
OFF = 0.03
"""Share that a distance or a turn may be off."""
_REST = 1.0


def test_the_robots_are_those_we_speak_of() -> None:
    assert {path.name for path in ROBOTS} == FOUND


@EACH
def test_check_understands_all_of_it(path: Path) -> None:
    assert describe_file(path).endswith("all understood")


@EACH
def test_it_stands_drives_a_metre_and_turns_by_ninety_degrees(path: Path) -> None:
    sim = simulator(robot=path)
    start = sim.robot.truth().pose
    still = run(sim, 3.0, Velocity()).truth.pose
    assert still.distance(start) < 0.002
    assert abs(still.theta) < 0.005
    _drive(sim, Velocity(0.2), 5.0)
    moved = sim.robot.truth().pose
    assert moved.x == pytest.approx(1.0, rel=OFF)
    assert abs(moved.y) < 0.02
    for direction in (1.0, -1.0):
        before = sim.robot.truth().pose
        _drive(sim, Velocity(yaw_rate=direction * 0.5), math.pi)
        turned = before.inverse() @ sim.robot.truth().pose
        assert turned.theta == pytest.approx(direction * math.pi / 2, rel=OFF)
        assert math.hypot(turned.x, turned.y) < 0.03


def _drive(sim: Simulation, command: Velocity, seconds: float) -> None:
    run(sim, 0.5, Velocity())
    run(sim, seconds, command)
    run(sim, _REST, Velocity())


@EACH
def test_its_odometry_agrees(path: Path) -> None:
    sim = simulator(robot=path)
    _drive(sim, Velocity(0.2, yaw_rate=0.3), 5.0)
    believed = run(sim, 0.02).odometry.T_odom_base
    truth = sim.robot.truth().pose
    assert believed.distance(truth) < 0.05
    assert believed.theta == pytest.approx(truth.theta, abs=0.06)


@EACH
def test_its_sensors_read_at_their_rates(path: Path) -> None:
    sim = simulator(robot=path)
    seen = [sim.drive(Velocity(0.1, yaw_rate=0.1)) for _ in range(100)]
    seconds = 100 * sim.config.tick
    robot = sim.robot.model
    lidar, imu = first(robot, LidarSettings), robot.settings.first(ImuSettings)
    scans = [o.scan for o in seen if o.scan is not None]
    assert len(scans) == pytest.approx(lidar.rate * seconds, abs=1)
    assert all(len(scan.ranges) == lidar.samples for scan in scans)
    readings = sum(len(o.imu_before) + (o.imu is not None) for o in seen)
    assert readings == pytest.approx(0 if imu is None else imu.rate * seconds, abs=1)


@EACH
def test_its_lidar_sees_the_room_and_not_itself(path: Path) -> None:
    sim = simulator(ROOT / "worlds" / "arjuna_room.world", robot=path)
    scan = next(o.scan for _ in range(50) if (o := sim.drive()).scan is not None)
    assert scan is not None
    nearest = min(r for r in scan.ranges.tolist() if math.isfinite(r))
    assert min(1.5, first(sim.robot.model, LidarSettings).range_max) < nearest


def test_facts_of_the_guides_robots() -> None:
    robots = {p.name: load_robot(p, SearchPath()) for p in ROBOTS}
    fusion = robots["fusion.xacro"]
    drive, lidar = fusion.drive, first(fusion, LidarSettings)
    assert lidar is not None
    assert (drive.separation, drive.diameter, drive.torque) == (0.538, 0.241, 20.0)
    assert (drive.rate, drive.base_frame, drive.from_world) == (10.0, "base_link", True)
    assert (lidar.samples, lidar.rate, lidar.noise, lidar.topic) == (720, 40.0, 0.01, "/scan")
    diffbot = robots["diffbot.urdf"].drive
    assert (diffbot.separation, diffbot.diameter, diffbot.torque) == (0.22, 0.1, 20.0)
    burger = robots["burger.urdf"]
    assert (burger.drive.separation, burger.drive.max_velocity) == (0.16, 0.22)
    assert (
        first(burger, LidarSettings).range_max,
        first(burger, LidarSettings).rate,
    ) == (3.5, 5.0)
    udacity = robots["udacity_bot.xacro"]
    assert udacity.drive.base_frame == "robot_footprint"
    assert first(udacity, LidarSettings).topic == "/udacity_bot/laser/scan"
    assert {"gripper_pole", "gripper", "left_gripper", "right_gripper"} <= udacity.urdf.links.keys()


def test_fusions_meshes_are_what_their_script_draws(tmp_path: Path) -> None:
    fusion_meshes.write(tmp_path)
    shipped = {path.name: path.read_bytes() for path in fusion_meshes.FOLDER.iterdir()}
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == shipped
