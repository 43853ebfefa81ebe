"""Drives and the inputs of the simulator."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import RobotError
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.driven_robot import Observation
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.inputs import axle_of, named_robot, names_of, turning_radius_of
from arjuna_sim.model.settings import DriveKind
from arjuna_sim.simulation import Simulation, solo
from tests.sim import drive_cases as cases
from tests.sim.builders import ROBOT, run, simulator, texts
from tests.sim.drive_cases import car
from tests.sim.generated import level
from tests.sim.robot_files.tags import plugin, sides

SIDEWAYS = {
    "mecanum": (cases.mecanum(), DriveKind.MECANUM),
    "mecanum, controlled": (cases.mecanum(controlled=True), DriveKind.MECANUM),
    "planar": (cases.planar(), DriveKind.MECANUM),
    "planar on two wheels": (
        cases.planar_on(
            cases.Wheel("left_wheel", 0.0, 0.14), cases.Wheel("right_wheel", 0.0, -0.14)
        ),
        DriveKind.MECANUM,
    ),
    "planar on forks": (cases.planar_on_forks(), DriveKind.MECANUM),
    "planar without wheels": (cases.planar_on(), DriveKind.MECANUM),
    "3 omni wheels": (cases.omni(3), DriveKind.OMNI),
    "3 omni wheels, classic": (cases.omni(3, classic=True), DriveKind.OMNI),
    "omni wheels of rollers": (cases.on_real_rollers(omni=True), DriveKind.OMNI),
    "mecanum wheels of rollers": (cases.on_real_rollers(omni=False), DriveKind.MECANUM),
    "4 omni wheels, controlled": (cases.omni(4, controlled=True), DriveKind.OMNI),
}
STEERED = {
    "car, gz": cases.car("gz"),
    "car, all wheels drive": cases.car("gz", "all"),
    "car, classic": cases.car("classic"),
    "car, controlled": cases.car("control"),
    "car, of a maker's plugin": cases.prius(),
    "car without a plugin": cases.car(""),
    "car of endless steering": cases.car("", steer="continuous"),
    "car, whose wheels mimic": cases.car_led(virtual=False),
    "car, whose wheels mimic virtual ones": cases.car_led(virtual=True),
    "all wheels steer": cases.steered_all_round("gz-sim-fourwids-drive-system"),
    "tricycle": cases.tricycle(),
    "tricycle, classic": cases.tricycle(classic=True),
}


TRACKED = {
    "boxes": cases.tracked(),
    "Gazebo Classic's": cases.tracked(classic=True),
    "round ends": cases.tracked(ends=True),
    "flippers": cases.tracked(flippers=True),
    "low flippers": cases.tracked(low=True),
    "left on the right": cases.tracked(swapped=True),
}


def _legs(robot: Path, *legs: tuple[Velocity, float]) -> Iterator[Observation]:
    """Yield what is seen after each leg, driven from rest to rest, of a robot that parks."""
    sim = simulator(robot=robot)
    parked = run(sim, 1.0).truth.pose
    assert parked.distance(run(sim, 2.0).truth.pose) < 5e-6
    for command, seconds in legs:
        sim.reset()
        run(sim, seconds, command)
        yield run(sim, 1.0, Velocity())


def _driven(robot: cases.Robot, folder: Path, command: Velocity, seconds: float) -> Observation:
    """Drive from rest to rest."""
    return next(_legs(robot.write(folder), (command, seconds)))


def _check(seen: Observation, wanted: SE2, direction: float) -> None:
    """Check the true pose and the odometry's."""
    for pose, tolerance in ((seen.truth.pose, 0.03), (seen.odometry.T_odom_base, 0.03)):
        assert math.hypot(pose.x - wanted.x, pose.y - wanted.y) < tolerance * max(direction, 0.5)
        assert math.degrees(abs(wrap(pose.theta - wanted.theta))) < 5.0


@pytest.mark.parametrize("name", SIDEWAYS)
def test_robot_moves_in_any_direction(tmp_path: Path, name: str) -> None:
    """Ahead, sideways, askew and about; and on a circle, as it faces outward."""
    robot, kind = SIDEWAYS[name]
    path = robot.write(tmp_path)
    assert load_robot(path, SearchPath()).drive.kind is kind
    legs = (
        (Velocity(0.4), 2.5),
        (Velocity(y=0.4), 2.5),
        (Velocity(0.3, y=-0.3), 2.0),
        (Velocity(yaw_rate=0.8), math.pi / 2 / 0.8),
        (Velocity(0.1, y=0.3, yaw_rate=0.5), math.pi / 0.5),
    )
    for (command, time), seen in zip(legs, _legs(path, *legs), strict=True):
        wanted = SE2.exp(np.array([command.x, command.y, command.yaw_rate]) * time)
        _check(seen, wanted, time * math.hypot(command.x, command.y))


def test_motors_pull_the_masses_that_a_file_leaves_out(tmp_path: Path) -> None:
    """Gazebo's own example of a box of 1 m, 500 kg by its shape, which moved at 0.6 m/s at most."""
    path = tmp_path / "box.sdf"
    drive = "<plugin name='p' filename='libgazebo_ros_planar_move.so'/>"
    shape = "<geometry><box><size>1 1 1</size></box></geometry>"
    link = f"<link name='link'><collision name='c'>{shape}</collision></link>"
    path.write_text(f"<sdf version='1.6'><model name='box'>{link}{drive}</model></sdf>", "utf-8")
    seen = run(simulator(robot=path), 2.0, Velocity(1.0))
    assert seen.truth.v == pytest.approx(1.0, rel=0.02)


@pytest.mark.parametrize("name", STEERED)
def test_car_follows_an_arc(tmp_path: Path, name: str) -> None:
    """The rear axle does, backward as well, by the curvature that was asked for [1/m]."""
    path = STEERED[name].write(tmp_path)
    assert load_robot(path, SearchPath()).drive.kind is DriveKind.STEERED
    axle = SE2({"tric": -0.12, "all ": 0.01}.get(name[:4], -0.16), 0.0, 0.0)
    bends = ((0.4, 0.8), (-0.4, 0.0), (-0.4, -1.2))
    legs = [(Velocity(speed, yaw_rate=speed * bend), 2.5) for speed, bend in bends]
    for (speed, bend), seen in zip(bends, _legs(path, *legs), strict=True):
        arc = SE2.exp(2.5 * speed * np.array([1.0, 0.0, bend]))
        _check(seen, axle @ arc @ axle.inverse(), 1.0)


def test_plugins_of_two_axles_drive_all_wheels_that_obey_one_topic(tmp_path: Path) -> None:
    seen = _driven(cases.two_axles(), tmp_path, Velocity(yaw_rate=0.8), math.pi / 2 / 0.8)
    _check(seen, SE2(0.0, 0.0, math.pi / 2), 1.0)  # about the middle of both axles
    robot = load_robot(tmp_path / "made.urdf", SearchPath())
    assert len(robot.drive.wheels) == 4
    assert not any("second drive" in note for note in texts(robot.notes))
    path = cases.two_axles("<topic>lifted</topic>").write(tmp_path)
    robot = load_robot(path, SearchPath())
    assert "plugin 'drive': a second drive is not simulated" in texts(robot.notes)
    assert len(robot.drive.wheels) == 2


SWERVE = {
    "plugin": cases.steered_all_round("gz-sim-swerve-drive-system", 3.1),
    "classic": cases.steered_all_round("libgazebo_ros_swerve_drive.so", steering="continuous"),
    "controller": cases.steered_all_round("control", 1.57),
    "endless": cases.steered_all_round("", steering="continuous"),
}


ALL = Velocity(0.2, y=0.2, yaw_rate=0.4)


@pytest.mark.parametrize(
    ("name", "command"),
    [
        *((name, ALL) for name in SWERVE),
        *(("plugin", each) for each in (Velocity(-0.4), Velocity(y=0.4))),
        *(("endless", each) for each in (Velocity(0.3, y=-0.3), Velocity(yaw_rate=0.8))),
    ],
    ids=str,
)
def test_wheels_that_each_steer_move_in_any_direction(
    tmp_path: Path, name: str, command: Velocity
) -> None:
    robot = load_robot(SWERVE[name].write(tmp_path), SearchPath())
    assert robot.drive.kind is DriveKind.SWERVE
    assert not any("not simulated: " in note for note in texts(robot.notes))
    assert (turning_radius_of(robot), axle_of(robot, "")) == (0.0, 0.0)
    sim = simulator(robot=tmp_path / "made.urdf")
    start = run(sim, 1.0, command)  # its wheels point there by then
    for _ in range(2):  # and the other way about, for which they roll backwards
        seen = run(sim, 1.5, command)
        moved = start.truth.pose.inverse() @ seen.truth.pose
        said = start.odometry.T_odom_base.inverse() @ seen.odometry.T_odom_base
        twist = 1.5 * command.x, 1.5 * command.y, 1.5 * command.yaw_rate
        for pose in (moved, said):
            off = SE2.exp(twist).inverse() @ pose
            assert math.hypot(off.x, off.y) < 0.03
            assert abs(off.theta) < math.radians(4.0)
        command = Velocity(-command.x, y=-command.y, yaw_rate=-command.yaw_rate)
        start = run(sim, 0.2, command)


def test_tricycles_driven_wheel_is_the_one_that_its_plugin_names(tmp_path: Path) -> None:
    robot = load_robot(cases.tricycle(classic=True).write(tmp_path), SearchPath())
    assert robot.drive.wheels == ("front_wheel_joint",)
    assert robot.drive.free == ("left_wheel_joint", "right_wheel_joint")
    assert texts(robot.notes) == ()


def test_virtual_wheels_turn_with_those_that_mimic_them(tmp_path: Path) -> None:
    sim = simulator(robot=cases.car_led(virtual=True).write(tmp_path))
    seen = run(sim, 2.0, Velocity(0.4, yaw_rate=0.3))
    joints = dict(zip(seen.joints.names, seen.joints.positions, strict=True))
    left = joints["rear_left_wheel_joint"]
    assert joints["virtual_wheel_joint"] == pytest.approx(left, abs=0.05)
    assert left < joints["rear_right_wheel_joint"] - 0.5  # each at its own speed
    assert joints["virtual_steer_joint"] == pytest.approx(
        joints["front_left_wheel_steer_joint"], abs=0.01
    )


def test_car_steers_no_farther_than_it_can(tmp_path: Path) -> None:
    sim = simulator(robot=cases.car("gz").write(tmp_path))
    seen = run(sim, 4.0, Velocity(0.3, yaw_rate=2.0))
    joints = dict(zip(seen.joints.names, seen.joints.positions, strict=True))
    steered = [joints[f"front_{side}_wheel_steer_joint"] for side in ("left", "right")]
    assert max(steered) == pytest.approx(0.5, abs=0.02)  # the inner wheel, by the plugin's limit
    assert math.tan(steered[0]) > math.tan(steered[1]) > 0.3
    assert seen.truth.v == pytest.approx(0.3, rel=0.1)
    assert seen.truth.w < 0.3 * 1.4


def test_car_does_not_turn_on_the_spot(tmp_path: Path) -> None:
    seen = _driven(cases.car("gz"), tmp_path, Velocity(yaw_rate=1.0), 2.0)
    _check(seen, SE2(), 0.0)


@pytest.mark.parametrize("name", TRACKED)
def test_tracks_drive_as_a_skid_steer(tmp_path: Path, name: str) -> None:
    legs = (Velocity(0.4), 2.5), (Velocity(-0.4), 2.5), (Velocity(yaw_rate=0.8), math.pi / 2 / 0.8)
    wanted = SE2(1.0), SE2(-1.0), SE2(0.0, 0.0, math.pi / 2)
    for seen, pose in zip(_legs(TRACKED[name].write(tmp_path), *legs), wanted, strict=True):
        # [m] With flippers in front it turns about a point before its middle.
        _check(seen, pose, 6.0 if "flippers" in name else abs(pose.x))


def test_wheels_that_no_file_names_are_in_no_message(tmp_path: Path) -> None:
    robot = load_robot(cases.tracked(flippers=True).write(tmp_path), SearchPath())
    (raised, *_), notes = texts(robot.notes), robot.settings
    assert raised == "link 'left_flipper': is off the ground: its track stands"
    assert not any("wheel" in name for name in notes.reported)
    assert not robot.urdf.links["left_track"].collisions
    assert robot.urdf.links["left_flipper"].collisions


@pytest.mark.parametrize(("said", "notes"), [(0.3, 0), (0.31, 0), (0.5, 1)])
def test_tracks_are_as_far_apart_as_the_file_says(tmp_path: Path, said: float, notes: int) -> None:
    robot = cases.tracked()
    tag = f"<tracks_separation>{said}</tracks_separation><left_track>"
    text = robot.extra.replace("<left_track>", tag, 1)
    found = load_robot(replace(robot, extra=text).write(tmp_path), SearchPath())
    plain = load_robot(robot.write(tmp_path), SearchPath())
    assert found.drive == replace(plain.drive, separation=said)
    noted = "tracks_separation is 0.5, but the tracks are 0.3 apart: it drives by that"
    assert [noted in note for note in texts(found.notes)] == [True] * notes


def test_tracks_of_uneven_ends_run_at_one_speed(tmp_path: Path) -> None:
    """What is off the ground stays solid; wheels are as small as the smallest that meets it."""
    robot = load_robot(cases.tracked(low=True).write(tmp_path), SearchPath())
    assert not texts(robot.notes)
    assert robot.drive.radius == robot.drive.effective_radius == 0.048
    [small] = robot.urdf.links["left_flipper"].collisions
    assert small.shape.size[0] == 0.02
    assert robot.drive.separation == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("<left_track><link>left_track", "<left_track><link>lost", "track 'lost' is no link"),
        ("<left_track><link>left_track</link></left_track>", "", "a side has no track"),
    ],
)
def test_tracks_that_do_not_exist_are_refused(
    tmp_path: Path, old: str, new: str, problem: str
) -> None:
    path = cases.tracked().write(tmp_path)
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(RobotError, match=problem):
        load_robot(path, SearchPath())


@pytest.mark.parametrize(
    ("robot", "commands", "seconds", "wanted"),
    [
        (cases.own_control(), {"velocities": [8.0] * 4}, 2.0, SE2(0.96, 0.0, 0.0)),
        (
            cases.own_control(rollers=True),
            {"velocities": [-8.0, 8.0, 8.0, -8.0]},
            2.0,
            SE2(0.0, 0.96, 0.0),
        ),
        (
            cases.own_control(steered=True),
            {"velocities": [8.0] * 4, "angles": [math.pi / 4] * 4},
            2.5,
            SE2(0.85, 0.8, 0.0),  # it starts before the wheels have turned
        ),
    ],
    ids=["ahead", "sideways on rollers", "askew on steered wheels"],
)
def test_wheels_obey_controllers_of_their_joints(
    tmp_path: Path,
    robot: cases.Robot,
    commands: dict[str, list[float]],
    seconds: float,
    wanted: SE2,
) -> None:
    """As a node of the robot's maker commands them; until it does, cmd_vel drives."""
    sim = simulator(robot=robot.write(tmp_path))
    ahead = run(sim, 1.0, Velocity(0.4))
    assert ahead.truth.pose.x == pytest.approx(0.4, abs=0.05)
    start = run(sim, 0.5, Velocity()).truth.pose
    for name, values in commands.items():
        sim.robot.controllers.command(name, values)
    moved = start.inverse() @ run(sim, seconds).truth.pose
    assert math.hypot(moved.x - wanted.x, moved.y - wanted.y) < 0.1
    assert abs(moved.theta) < 0.05
    sim.robot.controllers.command("velocities", [0.0])
    assert run(sim, 0.5, Velocity(0.4)).truth.v == pytest.approx(0.0, abs=0.01)
    sim.reset()
    assert run(sim, 1.0, Velocity(0.4)).truth.pose.x == pytest.approx(0.4, abs=0.05)


def test_wheels_are_pushed_by_torques_and_roll_on_without(tmp_path: Path) -> None:
    """As in Gazebo, where a plug-in's forces alone turn the wheels: cmd_vel does not."""
    force = "<joint_name>{}_joint</joint_name><topic>/other</topic>"
    pushed = (
        cases.plugin("gz-sim-apply-joint-force-system", force.format(wheel.name))
        for wheel in cases.four()
    )
    sim = simulator(robot=cases.Robot(cases.four(), "".join(pushed)).write(tmp_path))
    controllers = sim.robot.controllers
    topics = {settings.topic for settings, _ in controllers.states}
    assert "/model/made/joint/front_left_wheel_joint/cmd_force" in topics
    assert run(sim, 0.5, Velocity(0.4)).truth.v == pytest.approx(0.0, abs=0.01)
    for settings, _ in controllers.states:
        controllers.command(settings.name, [0.1])
    radius, mass = 0.06, sim.robot.model.urdf.mass
    speed = run(sim, 1.0).truth.v
    assert speed == pytest.approx(4 * 0.1 / radius / mass, rel=0.2)  # the wheels turn, too
    for settings, _ in controllers.states:
        controllers.command(settings.name, [0.0])
    assert run(sim, 0.5).truth.v == pytest.approx(speed, rel=0.05)
    controllers.switch([], [settings.name for settings, _ in controllers.states], False)
    assert run(sim, 1.0, Velocity(0.4)).truth.v == pytest.approx(0.4, abs=0.02)


def test_limits_of_tracks_and_of_a_tracked_vehicle_hold(tmp_path: Path) -> None:
    """Each part of the velocity has its own; each track has that of its controller."""
    parts = "<{0}_velocity><max_velocity>{1}</max_velocity></{0}_velocity>"
    of_vehicle = parts.format("linear", 0.3) + parts.format("angular", 0.5)
    robot = cases.tracked()
    extra = robot.extra.replace("</plugin>", "<max_velocity>0.2</max_velocity></plugin>", 1)
    driven = _driven(replace(robot, extra=extra), tmp_path, Velocity(0.8), 2.0)
    assert driven.truth.pose.x == pytest.approx(0.4, abs=0.03)
    for limits, way in (("", 0.4), ("<min_acceleration>-0.1</min_acceleration>", 0.4 + 0.35)):
        slow = f"<max_acceleration>0.2</max_acceleration>{limits}</plugin>"
        slower = replace(robot, extra=robot.extra.replace("</plugin>", slow, 1))
        driven = _driven(slower, tmp_path, Velocity(0.8), 2.0)
        assert driven.truth.pose.x == pytest.approx(way, abs=0.05)  # and 1 s of braking, or none
    extra = robot.extra.replace("<left_track>", f"{of_vehicle}<left_track>")
    driven = _driven(replace(robot, extra=extra), tmp_path, Velocity(0.8), 2.0)
    assert driven.truth.pose.x == pytest.approx(0.6, abs=0.04)
    driven = _driven(replace(robot, extra=extra), tmp_path, Velocity(yaw_rate=1.0), 2.0)
    assert driven.truth.pose.theta == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("name", ["mecanum", "car, gz", "tricycle"])
def test_sdf_model_drives_as_the_urdf(tmp_path: Path, name: str) -> None:
    robot = SIDEWAYS[name][0] if name in SIDEWAYS else STEERED[name]
    ends = [
        run(simulator(robot=path), 2.0, Velocity(0.3, y=0.2, yaw_rate=0.2)).truth.pose
        for path in (robot.write(tmp_path), robot.write_sdf(tmp_path))
    ]
    assert ends[0].distance(ends[1]) < 1e-3


def test_topics_of_a_plugin_without_wheels_are_kept(tmp_path: Path) -> None:
    drive = load_robot(cases.planar().write(tmp_path), SearchPath()).drive
    assert (drive.command_topic, drive.odometry_topic, drive.from_world) == ("go", "way", True)
    controlled = load_robot(cases.mecanum(controlled=True).write(tmp_path), SearchPath()).drive
    assert controlled.command_topic == "/mecanum_drive_controller/reference"
    assert controlled.odometry_topic == "/mecanum_drive_controller/odometry"


def test_heavy_steered_wheel_neither_kicks_the_robot_nor_speeds_it_up(tmp_path: Path) -> None:
    """Its reaction is held by the ground; wheels turn as the steering stands, not as it will."""
    path = cases.tricycle().write(tmp_path)
    robot = load_robot(path, SearchPath())
    front = robot.urdf.links["front_wheel"]
    assert front.inertial is not None
    heavy = replace(front.inertial, mass=3.0 * robot.urdf.mass)
    heavy = replace(heavy, inertia=np.eye(3) * heavy.mass * robot.drive.radius**2)
    links = {**robot.urdf.links, "front_wheel": replace(front, inertial=heavy)}
    robot = replace(robot, urdf=replace(robot.urdf, links=links))
    sim = Simulation(solo(robot), level(), SimulatorConfig(), np.random.default_rng(0))
    seen = [sim.drive(Velocity(0.3, yaw_rate=0.6)).truth for _ in range(100)]
    assert max(truth.v for truth in seen) < 1.1 * 0.3
    assert min(truth.w for truth in seen) > -0.1
    assert max(abs(truth.side) for truth in seen[:10]) < 0.05
    assert seen[-1].w == pytest.approx(0.6, rel=0.1)


_OTHER = {
    "base_footprint": "chassis_foot",
    "<topicName>scan<": "<topicName>/front/scan<",
    "~/out:=depth/points<": "~/out:=/front/points<",
    "<commandTopic>cmd_vel<": "<commandTopic>drive<",
    "<odometryTopic>odom<": "<odometryTopic>wheels/odom<",
}


def test_standard_names_are_left_out() -> None:
    assert names_of(named_robot("", "")) == {}


def test_names_of_its_own_are_returned(tmp_path: Path) -> None:
    text = ROBOT.read_text(encoding="utf-8")
    for old, new in _OTHER.items():
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "other.urdf"
    path.write_text(text, encoding="utf-8")
    assert names_of(named_robot(str(path), "")) == {
        "scan_topic": "/front/scan",
        "cloud_topic": "/front/points",
        "cmd_vel_topic": "drive",
        "odom_topic": "wheels/odom",
        "base_frame": "chassis_foot",
    }


@pytest.mark.parametrize("is_fused", [True, False])
def test_a_filter_does_not_hear_the_odometry_that_it_leaves_to_the_robot(
    tmp_path: Path, is_fused: bool
) -> None:
    text = ROBOT.read_text(encoding="utf-8")
    path = tmp_path / "other.urdf"
    path.write_text(text.replace("Topic>odom<", "Topic>/wheel_odom<"), encoding="utf-8")
    found = names_of(named_robot(str(path), ""), is_fused)
    own = {"odom_topic": "/wheel_odom", "wheel_odom": "/wheel_odom/unfused"}
    assert found == ({} if is_fused else own)


@pytest.mark.parametrize("limit", [0.5, 0.95])
def test_a_steered_robots_bend_is_that_of_its_inner_wheel(tmp_path: Path, limit: float) -> None:
    robot = named_robot(str(car("gz", limit=limit).write(tmp_path)), "")
    assert turning_radius_of(robot) == pytest.approx(0.36 / math.tan(limit) + 0.12)
    assert axle_of(robot, "base") == pytest.approx(-0.16)


def test_a_robot_turns_about_the_middle_of_its_wheels() -> None:
    robot = named_robot("", "")
    assert turning_radius_of(robot) == 0.0
    axle = axle_of(robot, "base_link")
    assert 0.0 < axle < 0.01  # the front ones carry a little more
    assert axle_of(robot, "lidar_link") == pytest.approx(
        axle - robot.urdf.T_root("lidar_link").position[0]
    )


@pytest.mark.parametrize("behind", [0.0, 0.05, 0.1])
def test_a_robot_that_skids_turns_about_a_point_nearer_to_its_weight(
    tmp_path: Path, behind: float
) -> None:
    drive = plugin("gz-sim-diff-drive-system", sides("front", "rear"))
    robot = cases.Robot(cases.four(), drive, middle=-behind)
    seen = _driven(robot, tmp_path, Velocity(yaw_rate=0.8), math.pi / 0.8)
    truth, odometry = seen.truth.pose, seen.odometry.T_odom_base
    assert math.hypot(truth.x, truth.y) >= 0.5 * behind
    assert math.hypot(truth.x - odometry.x, truth.y - odometry.y) < 0.01


@pytest.mark.parametrize("along", [-0.15, 0.1])
def test_odometry_is_of_the_base_where_its_wheels_lie_before_or_behind_it(
    tmp_path: Path, along: float
) -> None:
    wheels = tuple(replace(wheel, x=wheel.x + along) for wheel in cases.four())
    drive = plugin("gz-sim-diff-drive-system", sides("front", "rear"))
    robot = cases.Robot(wheels, drive, middle=along)
    seen = _driven(robot, tmp_path, Velocity(yaw_rate=0.8), 2.0)
    truth, odometry = seen.truth.pose, seen.odometry.T_odom_base
    assert math.hypot(truth.x, truth.y) > abs(along)
    assert (truth @ SE2(along)).distance(SE2(along)) < 0.02  # what it turns about
    assert odometry.distance(truth) < 0.03
