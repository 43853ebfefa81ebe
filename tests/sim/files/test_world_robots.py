"""Robots that stand in a world's file: found, read, placed, driven, and in the world no more."""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import RobotError
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_sim.check import check
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.sensors.lidar import LidarSettings
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.world_file import load_world, robots_in
from arjuna_sim.inputs import named_robot, named_world
from arjuna_sim.simulation import Simulation, Start, solo
from tests.sim.builders import first, texts
from tests.sim.robot_worlds import BESIDE, DRIVES, FORMS, Held, write

pytestmark = pytest.mark.usefixtures("without_sills")

OTHERS = ("ground_plane", "wall", "crate", "exhibit")


def _is_at(pose: SE2, wanted: SE2, within: float) -> bool:
    turn = abs(wrap(pose.theta - wanted.theta))
    return math.hypot(pose.x - wanted.x, pose.y - wanted.y) < within and turn < within


@pytest.mark.parametrize(
    ("drive", "form"),
    [
        *((drive, "inline") for drive in DRIVES),
        *product(("TrackedVehicle", "diff_drive_controller"), FORMS[1:]),
    ],
)
def test_a_world_holds_its_robot_however_it_is_written(
    tmp_path: Path, drive: str, form: str
) -> None:
    held = Held(drive=drive, form=form)
    path = write(tmp_path, held)
    assert robots_in(path) == ("vehicle",)
    robot = named_robot(str(path), "")
    assert robot.start is not None
    assert _is_at(robot.start, held.pose, 1e-9)
    assert robot.urdf.name == "vehicle"
    assert first(robot, LidarSettings).topic == "scan"
    world = named_world(str(path), [robot])
    assert tuple(world.models) == OTHERS
    assert not any("vehicle" in text or "drive" in text for text in texts(world.notes))


MOVER = """<model name='mover'><pose>0 5 0.25 0 0 0</pose><link name='l'><collision name='c'>
<geometry><box><size>0.5 0.5 0.5</size></box></geometry></collision>{}</link>
{}</model>"""
VELOCITY = "<plugin filename='gz-sim-velocity-control-system' name='v'/>"
PLANAR = """<plugin filename='libgazebo_ros_planar_move.so' name='m'><ros>
<namespace>{}</namespace></ros><publish_odom>true</publish_odom></plugin>"""
ODOMETRY = "<plugin filename='gz-sim-odometry-publisher-system' name='o'/>"


@pytest.mark.parametrize(
    ("sensor", "plugins", "topic"),
    [
        ("", VELOCITY, "/model/mover/cmd_vel"),
        ("", PLANAR.format("/crowd/mover"), "/crowd/mover/cmd_vel"),
        ("<sensor name='s' type='imu'/>", VELOCITY, ""),
        ("<sensor name='s' type='imu'/>", PLANAR.format("a"), ""),
        ("", VELOCITY + ODOMETRY, ""),
        ("", PLANAR.format(""), ""),  # obeys a robot's own topic
    ],
)
def test_a_bare_body_that_is_moved_is_an_obstacle(
    tmp_path: Path, sensor: str, plugins: str, topic: str
) -> None:
    path = write(tmp_path, Held(), beside=BESIDE + MOVER.format(sensor, plugins))
    assert robots_in(path) == (("vehicle",) if topic else ("mover", "vehicle"))
    world = load_world(path)
    assert "mover" in world.movable
    assert {name: mover.topic for name, mover in world.movers.items()} == (
        {"mover": topic} if topic else {}
    )


@pytest.mark.parametrize(
    "held",
    [
        *(Held(drive=drive) for drive in DRIVES),
        *(Held(form=form) for form in FORMS[1:]),
        Held(drive="diff_drive_controller", form="nested"),
    ],
    ids=lambda held: f"{held.drive}, {held.form}",
)
def test_the_robot_of_a_world_drives_where_the_world_puts_it(tmp_path: Path, held: Held) -> None:
    path = str(write(tmp_path, held))
    robot = named_robot(path, "")
    assert robot.start is not None
    world, rng = named_world(path, [robot]), np.random.default_rng(0)
    sim = Simulation(solo(robot, robot.start), world, SimulatorConfig(), rng)
    assert sim.robot.spawn == robot.start
    for _ in range(100):
        seen = sim.drive(Velocity(0.3))
    assert _is_at(seen.truth.pose, held.pose @ SE2(0.58, 0.0, 0.0), 0.05)
    assert _is_at(seen.odometry.T_odom_base, SE2(0.58, 0.0, 0.0), 0.05)


@pytest.mark.parametrize("drive", DRIVES)
def test_the_robot_of_a_world_is_the_same_as_cut_out(tmp_path: Path, drive: str) -> None:
    robot = load_robot(write(tmp_path, Held("made", drive)), SearchPath())
    alone = tmp_path / "alone"
    alone.mkdir()
    other = load_robot(DRIVES[drive].write_sdf(alone), SearchPath())
    named = {name for name in robot.urdf.links if "mast" not in name}
    assert named == set(other.urdf.links)
    assert all(robot.urdf.joints[name] == joint for name, joint in other.urdf.joints.items())
    assert robot.drive == other.drive
    assert other.start is None


def test_robots_of_one_world_drive_apart(tmp_path: Path) -> None:
    """Each by its own commands; one that another's pose is relative to stays a frame for it."""
    held = [
        Held("blue", pose=SE2(0.0, 2.0, 0.0)),
        Held("green", "MecanumDrive", "included", SE2(0.0, -2.0, 1.0)),
    ]
    on_blue = "<model name='tag'><static>1</static><pose relative_to='blue'>0 3 0 0 0 0</pose>"
    on_blue += "<link name='l'><visual name='v'><geometry><sphere><radius>1</radius></sphere>"
    path = write(tmp_path, *held, beside=f"{on_blue}</geometry></visual></link></model>")
    assert robots_in(path) == ("blue", "green")
    robots = {name: named_robot(f"{path}#{name}", "") for name in robots_in(path)}
    world = named_world(str(path), robots.values())
    assert world.models["tag"][0].T_world_model.position == pytest.approx((0.0, 5.0, 0.06))
    starts = {name: Start(robot, robot.start or SE2()) for name, robot in robots.items()}
    sim = Simulation(starts, world, SimulatorConfig(), np.random.default_rng(0))
    for _ in range(100):
        sim.step({"blue": Velocity(0.3), "green": Velocity(0.0, y=0.3)})
    assert _is_at(sim.robots["blue"].truth().pose, SE2(0.58, 2.0, 0.0), 0.05)
    wanted = held[1].pose @ SE2(0.0, 0.58, 0.0)
    assert _is_at(sim.robots["green"].truth().pose, wanted, 0.05)


def test_robots_that_do_not_drive_stand_in_the_world_and_that_is_said(tmp_path: Path) -> None:
    path = write(tmp_path, Held("blue"), Held("green", pose=SE2(0.0, -2.0, 1.0)))
    world = named_world(str(path), [named_robot(f"{path}#green", "")])
    assert tuple(world.models) == (*OTHERS, "blue")
    said = [text for text in texts(world.notes) if "robot" in text or "'drive'" in text]
    assert said == [
        "model 'blue': is a robot, but stands here as a thing; --robot held.sdf#blue drives it"
    ]
    assert tuple(load_world(path).models) == (*OTHERS, "blue", "green")


def test_a_robot_of_another_world_is_a_robot_without_a_start_in_this(tmp_path: Path) -> None:
    path = write(tmp_path, Held())
    (tmp_path / "other").mkdir()
    other = write(tmp_path / "other", Held())
    assert "vehicle" in named_world(str(other), [named_robot(str(path), "")]).models


@pytest.mark.parametrize(
    ("held", "name", "reason"),
    [
        ((), "", r"no model has a drive; --robot .*held.sdf#NAME takes one without: crate$"),
        (("a", "b"), "", r"holds 2 robots; valid: --robot .*held.sdf#a, --robot .*held.sdf#b"),
        (("a", "b"), "#c", r"'c' is no model of its world; valid: .*a.*b"),
    ],
)
def test_a_world_without_one_robot_is_refused_as_a_robot(
    tmp_path: Path, held: tuple[str, ...], name: str, reason: str
) -> None:
    path = write(tmp_path, *(Held(one, pose=SE2(0.0, float(i))) for i, one in enumerate(held)))
    with pytest.raises(RobotError, match=reason):
        load_robot(f"{path}{name}", SearchPath())


def test_any_model_of_a_world_can_be_named_as_the_robot(tmp_path: Path) -> None:
    path = write(tmp_path, Held())
    assert load_robot(f"{path}#crate", SearchPath()).drive.wheels == ()


def test_a_file_whose_name_has_the_sign_is_that_file(tmp_path: Path) -> None:
    path = write(tmp_path, Held()).rename(tmp_path / "held#1.sdf")
    assert load_robot(path, SearchPath()).urdf.name == "vehicle"


def test_a_check_says_which_robots_a_world_holds(tmp_path: Path) -> None:
    path = write(tmp_path, Held("blue"), Held("green", pose=SE2(0.0, -2.0, 1.0)))
    found = check(path, SearchPath(), {})
    assert f"  robot 'blue': --check {path}#blue says more" in found.lines
    assert not any("blue" in note.text for note in found.notes)
    assert "robot 'green', root link 'base'" in check(Path(f"{path}#green"), SearchPath(), {}).lines
