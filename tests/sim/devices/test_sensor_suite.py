"""A robot's first lidar and IMU, and the surfaces that they measure."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices import sensor_suite
from arjuna_sim.devices.imu import Imu
from arjuna_sim.devices.sensors.imu import ImuConfig, ImuSettings
from arjuna_sim.devices.sensors.lidar import LidarConfig, LidarSettings
from arjuna_sim.simulation import Simulation
from tests.sim.builders import EMPTY, ROBOT, ROOM, edited, first, run, simulator


def _scan(sim: Simulation) -> Scan:
    while True:
        scan = sim.drive().scan
        if scan is not None:
            return scan


def test_surfaces_of_the_room_are_its_walls_and_boxes() -> None:
    surfaces = simulator(ROOM).robot.surfaces()
    assert surfaces.shape == (8 * 4, 4)
    assert np.abs(surfaces).max() == pytest.approx(5.1)


def test_robot_does_not_see_itself_and_empty_world_returns_inf() -> None:
    assert np.isinf(_scan(simulator(EMPTY)).ranges).all()


def test_range_beyond_the_maximum_is_plus_inf_and_too_near_is_minus_inf(tmp_path: Path) -> None:
    robot = edited(ROBOT, tmp_path, "<min>0.12</min>", "<min>3.0</min>")
    robot = edited(robot, tmp_path, "<max>12.0</max>", "<max>5.5</max>")
    scan = _scan(simulator(ROOM, SimulatorConfig(lidar=LidarConfig(noise=0.0)), robot=robot))
    assert scan.ranges[225] == np.inf  # the corner, 6.9 m away
    assert scan.ranges[180] == -np.inf  # the red box, 2.25 m ahead
    assert scan.ranges[90] == pytest.approx(4.9, abs=0.01)


def test_each_sensor_draws_its_noise_from_a_seed_of_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    settings, made = simulator().robot.model.settings, dict[Any, float]()

    def mounted(sensor: Any, rng: np.random.Generator) -> Any:
        made[type(sensor)] = rng.random()

    monkeypatch.setattr(sensor_suite, "device_of", lambda sensor, mount: mount)
    sensor_suite.SensorSuite(settings, mounted, np.array([3, 4], np.uint64))
    drawn = [np.random.default_rng(seed).random() for seed in (3, 4)]
    assert made == {LidarSettings: drawn[0], ImuSettings: drawn[1]}


def test_resting_imu_feels_gravity_upward_with_its_noise() -> None:
    sim = simulator()
    run(sim, 0.5)
    readings = [sim.drive().imu for _ in range(1000)]
    force = np.array([r.linear_acceleration for r in readings if r is not None])
    rates = np.array([r.angular_velocity for r in readings if r is not None])
    assert force.mean(axis=0) == pytest.approx([0.0, 0.0, 9.81], abs=0.02)
    assert force.std(axis=0) == pytest.approx([0.02] * 3, rel=0.1)
    assert rates.std(axis=0) == pytest.approx([0.002] * 3, rel=0.1)


def test_imu_measures_turn_rate_and_heading_of_a_spin() -> None:
    sim = simulator(config=SimulatorConfig(imu=ImuConfig(0.0, 0.0, 0.0, 0.0, 0.0)))
    last = run(sim, 2.0, Velocity(yaw_rate=0.8))
    assert last.imu is not None
    assert last.imu.angular_velocity[2] == pytest.approx(last.truth.w, abs=1e-9)
    assert last.imu.rpy[2] == pytest.approx(last.truth.pose.theta, abs=0.01)


def test_heading_is_that_since_the_start_in_any_direction() -> None:
    sim = simulator(spawn=SE2(0.0, 0.0, 1.0))
    settings, exact = (
        first(sim.robot.model, ImuSettings),
        ImuConfig(0.0, 0.0, 0.0, 0.0, 0.0),
    )
    assert settings is not None
    imu = Imu(sim.stage.scene.model, settings, exact, np.random.default_rng(0))
    assert imu.measure(sim.stage.data, 0.0, 0.02).rpy[2] == pytest.approx(0.0, abs=1e-9)
    start = sim.robot.truth().pose.theta
    run(sim, 1.0, Velocity(yaw_rate=0.5))
    turned = imu.measure(sim.stage.data, 1.0, 0.02).rpy[2]
    assert turned == pytest.approx(sim.robot.truth().pose.theta - start, abs=1e-6)


def test_bias_walks_with_the_root_of_time() -> None:
    sim, config = simulator(), ImuConfig(0.0, 0.1, 0.0, 0.3, 0.0)
    settings, rng = first(sim.robot.model, ImuSettings), np.random.default_rng(3)
    assert settings is not None
    readings = []
    for _ in range(500):
        imu = Imu(sim.stage.scene.model, settings, config, rng)
        readings.append([imu.measure(sim.stage.data, 0.4 * i, 0.4) for i in range(10)][-1])
    rates = np.array([reading.angular_velocity for reading in readings])
    forces = np.array([reading.linear_acceleration for reading in readings])
    assert rates.std(axis=0) == pytest.approx([0.1 * math.sqrt(4.0)] * 3, rel=0.1)
    assert forces.std(axis=0) == pytest.approx([0.3 * math.sqrt(4.0)] * 3, rel=0.1)


def test_bias_of_a_file_that_forgets_it_stays_bounded() -> None:
    """A Gauss-Markov process has the deviation sigma sqrt(tau / 2) for ever."""
    sim, config = simulator(), ImuConfig(0.0, 9.0, 0.0, 9.0, 0.0)
    settings, rng = first(sim.robot.model, ImuSettings), np.random.default_rng(4)
    settings = replace(settings, gyro_drift=(0.1, 2.0), accel_drift=(0.3, 0.5))
    imu = Imu(sim.stage.scene.model, settings, config, rng)
    readings = [imu.measure(sim.stage.data, 0.02 * i, 0.02) for i in range(30_000)][500:]
    rates = np.array([reading.angular_velocity for reading in readings])
    forces = np.array([reading.linear_acceleration for reading in readings])
    assert rates.std(axis=0) == pytest.approx([0.1 * math.sqrt(1.0)] * 3, rel=0.15)
    assert forces.std(axis=0) == pytest.approx([0.3 * math.sqrt(0.25)] * 3, rel=0.15)
