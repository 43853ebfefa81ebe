"""Any number of sensors of each kind, mounted anyhow, against closed-form truth."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices import imu
from arjuna_sim.devices.imu import ImuReading
from arjuna_sim.devices.lidar import Cloud
from arjuna_sim.devices.sensors.battery import BatterySettings, Supply
from arjuna_sim.devices.sensors.bumper import BumperSettings
from arjuna_sim.devices.sensors.imu import ImuConfig
from arjuna_sim.devices.sensors.lidar import (
    CloudSettings,
    LidarConfig,
    LidarSettings,
)
from arjuna_sim.devices.sensors.navsat import Fix
from arjuna_sim.model.entities import Entity
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.settings import SensorSettings
from arjuna_sim.simulation import Simulation
from tests.sim.builders import EMPTY, ROOM, first, run, simulator
from tests.sim.robot_cases import RobotMaker

SCAN = """<ray><scan><horizontal><samples>{samples}</samples><min_angle>-{half}</min_angle>
<max_angle>{half}</max_angle></horizontal>{rows}</scan>
<range><min>0.05</min><max>20</max></range></ray>{more}"""
ROWS = """<vertical><samples>8</samples><min_angle>-0.4</min_angle><max_angle>0.3</max_angle>
</vertical>"""
QUIET = SimulatorConfig(lidar=LidarConfig(noise=0.0), imu=ImuConfig(0.0, 0.0, 0.0, 0.0, 0.0))


def _scan_tag(samples: int = 90, half: float = 2.5, rows: str = "", more: str = "") -> str:
    return SCAN.format(samples=samples, half=half, rows=rows, more=more)


def _further(sim: Simulation, name: str) -> SensorSettings:
    return next(s for s in sim.robot.model.settings.further if s.name == name)


def _T_world(sim: Simulation, T_base: Pose3) -> Pose3:
    truth, base = sim.robot.truth(), sim.robot.model.urdf.T_root("base_link")
    where = (truth.pose.x, truth.pose.y, truth.z)
    return Pose3.from_rpy(where, (truth.roll, truth.pitch, truth.pose.theta)) @ base @ T_base


@pytest.mark.parametrize("seed", range(4))
def test_each_lidar_sees_from_where_it_is(tmp_path: Path, seed: int) -> None:
    maker = RobotMaker(tmp_path, seed)
    for name in ("a", "b", "c"):
        maker.add("ray", name, _scan_tag(), maker.random_pose(True), maker.random_pose(True))
    sim = simulator(ROOM, QUIET, robot=maker.write())
    last = run(sim, 0.5, Velocity(0.2, yaw_rate=0.3))
    readings = {s.name: sim.robot.sense(s, sim.time) for s in sim.robot.model.settings.further}
    assert last.scan is not None
    for mounted in maker.mounted:
        scan = last.scan if mounted.name == "a" else readings[mounted.name]
        assert isinstance(scan, Scan)
        ends = np.column_stack((np.cos(scan.angles), np.sin(scan.angles)))
        ends = np.column_stack((ends * scan.ranges[:, None], np.zeros(len(ends))))
        walls = _T_world(sim, mounted.T_base).apply(ends[np.isfinite(scan.ranges)])
        inner = np.abs(np.abs(walls[:, :2]).max(axis=1) - 4.9)
        assert np.median(inner) < 2e-3
        given = mounted.T_base
        assert scan.T_base_sensor.x == pytest.approx(given.position[0], abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_points_of_a_lidar_of_several_rows_lie_on_walls_and_floor(
    tmp_path: Path, seed: int
) -> None:
    maker = RobotMaker(tmp_path, seed)
    more = "<plugin name='p' filename='libgazebo_ros_velodyne_laser.so'>"
    more += "<topicName>/velodyne</topicName></plugin>"
    pose = maker.random_pose(True)
    maker.add("gpu_ray", "top", _scan_tag(120, 3.1, ROWS, more), pose, maker.random_pose(True))
    sim = simulator(ROOM, QUIET, robot=maker.write())
    assert first(sim.robot.model, LidarSettings).topic == "scan"
    run(sim, 0.3)
    top = _further(sim, "top")
    cloud = sim.robot.sense(top, sim.time)
    assert isinstance(cloud, Cloud)
    assert (type(top), top.topic) == (CloudSettings, "/velodyne")
    points = _T_world(sim, maker.mounted[0].T_base).apply(cloud.points.astype(np.float64))
    on_floor = np.abs(points[:, 2]) < 2e-3
    on_wall = np.abs(np.abs(points[:, :2]).max(axis=1) - 4.9) < 2e-3
    assert on_floor.any()
    assert on_wall.any()
    assert (on_floor | on_wall).mean() > 0.75  # the rest lie on the boxes
    tilts = np.arctan2(cloud.points[:, 2], np.hypot(cloud.points[:, 0], cloud.points[:, 1]))
    assert tilts == pytest.approx(np.linspace(-0.4, 0.3, 8)[cloud.rows], abs=1e-5)


MOUNTS = [
    (0.0, 0.0, 0.0),
    (math.pi, 0.0, 0.0),
    (0.0, math.pi, 0.0),
    (math.pi / 2, 0.0, 0.0),
    (0.0, -1.5, 0.4),
    (0.7, -0.6, 2.0),
]


@pytest.mark.parametrize("rpy", MOUNTS)
@pytest.mark.parametrize(("first", "rate"), [(True, 10), (False, 10), (False, 200)])
def test_orientation_of_an_imu_at_any_mount_is_that_of_its_frame(
    tmp_path: Path, rpy: tuple[float, float, float], first: bool, rate: float
) -> None:
    """REP 145: turned back by its mount, it is the robot's orientation."""
    maker = RobotMaker(tmp_path)
    if not first:
        maker.add("imu", "other")
    T_mount = Pose3.from_rpy((0.1, 0.0, 0.1), rpy)
    maker.add("imu", "tilted", T_link=T_mount, rate=rate)
    sim = simulator(EMPTY, QUIET, robot=maker.write())
    for _ in range(100):
        last = sim.drive(Velocity(yaw_rate=0.8))
        reading = last.imu if first else sim.robot.sense(_further(sim, "tilted"), sim.time)
    assert isinstance(reading, ImuReading)
    given = reading.orientation
    body = given @ Pose3.from_rpy((0.0, 0.0, 0.0), rpy).inverse()
    assert last.truth.pose.theta > 0.5
    assert body.rpy()[2] == pytest.approx(last.truth.pose.theta, abs=0.02)
    assert body.rpy()[:2] == pytest.approx((0.0, 0.0), abs=0.01)
    up = given.rotation().T @ (0.0, 0.0, 1.0)
    assert reading.angular_velocity == pytest.approx(last.truth.w * up, abs=0.05)


@pytest.mark.parametrize("seed", range(5))
def test_a_reading_of_an_imu_is_what_its_frame_feels_with_errors(seed: int) -> None:
    rng, dt, tilt = np.random.default_rng(seed), 0.1, 0.3
    frame, robot = (
        Pose3.from_rpy((0.0, 0.0, 0.0), tuple(rng.uniform(-1.5, 1.5, 3).tolist())) for _ in range(2)
    )
    motion, last, gravity, draws = (rng.standard_normal(n) for n in (6, 6, 3, 14))
    errors, headings, felt = rng.random((4, 6)), np.array([0.4, -0.2]), np.empty(6)
    errors[3, 0] = 20.0  # forgotten within the time
    noise = np.concatenate((draws[3:6], draws[9:12]))
    bias = errors[0] * np.maximum(0.0, 1.0 - dt * errors[3])
    bias += errors[1] * math.sqrt(dt) * np.concatenate((draws[:3], draws[6:9]))
    own, facing, level = frame.rotation(), robot.rotation(), np.array(frame.quaternion)
    turned = imu._read(
        *(own.ravel(), level, facing.ravel(), motion, last, dt, gravity, draws),
        *(errors.copy(), tilt, headings, felt),
    )
    off = bias + errors[2] * noise
    np.testing.assert_allclose(felt[:3], own.T @ motion[:3] + off[:3])
    np.testing.assert_allclose(felt[3:], own.T @ ((motion[3:] - last[3:]) / dt - gravity) + off[3:])
    yaw = robot.rpy()[2]
    believed = 0.4 + yaw + 0.2 + dt * own[2] @ off[:3]
    assert headings == pytest.approx([believed, yaw])
    tilted = Pose3.from_rpy((0.0, 0.0, 0.0), (tilt * draws[-2], tilt * draws[-1], believed))
    level_at = Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, -yaw)) @ frame
    expected = (tilted @ level_at).rotation()
    np.testing.assert_allclose(Pose3(quaternion=turned).rotation(), expected, atol=1e-9)


def test_heading_of_an_imu_drifts_with_its_gyros_and_survives_a_kidnapping(tmp_path: Path) -> None:
    maker = RobotMaker(tmp_path)
    noise = "<x><noise><stddev>0.2</stddev></noise></x>"
    inside = f"<imu><angular_velocity>{noise}</angular_velocity></imu>"
    maker.add("imu", "shaky", inside, Pose3.from_rpy((0.0, 0.0, 0.0), (math.pi, 0.0, 0.0)))
    sim = simulator(EMPTY, robot=maker.write())
    before = run(sim, 5.0).imu
    sim.robot.set_pose(SE2(3.0, 0.0, 2.0))
    after = run(sim, 0.1).imu
    assert before is not None
    assert after is not None
    assert before.angular_variance == pytest.approx(0.04)
    assert 0.001 < abs(before.rpy[2]) < 0.5
    assert after.rpy[2] == pytest.approx(before.rpy[2], abs=0.1)


def test_a_sensor_goes_on_with_its_noise_where_something_is_spawned(tmp_path: Path) -> None:
    maker = RobotMaker(tmp_path)
    for name in ("first", "other"):
        maker.add("imu", name)
    sim = simulator(EMPTY, robot=maker.write())
    device = sim.robot.device(_further(sim, "other"))
    model, box = sim.stage.scene.model, Part(Shape(Kind.BOX, (0.1, 0.1, 0.1)))
    sim.stage.spawn(Entity("box", (box,), start=Pose3((5.0, 0.0, 0.0)), spawned=True))
    assert sim.stage.scene.model is not model
    assert sim.robot.device(_further(sim, "other")) is device
    sim.reset()
    assert sim.robot.device(_further(sim, "other")) is not device


def test_imu_starts_with_the_bias_of_its_file(tmp_path: Path) -> None:
    maker = RobotMaker(tmp_path)
    noise = (
        "<noise><stddev>0</stddev><bias_mean>{}</bias_mean><bias_stddev>{}</bias_stddev></noise>"
    )
    gyro = f"<angular_velocity><x>{noise.format(0.05, 0)}</x></angular_velocity>"
    accel = f"<linear_acceleration><x>{noise.format(0.3, 0.05)}</x></linear_acceleration>"
    maker.add("imu", "biased", f"<imu>{gyro}{accel}</imu>")
    sim = simulator(EMPTY, robot=maker.write(), config=QUIET)
    run(sim, 1.0)  # it stands
    reading = run(sim, 0.1).imu
    assert reading is not None
    assert np.abs(reading.angular_velocity) == pytest.approx([0.05] * 3, abs=1e-3)
    off = reading.linear_acceleration - (0.0, 0.0, 9.81)
    assert np.abs(off) == pytest.approx([0.3] * 3, abs=0.2)
    assert len({round(value, 3) for value in off}) == 3


def test_positions_on_earth_are_those_of_the_world(tmp_path: Path) -> None:
    maker = RobotMaker(tmp_path)
    maker.add("navsat", "gps", T_link=Pose3((0.0, 0.0, 0.5)))
    maker.add("magnetometer", "compass", T_link=Pose3.from_rpy((0, 0, 0), (0.0, 0.0, math.pi / 2)))
    maker.add("altimeter", "height")
    world = tmp_path / "w.world"
    world.write_text(
        """<sdf version='1.7'><world name='w'><magnetic_field>1e-5 2e-5 -4e-5</magnetic_field>
    <spherical_coordinates><latitude_deg>47.5</latitude_deg><longitude_deg>-351.75</longitude_deg>
    <elevation>400</elevation><heading_deg>90</heading_deg></spherical_coordinates>
    </world></sdf>""",
        encoding="utf-8",
    )
    sim = simulator(world, robot=maker.write())
    assert not [note for note in sim.notes if "sensor" in note]
    for _ in range(50):
        sim.drive(Velocity(0.5))
    fix, field = (sim.robot.sense(_further(sim, name), sim.time) for name in ("gps", "compass"))
    assert isinstance(fix, Fix)
    point, x = fix.position, sim.robot.truth().pose.x  # the world's x points north there
    assert point.latitude_deg == pytest.approx(47.5 + x / 111_177.0, abs=2e-8)
    assert point.longitude_deg == pytest.approx(8.25, abs=1e-7)
    above = _T_world(sim, maker.mounted[0].T_base).position[2]
    assert point.altitude == pytest.approx(400.0 + above, abs=1e-5)
    assert field == pytest.approx((2e-5, -1e-5, -4e-5), abs=1e-6)
    height = sim.robot.sense(_further(sim, "height"), sim.time)
    assert (height.height, height.start) == (0.0, pytest.approx(0.0797, abs=1e-3))
    assert height.speed == pytest.approx(0.0, abs=1e-3)


def test_bumper_feels_what_its_own_link_touches(tmp_path: Path) -> None:
    maker = RobotMaker(tmp_path)
    path = maker.write(bare=False)
    text = path.read_text(encoding="utf-8")
    bumpers = "".join(
        f"<gazebo reference='{link}'><sensor name='{link}_bumper' type='contact'><plugin>"
        f"<frame_name>{frame}</frame_name></plugin></sensor></gazebo>"
        for link, frame in (("base_link", "base_link"), ("front_left_wheel", "world"))
    )
    path.write_text(text.replace("</robot>", bumpers + "</robot>"), encoding="utf-8")
    sim = simulator(ROOM, robot=path)
    pressed = {}
    for when in ("free", "at the wall"):
        run(sim, 0.5 if when == "free" else 12.0, Velocity(0.0 if when == "free" else 0.4))
        bumpers_there = [
            s for s in sim.robot.model.settings.further if isinstance(s, BumperSettings)
        ]
        pressed[when] = [sim.robot.sense(s, sim.time) for s in bumpers_there]
    assert [[bool(each) for each in found] for found in pressed.values()] == [
        [False, True],
        [True, True],
    ]
    (wheel,), (bumper,) = pressed["free"][1], pressed["at the wall"][0]
    assert wheel.own == "arjuna::front_left_wheel::front_left_wheel_collision"
    assert bumper.own == "arjuna::base_link::base_link_collision"
    assert wheel.other.startswith("ground_plane::")
    assert wheel.positions[:, 2] == pytest.approx(0.0, abs=2e-3)  # the world's ground
    assert wheel.normals @ (0.0, 0.0, 1.0) == pytest.approx(1.0)
    quarter = sim.robot.model.urdf.mass * 9.81 / 4.0
    assert wheel.forces.sum(axis=0)[2] == pytest.approx(quarter, rel=0.2)
    ahead = bumper.positions[:, 0]
    assert 0.1 < ahead.min() <= ahead.max() < 0.3  # in the bumper's frame, not the world's
    assert bumper.forces.sum(axis=0)[0] < -1.0
    assert (bumper.depths > 0.0).any()


def _with_battery(folder: Path, charge: float, more: str) -> Path:
    path = RobotMaker(folder).write()
    battery = (
        "<gazebo><plugin filename='gz-sim-linearbatteryplugin-system'"
        " name='gz::sim::systems::LinearBatteryPlugin'><battery_name>pack</battery_name>"
        "<voltage>12</voltage><open_circuit_voltage_constant_coef>12.5"
        "</open_circuit_voltage_constant_coef><open_circuit_voltage_linear_coef>-3"
        f"</open_circuit_voltage_linear_coef><initial_charge>{charge}</initial_charge><capacity>2"
        "</capacity><resistance>0.1</resistance><smooth_current_tau>2</smooth_current_tau>"
        f"<power_load>110</power_load>{more}</plugin></gazebo>"
    )
    text = path.read_text(encoding="utf-8").replace("</robot>", f"{battery}</robot>")
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("more", ["", "<start_draining>true</start_draining>"])
def test_a_battery_drains_as_its_load_draws(tmp_path: Path, more: str) -> None:
    path = _with_battery(tmp_path, 1.0, more)
    sim = simulator(EMPTY, robot=path)
    sensor = _further(sim, "pack")
    assert sensor.topic == "/model/arjuna/battery/pack/state"
    assert not [note for note in sim.notes if "attery" in note]
    read = [sim.robot.sense(sensor, now) for now in (0.0, 60.0, 120.0)]
    assert read[0] == (12.0, 0.0, 1.0, 0.5, Supply.DRAINS)
    # Some 11 V without and 10 V with the load: 11 A for 2 min take a third of an Ah.
    assert read[2].current == pytest.approx(110.0 / read[2].voltage, rel=0.01)
    assert read[2].charge == pytest.approx(1.0 - 2.0 / 60.0 * read[1].current, abs=0.02)
    assert read[2].voltage == pytest.approx(
        12.5 - 3.0 * (1.0 - read[2].percentage) - 0.1 * read[2].current
    )
    assert sim.robot.sense(sensor, 3600.0).charge == 0.0
    assert sim.robot.sense(sensor, 0.0) == read[0]  # the simulation began again


def test_a_robot_stops_when_its_battery_is_empty(tmp_path: Path) -> None:
    more = "<enable_recharge>true</enable_recharge>"
    sim = simulator(EMPTY, robot=_with_battery(tmp_path, 0.002, more))
    notes = [note.partition(": ")[2] for note in sim.notes if "attery" in note]
    assert notes == ["is not recharged: <charging_time> must be above 0"]
    assert run(sim, 1.0, Velocity(0.3)).truth.v == pytest.approx(0.3, rel=0.1)
    seen = run(sim, 3.0, Velocity(0.3))
    assert seen.truth.v == pytest.approx(0.0, abs=1e-3)
    sim.reset()
    assert run(sim, 1.0, Velocity(0.3)).truth.v == pytest.approx(0.3, rel=0.1)


@pytest.mark.parametrize("waits", [True, False])
def test_a_battery_may_wait_for_the_first_motion(tmp_path: Path, waits: bool) -> None:
    more = f"<start_draining>{str(not waits).lower()}</start_draining>"
    more += "<start_on_motion>true</start_on_motion>"
    sim = simulator(EMPTY, robot=_with_battery(tmp_path, 1.0, more))
    assert not [note for note in sim.notes if "attery" in note]
    run(sim, 2.0)
    assert (sim.robot.sense(_further(sim, "pack"), sim.time).charge == 1.0) is waits
    run(sim, 2.0, Velocity(0.3))
    drained = sim.robot.sense(_further(sim, "pack"), sim.time).charge
    assert drained < 1.0
    run(sim, 2.0, Velocity())  # and goes on at rest
    assert sim.robot.sense(_further(sim, "pack"), sim.time).charge < drained - 1e-3


def test_a_battery_is_filled_to_nine_tenths_within_its_charging_time(tmp_path: Path) -> None:
    more = "<enable_recharge>true</enable_recharge><charging_time>0.05</charging_time>"
    path = _with_battery(tmp_path, 0.002, more)
    sim = simulator(EMPTY, robot=path)
    sensor = _further(sim, "pack")
    assert not [note for note in sim.notes if "attery" in note]
    assert run(sim, 4.0, Velocity(0.3)).truth.v == pytest.approx(0.0, abs=1e-3)
    battery = sim.robot.device(sensor)
    battery.charges = True
    seen = run(sim, 10.0, Velocity(0.3))
    assert seen.truth.v == pytest.approx(0.3, rel=0.1), "40 A fill it, 9 A are drawn"
    reading = sim.robot.sense(sensor, sim.time)
    assert (reading.supply, reading.current) == (Supply.CHARGES, pytest.approx(-31.0, abs=0.5))
    battery.drains = False
    for now in np.arange(sim.time, sim.time + 250.0, 1.0):
        reading = sim.robot.sense(sensor, now)
    assert reading.percentage == pytest.approx(0.9, abs=0.03)
    battery.charges = False
    assert sim.robot.sense(sensor, now + 1.0).supply in (Supply.FULL, Supply.DRAINS)


def test_a_battery_drains_when_topics_say_so(tmp_path: Path) -> None:
    more = "<power_draining_topic>/go</power_draining_topic><power_draining_topic>/on"
    more += "</power_draining_topic><stop_power_draining_topic>/stop</stop_power_draining_topic>"
    sim = simulator(EMPTY, robot=_with_battery(tmp_path, 1.0, more))
    sensor = _further(sim, "pack")
    assert isinstance(sensor, BatterySettings)
    assert (sensor.draining_topics, sensor.resting_topics) == (("/go", "/on"), ("/stop",))
    run(sim, 1.0)
    assert sim.robot.sense(sensor, sim.time).supply is Supply.RESTS
    sim.robot.device(sensor).drains = True
    run(sim, 1.0)
    drained = sim.robot.sense(sensor, sim.time)
    assert (drained.supply, drained.charge < 1.0) == (Supply.DRAINS, True)
    sim.robot.device(sensor).drains = False
    run(sim, 1.0)
    assert sim.robot.sense(sensor, sim.time).charge == drained.charge


def test_readings_are_the_same_each_time_whatever_else_is_read(tmp_path: Path) -> None:
    maker = RobotMaker(tmp_path, 3)
    noise = "<noise><stddev>0.02</stddev></noise>"
    for name in ("a", "b", "c"):
        maker.add("ray", name, _scan_tag().replace("</ray>", f"{noise}</ray>"))
    path = maker.write()

    def ranges(names: tuple[str, ...]) -> bytes:
        sim = simulator(ROOM, robot=path)
        run(sim, 0.3)
        read = {name: sim.robot.sense(_further(sim, name), sim.time) for name in names}
        assert isinstance(read["c"], Scan)
        return read["c"].ranges.tobytes()

    assert ranges(("b", "c")) == ranges(("c",))
