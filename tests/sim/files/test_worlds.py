"""Worlds: frames, states, what can be pushed, maps as walls, and where a robot can stand."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import WorldError
from arjuna_core.files.maps import save_map
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.files.world_file import load_world, rectangles
from arjuna_sim.model.geometry.walls import surfaces
from arjuna_sim.model.notes import NoteKind
from tests.sim.builders import ROOM, ROOT, edited, run, simulator, texts

_RING = "<frame name='a' attached_to='b'/><frame name='b' attached_to='a'/>"
BOX = """<link name="{link}">{pose}<inertial><mass>{mass}</mass></inertial>
<collision name="c"><geometry><box><size>{size}</size></box></geometry></collision></link>"""


def _box(size: str = "1 1 1", link: str = "l", pose: str = "", mass: str = "2") -> str:
    return BOX.format(link=link, pose=pose, size=size, mass=mass)


def _model(name: str, inside: str, pose: str = "", static: bool = True) -> str:
    return f"<model name='{name}'><static>{str(static).lower()}</static>{pose}{inside}</model>"


def _world(folder: Path, inside: str) -> Path:
    path = folder / "test.world"
    path.write_text(f"<sdf version='1.9'><world name='w'>{inside}</world></sdf>", encoding="utf-8")
    return path


def _place(path: Path, model: str) -> tuple[float, float, float]:
    bodies = load_world(path).bodies
    return next(b.part.pose.position for b in bodies if b.model == model and b.collides)


OLD = """<gazebo version="1.0"><world name="w"><physics type="ode"><gravity xyz="0 0 -5"/></physics>
<scene><ambient rgba="0.1 0.1 0.1 1"/></scene><light type="directional" name="sun"><origin
pose="0 0 10 0 0 0"/></light><model name="ground" static="true"><link name="l"><collision name="c">
<geometry><plane normal="0 0 1"/></geometry></collision></link></model>
<model name="pillar" static="true"><origin pose="2 1 0 0 0 0"/><link name="l"><origin
pose="0 0 0.5 0 0 0"/><collision name="c"><geometry><cylinder radius="0.2" length="1"/></geometry>
<surface><friction><ode mu="0.4"/></friction></surface></collision>
<visual name="v" cast_shadows="0"><geometry><cylinder radius="0.2" length="1"/></geometry></visual>
</link></model>
<model name="crate"><origin pose="0 3 0.25 0 0 0"/><link name="l"><inertial mass="7"><inertia
ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial><collision name="c"><geometry><box
size="0.5 0.4 0.5"/></geometry></collision></link></model>
<plugin name="p" filename="libp.so"/></world></gazebo>"""


def test_a_file_from_before_sdf_had_its_name_is_read(tmp_path: Path) -> None:
    path = tmp_path / "old.world"
    path.write_text(OLD, encoding="utf-8")
    world = load_world(path)
    assert _place(path, "pillar") == (2.0, 1.0, 0.5)
    pillar = next(body.part for body in world.bodies if body.model == "pillar")
    assert (pillar.shape.size, pillar.friction) == ((0.2, 1.0), 0.4)
    crate = next(body.part.shape.size for body in world.bodies if body.model == "crate")
    assert (crate, world.masses, world.gravity[2]) == ((0.5, 0.4, 0.5), {"crate": 7.0}, -5.0)
    assert texts(world.notes) == ("plugin 'p': not simulated",)


def test_poses_are_relative_to_frames_links_and_other_models(tmp_path: Path) -> None:
    inside = (
        "<frame name='dock'><pose>5 0 0 0 0 1.5707963267948966</pose></frame>"
        "<frame name='berth' attached_to='dock'><pose>1 0 0 0 0 0</pose></frame>"
        + _model("by_frame", _box(), "<pose relative_to='berth'>2 0 0 0 0 0</pose>")
        + _model("by_model", _box(), "<pose relative_to='by_frame'>0 0 1 0 0 0</pose>")
        + _model(
            "by_link",
            _box(link="a", pose="<pose>0 1 0 0 0 0</pose>", size="0.1 0.1 0.1")
            + "<frame name='f' attached_to='a'><pose>0 0 2 0 0 0</pose></frame>"
            + _box(link="b", pose="<pose relative_to='f'>0 0 1 0 0 0</pose>"),
            "<pose>0 0 0 0 0 0</pose>",
        )
        + _model(
            "outer",
            "<model name='inner'><pose>1 0 0 0 0 0</pose>" + _box() + "</model>"
            "<frame name='g' attached_to='inner::l'/>"
            + _box(link="far", pose="<pose relative_to='g'>0 4 0 0 0 0</pose>"),
            "<pose>10 0 0 0 0 0</pose>",
        )
    )
    path = _world(tmp_path, inside)
    assert _place(path, "by_frame") == pytest.approx((5, 3, 0))
    assert _place(path, "by_model") == pytest.approx((5, 3, 1))
    world = load_world(path)
    by_link = [b.part.pose.position for b in world.bodies if b.model == "by_link"]
    assert by_link[1] == pytest.approx((0, 1, 3))
    outer = sorted(b.part.pose.position for b in world.bodies if b.model == "outer")
    assert outer == [pytest.approx((11, 0, 0)), pytest.approx((11, 4, 0))]


def test_placement_frame_is_what_the_pose_places(tmp_path: Path) -> None:
    model = _model("m", _box(pose="<pose>0 0 1 0 0 0</pose>"), "<pose>3 0 0 0 0 0</pose>")
    placed = model.replace("name='m'", "name='m' placement_frame='l'")
    assert _place(_world(tmp_path, placed), "m") == pytest.approx((3, 0, 0))


@pytest.mark.parametrize(
    ("frames", "problem"),
    [
        (
            "<frame name='a' attached_to='b'/><frame name='b' attached_to='a'/>",
            "relative to itself",
        ),
        ("<frame name='ab'><pose>0 0 0 0 0 0</pose></frame>", "frame 'a' does not exist.*'ab'"),
    ],
)
def test_model_whose_frames_lead_nowhere_is_left_out(
    tmp_path: Path, frames: str, problem: str
) -> None:
    model = _model("m", _box(), "<pose relative_to='a'>0 0 0 0 0 0</pose>")
    world = load_world(_world(tmp_path, frames + model + _model("n", _box())))
    assert {body.model for body in world.bodies} == {"n", "ground_plane"}
    (note,) = (note for note in world.notes if note.kind is NoteKind.BROKEN)
    assert re.match(rf"model 'm' is left out: .*{problem}", note.text)


def test_state_says_where_models_are(tmp_path: Path) -> None:
    state = "<state world_name='w'><model name='m'><pose>7 8 0 0 0 0</pose></model></state>"
    model = _model("m", _box(), "<pose>1 2 0 0 0 0</pose>")
    assert _place(_world(tmp_path, model + state), "m") == pytest.approx((7, 8, 0))


def test_two_models_of_a_name_are_told_apart(tmp_path: Path) -> None:
    world = load_world(_world(tmp_path, _model("m", _box()) + _model("m", _box())))
    assert [b.model for b in world.bodies if b.model != "ground_plane"] == ["m", "m_1"]
    assert "model 'm': is there twice; the second is called 'm_1'" in texts(world.notes)


def test_model_that_is_not_static_is_pushed_away(tmp_path: Path) -> None:
    light = _model("box", _box("0.3 0.3 0.3", mass="0.5"), "<pose>1 0 0.15 0 0 0</pose>", False)
    sim = simulator(_world(tmp_path, light))
    run(sim, 7.8, Velocity(0.3))
    seen = [sim.drive(Velocity(0.3)) for _ in range(10)]
    assert {each.contacts for each in seen} >= {("box",)}  # it slides along, by small hops
    last = seen[-1]
    assert last.truth.pose.x > 1.5
    moved = sim.stage.motion("box").pose.position
    assert moved[0] == pytest.approx(last.truth.pose.x + 0.225 + 0.15, abs=0.03)
    sim.reset()
    assert sim.stage.motion("box").pose.position == pytest.approx((1.0, 0.0, 0.15), abs=1e-3)


def test_static_model_is_not_pushed_away(tmp_path: Path) -> None:
    heavy = _model("box", _box("0.3 0.3 0.3", mass="0.5"), "<pose>1 0 0.15 0 0 0</pose>")
    assert run(simulator(_world(tmp_path, heavy)), 8.0, Velocity(0.3)).truth.pose.x < 0.65


def test_robot_stands_on_a_raised_floor(tmp_path: Path) -> None:
    floor = _model("floor", _box("6 6 0.1"), "<pose>0 0 0.05 0 0 0</pose>")
    sim = simulator(_world(tmp_path, floor))
    assert sim.notes == ("has no ground plane: one is put at height 0",)
    last = run(sim, 2.0, Velocity(0.3))
    assert last.truth.z == pytest.approx(0.1, abs=2e-3)
    assert last.contacts == ()
    sim.robot.set_pose(SE2(5.0, 0.0, 0.0))
    assert run(sim, 0.5).truth.z == pytest.approx(0.0, abs=2e-3)


def test_robot_starts_at_the_nearest_free_place(tmp_path: Path) -> None:
    sim = simulator(_world(tmp_path, _model("crate", _box(), "<pose>0 0 0.5 0 0 0</pose>")))
    assert 0.7 < SE2().distance(sim.robot.spawn) < 1.0
    assert any("the start (0, 0) is inside crate: the robot starts at" in n for n in sim.notes)
    assert run(sim, 0.5).contacts == ()


def test_world_without_a_free_place_is_refused(tmp_path: Path) -> None:
    full = _model("rock", _box("20 20 2"), "<pose>0 0 0.5 0 0 0</pose>")
    with pytest.raises(WorldError, match="no pose within 3 m"):
        simulator(_world(tmp_path, full))


def test_rectangles_cover_the_occupied_cells_once() -> None:
    occupied = np.random.default_rng(3).random((40, 60)) < 0.4
    occupied[10:20, 5:50] = True
    covered = np.zeros(occupied.shape, np.int64)
    found = rectangles(occupied)
    for row, column, rows, columns in found.tolist():
        covered[row : row + rows, column : column + columns] += 1
    assert np.array_equal(covered, occupied.astype(np.int64))
    assert len(found) < occupied.sum() / 2


def test_walls_of_a_map_stand_where_its_cells_are(tmp_path: Path) -> None:
    cells = np.zeros((40, 60), np.int8)
    cells[:, 0] = cells[:, -1] = cells[0] = cells[-1] = 100
    cells[30:, 20:] = -1
    grid = OccupancyGrid(GridFrame(0.1, 60, 40, SE2(-1.0, -2.0, 0.5)), cells)
    save_map(grid, tmp_path / "hall")
    world = load_world(tmp_path / "hall.yaml")
    assert len([b for b in world.bodies if b.model == "walls" and b.collides]) == 4
    start = SE2(-1.0, -2.0, 0.5) @ SE2(3.0, 2.0, 0.0)
    sim = simulator(tmp_path / "hall.yaml", spawn=start)
    last = run(sim, 0.2)
    assert last.scan is not None
    ahead = last.scan.ranges[np.argmin(np.abs(last.scan.angles))]
    lidar = sim.robot.model.urdf.T_root("lidar_link").position[0]
    assert ahead == pytest.approx(5.9 - 3.0 - lidar, abs=0.05)


def test_shipped_map_is_the_shipped_room() -> None:
    by_map = simulator(ROOT / "maps" / "arjuna_room.yaml")
    by_file = simulator(ROOM)
    scans = [run(sim, 0.2).scan for sim in (by_map, by_file)]
    assert scans[0] is not None
    assert scans[1] is not None
    gap = np.abs(scans[0].ranges - scans[1].ranges)
    assert np.median(gap) < 0.06


def test_broken_map_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    path.write_text("image: none.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n", encoding="utf-8")
    with pytest.raises(WorldError, match=r"none\.pgm does not exist"):
        load_world(path)


def test_surfaces_of_a_cylinder_lie_on_its_circle(tmp_path: Path) -> None:
    cylinder = "<cylinder><radius>0.4</radius><length>1.0</length></cylinder>"
    world = ROOM.read_text(encoding="utf-8").split("<geometry>")[1].split("</geometry>")[0].strip()
    path = edited(ROOM, tmp_path, world, cylinder)
    cut = surfaces(load_world(path), 0.28)
    ring = cut[np.abs(np.hypot(cut[:, 0], cut[:, 1] - 5.0) - 0.4) < 1e-9]
    assert len(ring) == 64
    assert len(surfaces(load_world(path), 3.0)) == 0
