"""Start poses of robots."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.errors import WorldError
from arjuna_core.se2 import SE2
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.sdf.solids import prism
from arjuna_sim.model.geometry.shapes import Kind, Mesh, Part, Shape
from arjuna_sim.model.robot import SOLO
from arjuna_sim.model.world import Body, World
from arjuna_sim.physics.placing import Placer
from arjuna_sim.simulation import Simulation, solo
from tests.sim.builders import ROBOT, run, saved_world, simulator, static
from tests.sim.generated import Chassis, level, slope
from tests.sim.start_cases import WORLDS, Ground, start_case


def robot_on(world: World) -> Simulation:
    starts = solo(Chassis().robot())
    return Simulation(starts, world, SimulatorConfig(), np.random.default_rng(0))


@cache
def placer(degrees: float) -> Placer:
    return Placer(robot_on(slope(degrees) if degrees else level()).stage, SOLO)


L = 4.0 * np.array([(-1, -1), (1, -1), (1, 1), (0.9, 1), (0.9, 0.9), (-1, 0.9)])
PLATE = prism(L, 1e-3) - (0.0, 0.0, 1e-3)
FLOORS = {
    "plate": PLATE,
    "inside out": PLATE[:, ::-1],
    "sheet": PLATE[PLATE[:, :, 2].min(axis=1) == 0.0],
    "slab": prism(L, 0.1) - (0.0, 0.0, 0.1),
}


@pytest.mark.parametrize("faces", FLOORS.values(), ids=FLOORS)
def test_it_starts_and_rests_on_a_mesh_as_on_a_plane(faces: NDArray[np.float64]) -> None:
    part = Part(Shape(Kind.MESH, (1.0, 1.0, 1.0), Mesh(Path("floor.stl"), faces)))
    floor = robot_on(World(Path("w"), "w", (Body("floor", part, True),), ()))
    for sim in (floor, plane := robot_on(level())):
        run(sim, 2.0)
    assert floor.robot.spawn == plane.robot.spawn
    np.testing.assert_allclose(floor.stage.data.qpos[:7], plane.stage.data.qpos[:7], atol=1e-3)


@pytest.mark.parametrize("degrees", [10.0, 25.0, 34.0])
@pytest.mark.parametrize("turn", [0.0, 1.0, math.pi / 2, math.pi])
def test_it_lies_on_a_slope_at_any_heading(degrees: float, turn: float) -> None:
    tilted = placer(degrees)
    root = tilted.root_pose(SE2(0.2, -0.1, turn))
    up, flat = root.rotation()[:, 2], tilted.root_pose(SE2(0.2, -0.1)).rotation()[:, 2]
    angle = math.radians(degrees)
    assert up == pytest.approx((-math.sin(angle), 0.0, math.cos(angle)), abs=2e-3)
    assert up == pytest.approx(flat, abs=2e-3)
    assert root.position[:2] == pytest.approx((0.2, -0.1))
    ride = placer(0.0).root_pose(SE2()).position[2]
    above = root.position[2] - 0.2 * math.tan(angle)
    assert above == pytest.approx(ride / math.cos(angle), abs=2e-3)


AWAY = SE2(30.0, 0.0, 0.0)


def among(folder: Path, *boxes: tuple[str, str, str]) -> Placer:
    """Return a placer of the shipped robot among boxes, each a name, a position and a size."""
    box = "<box><size>{}</size></box>"
    inside = "".join(static(name, box.format(size), f"{at} 0 0 0") for name, at, size in boxes)
    return Placer(simulator(saved_world(folder, inside), spawn=AWAY).stage, SOLO)


def test_what_it_would_touch_is_named_and_it_stands_there_all_the_same(tmp_path: Path) -> None:
    on = among(tmp_path, ("post", "0.1 0 0.5", "0.1 0.1 1"), ("far", "5 0 0.5", "0.1 0.1 1"))
    ride = on.root_pose(AWAY).position[2]
    assert on.touched(AWAY) == ()
    assert on.touched(SE2()) == ("post",)
    assert on.root_pose(SE2(0.0, 0.0, 1.0)).position == pytest.approx((0.0, 0.0, ride))
    assert on.root_pose(SE2(0.0, 0.0, 1.0)).rpy()[2] == pytest.approx(1.0)
    assert on.nearest_free(AWAY) is AWAY


def test_the_nearest_pose_has_room_to_turn_and_drive_away(tmp_path: Path) -> None:
    on, heading = among(tmp_path, ("wall", "0.3 0 0.5", "0.2 3 1")), 0.3
    found = on.nearest_free(SE2(0.2, 0.0, heading))
    assert found.theta == heading
    ring = math.hypot(found.x - 0.2, found.y) / 0.1
    assert ring == pytest.approx(round(ring))

    def is_free(at: SE2, turns: int, ahead: float) -> bool:
        poses = (at @ SE2(0.0, 0.0, 2.0 * math.pi * k / turns) for k in range(turns))
        return not any(on.touched(pose @ SE2(ahead, 0.0)) for pose in poses)

    assert is_free(found, 64, 0.0)
    assert is_free(found, 64, 0.04)
    for step in range(16):
        direction, nearer = heading + step * math.pi / 8, 0.1 * (round(ring) - 1)
        at = SE2(0.2 + nearer * math.cos(direction), nearer * math.sin(direction), heading)
        assert not is_free(at, 12, 0.05)


def test_the_origin_has_room_to_turn_where_what_is_asked_for_is_kept(tmp_path: Path) -> None:
    on, beside = among(tmp_path, ("wall", "0.26 0 0.5", "0.02 3 1")), SE2(0.01, 0.0, 0.0)
    assert on.touched(beside) == on.touched(SE2()) == ()
    assert on.nearest_free(beside) == beside
    assert on.touched(SE2(0.0, 0.0, 0.6)) == ("wall",)
    assert on.nearest_free(SE2()) == SE2()
    assert on.nearest_free(None).x < -0.05


def test_the_origin_is_kept_where_there_is_no_room_near(tmp_path: Path) -> None:
    walls = (("left", "0 0.26 0.5", "4 0.02 1"), ("right", "0 -0.26 0.5", "4 0.02 1"))
    on = among(tmp_path, *walls)
    assert on.touched(SE2(0.0, 0.0, 0.8))
    assert on.nearest_free(None) == SE2()


@pytest.mark.parametrize(("edge", "is_free"), [("5.2", True), ("7.6", False)])
def test_it_is_searched_within_three_metres(tmp_path: Path, edge: str, is_free: bool) -> None:
    on = among(tmp_path, ("block", "0 0 0.5", f"{edge} 20 1"))
    if is_free:
        assert 2.6 < abs(on.nearest_free(SE2()).x) < 3.01
    else:
        with pytest.raises(WorldError, match=r"no pose within 3 m of \(0\.5, 0\) is free for the"):
            on.nearest_free(SE2(0.5, 0.0, 0.0))


@pytest.mark.parametrize(
    ("size", "z", "height"),
    [
        ("4 4 0.2", 0.1, 0.2),  # a low stage is a floor
        ("4 4 0.3", 0.15, None),  # a higher one is none, and nothing fits into it
        ("0.8 0.8 0.2", 0.1, None),  # nor is the top of a box
        ("4 0.8 0.2", 0.1, None),  # nor that of a beam: it goes on in two ways of eight
        ("4 4 0.1", 1.5, 0.0),  # what is above it is a roof
        ("4 4 0.1", 3.2, 0.0),
    ],
)
def test_it_stands_on_floors_and_under_roofs(
    tmp_path: Path, size: str, z: float, height: float | None
) -> None:
    on = among(tmp_path, ("plate", f"0 0 {z}", size))
    ride = on.root_pose(AWAY).position[2]
    touched, at = on.touched(SE2()), on.root_pose(SE2()).position[2]
    assert touched == (("plate",) if height is None else ())
    assert at == pytest.approx(ride + (height or 0.0), abs=1e-6)


def test_of_two_floors_it_takes_the_lowest_where_it_fits(tmp_path: Path) -> None:
    stages = ("low", "0 0 0.05", "6 6 0.1"), ("high", "0 0 0.1", "4 4 0.2")
    on = among(tmp_path, *stages)
    ride = on.root_pose(AWAY).position[2]
    assert on.root_pose(SE2()).position[2] == pytest.approx(ride + 0.2, abs=1e-6)
    lower = on.root_pose(SE2(2.5, 0.0, math.pi / 2)).position[2]
    assert lower == pytest.approx(ride + 0.1, abs=1e-6)


CHASSIS = (Chassis(), Chassis(axles=1), Chassis(mass=40.0, radius=0.1, axles=3))


@pytest.mark.parametrize("number", range(0, WORLDS, 5))
def test_it_starts_on_the_ground_near_what_was_asked(number: int) -> None:
    case, rng = start_case(number), np.random.default_rng(number)
    robot = CHASSIS[number % 4 - 1].robot() if number % 4 else load_robot(ROBOT)
    flat = Simulation(solo(robot), level(), SimulatorConfig(), np.random.default_rng(0))
    run(flat, 1.0)
    for asked in case.asked(rng)[::2]:
        sim = Simulation(solo(robot, asked), case.world, SimulatorConfig(), rng)
        spawn = sim.robot.spawn
        assert case.clearance(asked.x, asked.y) < 0.6 or spawn == asked
        assert (spawn != asked) is any("the robot starts at" in note for note in sim.notes)
        assert math.hypot(spawn.x - asked.x, spawn.y - asked.y) <= 3.01
        begun = sim.robot.truth()
        run(sim, 1.0)
        rests, slope = sim.robot.truth(), steepness(case.ground, spawn)
        at = rests.pose
        assert math.hypot(at.x - spawn.x, at.y - spawn.y) < 0.03
        assert abs(rests.z - begun.z) < 0.03
        height = case.ground(at.x, at.y) + flat.robot.truth().z
        assert rests.z == pytest.approx(height, abs=0.03 + 0.02 * slope)
        assert math.hypot(rests.roll, rests.pitch) < math.atan(slope) + 0.06


def steepness(ground: Ground, at: SE2) -> float:
    dx = ground(at.x + 0.1, at.y) - ground(at.x - 0.1, at.y)
    dy = ground(at.x, at.y + 0.1) - ground(at.x, at.y - 0.1)
    return math.hypot(dx, dy) / 0.2
