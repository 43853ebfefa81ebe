"""Models that VelocityControl moves: by their first velocity, by commands, and into walls."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.files.world_file import load_world
from arjuna_sim.simulation import Simulation
from tests.sim.builders import ROBOT, run, saved_world, simulator, texts

_BOX = "<geometry><box><size>{} 0.5 0.5</size></box></geometry>"
_LINK = "<link name='l'><collision name='c'>{}</collision></link>"


def _world(folder: Path, inside: str, topic: str = "") -> Path:
    wall = f"<model name='wall'><static>1</static><pose>6 2 .25 0 0 0</pose>{_LINK}</model>"
    plugin = "<plugin filename='gz-sim-velocity-control-system' name='v'>{}</plugin>"
    mover = f"<model name='mover'><pose>2 2 .25 0 0 1.57079632679</pose>{_LINK}{plugin}</model>"
    ground = "<include><uri>model://ground_plane</uri></include>"
    boxes = wall.format(_BOX.format(0.2)) + mover.format(_BOX.format(0.5), inside + topic)
    return saved_world(folder, ground + boxes)


def _pose(sim: Simulation) -> SE2:
    return sim.stage.motion("mover").pose.planar()


@pytest.mark.parametrize(
    ("inside", "wanted"),
    [
        ("", SE2(2.0, 2.0, math.pi / 2)),
        ("<initial_linear>0.5 0 0</initial_linear>", SE2(2.0, 3.0, math.pi / 2)),
        ("<initial_linear>0 -0.5 0</initial_linear>", SE2(3.0, 2.0, math.pi / 2)),
        ("<initial_angular>0 0 0.5</initial_angular>", SE2(2.0, 2.0, math.pi / 2 + 1.0)),
        (
            "<initial_linear>0.5 0 0</initial_linear><initial_angular>0 0 0.5</initial_angular>",
            SE2(2.0, 2.0, math.pi / 2) @ SE2.exp([1.0, 0.0, 1.0]),  # type: ignore[arg-type]
        ),
    ],
)
def test_a_mover_keeps_its_first_velocity_in_its_own_frame(
    tmp_path: Path, inside: str, wanted: SE2
) -> None:
    world = _world(tmp_path, inside)
    assert texts(load_world(world).notes) == ()
    sim = simulator(world, robot=ROBOT)
    for _ in range(2):  # and again after a reset
        run(sim, 2.0)
        off = wanted.inverse() @ _pose(sim)
        assert math.hypot(off.x, off.y) < 0.02
        assert abs(off.theta) < 0.02
        sim.reset()


def test_a_mover_obeys_commands_and_stops_at_a_wall(tmp_path: Path) -> None:
    sim = simulator(_world(tmp_path, "<initial_linear>0.5 0 0</initial_linear>"))
    sim.stage.movers.command("mover", Velocity(y=-0.5))
    run(sim, 12.0)
    assert _pose(sim).x == pytest.approx(5.65, abs=0.05)  # its face at the wall's
    sim.stage.movers.command("mover", Velocity())
    at = _pose(sim).x
    run(sim, 1.0)
    assert _pose(sim).x == pytest.approx(at, abs=0.02)
    sim.reset()
    run(sim, 1.0)
    assert _pose(sim).y == pytest.approx(2.5, abs=0.02)


@pytest.mark.parametrize(
    ("tag", "topic"), [("", "/model/mover/cmd_vel"), ("<topic>/go</topic>", "/go")]
)
def test_its_topic_is_the_files(tmp_path: Path, tag: str, topic: str) -> None:
    assert load_world(_world(tmp_path, "", tag)).movers["mover"].topic == topic


def _followed(folder: Path, way: str, more: str = "") -> Simulation:
    plugin = f"<plugin filename='gz-sim-trajectory-follower-system' name='t'>{way}{more}</plugin>"
    body = _LINK.format(
        _BOX.format(0.5) + "<surface><friction><ode><mu>0.5</mu></ode></friction></surface>"
    ).replace("<collision", "<inertial><mass>10</mass></inertial><collision")
    model = f"<model name='mover'><pose>2 2 .25 0 0 0.5</pose>{body}{plugin}</model>"
    world = saved_world(folder, "<include><uri>model://ground_plane</uri></include>" + model)
    assert texts(load_world(world).notes) == ()
    return simulator(world)


WAY = "<waypoints><waypoint>2 4</waypoint><waypoint>4 4</waypoint></waypoints>"
STRONG = "<force>60</force><zero_vel_on_bearing_reached>true</zero_vel_on_bearing_reached>"


@pytest.mark.parametrize(("loop", "last"), [("", (4.0, 4.0)), ("<loop>true</loop>", None)])
def test_a_follower_is_pushed_from_waypoint_to_waypoint(
    tmp_path: Path, loop: str, last: tuple[float, float] | None
) -> None:
    sim = _followed(tmp_path, WAY, STRONG + loop)
    for _ in range(2):  # and again after a reset
        passed: list[tuple[float, float]] = []
        for _ in range(200):
            run(sim, 0.1)
            pose = _pose(sim)
            near = [at for at in ((2.0, 4.0), (4.0, 4.0)) if math.dist(at, (pose.x, pose.y)) < 0.6]
            passed += near if near != passed[-1:] else []
        assert passed[:2] == [(2.0, 4.0), (4.0, 4.0)]
        assert (len(passed) > 3) == (last is None)
        sim.reset()


def test_what_the_ground_holds_is_not_pushed(tmp_path: Path) -> None:
    sim = _followed(tmp_path, WAY, "<force>20</force><torque>0</torque>")
    run(sim, 2.0)
    assert _pose(sim).x == pytest.approx(2.0, abs=0.02)


@pytest.mark.parametrize(
    ("way", "waypoints"),
    [
        ("<circle><radius>2</radius></circle>", ((4.0, 2.0), (2.0, 4.0), (0.0, 2.0), (2.0, 0.0))),
        (
            "<line><direction>1.0707963</direction><length>2</length></line>",
            ((2.0, 2.0), (2.0, 4.0)),
        ),
    ],
)
def test_a_follower_goes_around_a_circle_or_along_a_line(
    tmp_path: Path, way: str, waypoints: tuple[tuple[float, float], ...]
) -> None:
    found = _followed(tmp_path, way).stage.world.followers["mover"]
    every = found.waypoints[:: len(found.waypoints) // len(waypoints)]
    np.testing.assert_allclose(every, waypoints, atol=1e-6)
    assert (found.force, found.torque, found.reach, found.loop) == (60.0, 50.0, 0.5, False)


_JOINT = "<plugin filename='gz-sim-{0}-system' name='{0}'><joint_name>j</joint_name>{1}</plugin>"
_DOOR = (
    "<model name='door'><pose>3 0 1 0 0 0</pose><link name='post'><collision name='c'>{0}"
    "</collision></link><link name='leaf'><pose>0 0.6 0 0 0 0</pose><inertial><mass>8</mass>"
    "</inertial><collision name='c'>{1}</collision></link>"
    "<joint name='w' type='fixed'><parent>world</parent><child>post</child></joint>"
    "<joint name='j' type='revolute'><pose>0 -0.6 0 0 0 0</pose><parent>post</parent>"
    "<child>leaf</child><axis><xyz>{2}</xyz><limit><lower>-3</lower><upper>3</upper>"
    "<effort>{3}</effort></limit></axis></joint>{4}</model>"
)


def _door(folder: Path, plugin: str, axis: str = "0 0 1", effort: str = "-1") -> Path:
    box = "<geometry><box><size>0.1 {} 0.5</size></box></geometry>"
    door = _DOOR.format(box.format(0.1), box.format(1.0), axis, effort, plugin)
    return saved_world(folder, "<include><uri>model://ground_plane</uri></include>" + door)


def _angle(sim: Simulation) -> float:
    return float(sim.stage.data.joint("entity:door::leaf").qpos[0])


GAINS = "<p_gain>200</p_gain><d_gain>40</d_gain>"


@pytest.mark.parametrize(
    ("plugin", "axis", "value", "wanted"),
    [
        (_JOINT.format("joint-position-controller", ""), "0 0 1", 1.2, 1.2),
        (_JOINT.format("joint-position-controller", ""), "1 0 0", 0.5, 0.5),  # against gravity
        (_JOINT.format("joint-position-controller", GAINS), "0 0 1", 1.2, 1.2),
        (_JOINT.format("joint-controller", ""), "0 0 1", 0.4, 0.8),
        (_JOINT.format("joint-controller", ""), "1 0 0", 0.4, 0.8),
        (_JOINT.format("apply-joint-force", ""), "0 0 1", 1.0, 0.55),  # 3.6 kg m^2 for 2 s
    ],
)
def test_a_plugin_turns_the_joint_of_a_model_by_commands(
    tmp_path: Path, plugin: str, axis: str, value: float, wanted: float
) -> None:
    path = _door(tmp_path, plugin, axis)
    assert texts(load_world(path).notes) == ()
    sim = simulator(path)
    run(sim, 1.0)
    assert _angle(sim) == pytest.approx(0.0, abs=0.01)
    sim.stage.movers.motors.command("door::leaf", value)
    run(sim, 2.0)
    assert _angle(sim) == pytest.approx(wanted, abs=0.03)
    sim.reset()
    run(sim, 1.0)
    assert _angle(sim) == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize(
    ("name", "tag", "wanted"),
    [
        ("joint-controller", "<initial_velocity>0.5</initial_velocity>", 0.5),
        ("joint-position-controller", "<initial_position>0.7</initial_position>", 0.7),
    ],
)
def test_a_joints_first_command_is_the_files(
    tmp_path: Path, name: str, tag: str, wanted: float
) -> None:
    sim = simulator(_door(tmp_path, _JOINT.format(name, tag)))
    run(sim, 1.0)
    assert _angle(sim) == pytest.approx(wanted, abs=0.01)


def test_a_motor_is_as_strong_as_its_joint_says(tmp_path: Path) -> None:
    plugin = _JOINT.format("joint-position-controller", "")
    sim = simulator(_door(tmp_path, plugin, "1 0 0", effort="10"))  # the leaf's weight: 47 N m
    sim.stage.movers.motors.command("door::leaf", 0.5)
    run(sim, 3.0)
    assert _angle(sim) < -0.8  # it lies on the ground


@pytest.mark.parametrize(
    ("name", "tag", "topic"),
    [
        ("joint-position-controller", "", "/model/door/joint/j/_0/cmd_pos"),
        ("joint-position-controller", "<sub_topic>go</sub_topic>", "/model/door/go"),
        ("joint-controller", "", "/model/door/joint/j/cmd_vel"),
        ("apply-joint-force", "<topic>/push</topic>", "/model/door/joint/j/cmd_force"),
    ],
)
def test_the_topic_of_a_motor_is_gzs(tmp_path: Path, name: str, tag: str, topic: str) -> None:
    world = load_world(_door(tmp_path, _JOINT.format(name, tag)))
    assert world.motors["door::leaf"].topic == topic


_BELT = (
    "<model name='belt'><static>1</static><link name='b'><pose>3 0 0.3 0 0 {1}</pose><collision"
    " name='c'><geometry><box><size>3 1 0.1</size></box></geometry></collision></link>"
    "<link name='legs'><pose>3 0 0.15 0 0 0</pose><collision name='c'><geometry><box>"
    "<size>0.5 0.5 0.29</size></box></geometry></collision></link>"
    "<plugin filename='gz-sim-track-controller-system' name='gz::sim::systems::TrackController'>"
    "<link>b</link>{0}</plugin></model><model name='mover'><pose>3 0 0.45 0 0 0</pose>"
    "<link name='l'><collision name='c'><geometry><box><size>0.2 0.2 0.2</size></box></geometry>"
    "</collision></link></model>"
)


def _belt(folder: Path, inside: str = "", yaw: float = 0.0) -> Path:
    ground = "<include><uri>model://ground_plane</uri></include>"
    return saved_world(folder, ground + _BELT.format(inside, yaw))


@pytest.mark.parametrize(
    ("inside", "yaw", "value", "wanted"),
    [
        ("", 0.0, 0.2, (3.4, 0.0)),
        ("", 0.0, -0.2, (2.6, 0.0)),
        ("", math.pi / 2, 0.2, (3.0, 0.4)),
        ("<track_orientation>0 0 1.5707963</track_orientation>", 0.0, 0.2, (3.0, 0.4)),
        ("<max_velocity>0.1</max_velocity>", 0.0, 0.2, (3.2, 0.0)),
        ("<min_velocity>-0.1</min_velocity>", 0.0, -0.2, (2.8, 0.0)),
    ],
)
def test_a_belt_carries_what_lies_on_it_and_stays(
    tmp_path: Path, inside: str, yaw: float, value: float, wanted: tuple[float, float]
) -> None:
    path = _belt(tmp_path, inside, yaw)
    assert texts(load_world(path).notes) == ()
    sim = simulator(path)
    for _ in range(2):  # and again after a reset
        run(sim, 1.5)
        assert (_pose(sim).x, _pose(sim).y) == pytest.approx((3.0, 0.0), abs=0.005)
        sim.stage.movers.motors.command("belt::b", value)
        run(sim, 2.0)
        assert (_pose(sim).x, _pose(sim).y) == pytest.approx(wanted, abs=0.03)
        belt = sim.stage.motion("belt::b").pose.position
        assert belt == pytest.approx((3.0, 0.0, 0.3), abs=0.002)
        sim.reset()


def test_a_belt_has_gzs_topic_or_its_files_and_its_models_name_where_it_is_all_of_it(
    tmp_path: Path,
) -> None:
    path = _belt(tmp_path, "<max_jerk>1</max_jerk>")
    world = load_world(path)
    assert world.motors["belt::b"].topic == "/model/belt/link/b/track_cmd_vel"
    assert any("<max_jerk>: not simulated" in text for text in texts(world.notes))
    whole, legs = path.read_text(), path.read_text().index("<link name='legs'>")
    end = whole.index("<plugin", legs)
    bare = whole[:legs] + whole[end:].replace("<link>b</link>", "<link>b</link>{}", 1)
    path.write_text(bare.format("<velocity_topic>/go</velocity_topic>"))
    assert load_world(path).motors["belt"].topic == "/go"
