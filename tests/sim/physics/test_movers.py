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
