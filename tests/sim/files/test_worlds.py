"""Worlds of SDF and of maps: poses, what can be pushed, walls, where a robot can stand."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.errors import WorldError
from arjuna_core.files.map_image import MapOptions
from arjuna_core.files.maps import load_map, save_map
from arjuna_core.files.shipped import shipped_file
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_sim.files import world_file
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.world_file import WALLS, load_map_world, load_world, rectangles
from arjuna_sim.model.geometry.walls import surfaces
from arjuna_sim.model.world import Movable
from tests.sim.builders import ROOM, ROOT, run, saved_world, simulator, texts

BOX = """<link name="{link}">{pose}<inertial><mass>{mass}</mass></inertial>
<collision name="c"><geometry><box><size>{size}</size></box></geometry></collision></link>"""


def _box(size: str = "1 1 1", link: str = "l", pose: str = "", mass: str = "2") -> str:
    return BOX.format(link=link, pose=pose, size=size, mass=mass)


def _model(name: str, inside: str, pose: str = "", static: bool = True) -> str:
    return f"<model name='{name}'><static>{str(static).lower()}</static>{pose}{inside}</model>"


def _position(path: Path, model: str) -> tuple[float, float, float]:
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
    assert _position(path, "pillar") == (2.0, 1.0, 0.5)
    pillar = next(body.part for body in world.bodies if body.model == "pillar")
    assert (pillar.shape.size, pillar.friction) == ((0.2, 1.0), 0.4)
    crate = next(body.part.shape.size for body in world.bodies if body.model == "crate")
    assert (crate, world.gravity[2]) == ((0.5, 0.4, 0.5), -5.0)
    assert world.movable == {"crate": Movable(7.0, None, False)}
    assert texts(world.notes) == ("plugin 'p': not simulated",)


def test_what_a_window_shows_and_what_answers_anyway_is_in_no_note(tmp_path: Path) -> None:
    tags = "<gui><plugin filename='MinimalScene' name='3D View'/></gui>"
    tags += "<plugin name='s' filename='libgazebo_ros_state.so'/><plugin name='p' filename='q'/>"
    world = load_world(saved_world(tmp_path, tags + _model("m", _box())))
    noted = [text for text in texts(world.notes) if "plugin" in text]
    assert noted == ["plugin 'p': not simulated"]


def test_placement_frame_has_the_pose(tmp_path: Path) -> None:
    model = _model("m", _box(pose="<pose>0 0 1 0 0 0</pose>"), "<pose>3 0 0 0 0 0</pose>")
    placed = model.replace("name='m'", "name='m' placement_frame='l'")
    assert _position(saved_world(tmp_path, placed), "m") == pytest.approx((3, 0, 0))


@pytest.mark.parametrize(
    ("inertial", "collision", "mass"),
    [
        ("<inertial auto='true'/>", "", 250.0),  # of water
        ("<inertial auto='true'><density>600</density></inertial>", "", 150.0),
        ("<inertial auto='true'/>", "<density>2000</density>", 500.0),
        ("<inertial auto='true'><mass>7</mass></inertial>", "", 250.0),
        ("<inertial auto='false'><mass>7</mass></inertial>", "", 7.0),
    ],
)
def test_links_may_be_weighed_by_their_shapes(
    tmp_path: Path, inertial: str, collision: str, mass: float
) -> None:
    solid = "<geometry><box><size>1 0.5 0.5</size></box></geometry>"
    link = f"<link name='l'>{inertial}<collision name='c'>{collision}{solid}</collision></link>"
    path = saved_world(tmp_path, f"<model name='m'>{link}</model>")
    assert load_world(path).movable["m"].mass == pytest.approx(mass)
    robot = tmp_path / "robot.sdf"
    robot.write_text(f"<sdf version='1.11'><model name='m'>{link}</model></sdf>", encoding="utf-8")
    found = load_robot(robot).urdf.links["l"].inertial
    assert found is not None
    assert found.mass == pytest.approx(mass)


@pytest.mark.parametrize(
    ("contact", "solid"),
    [
        ("<collide_bitmask>0x00</collide_bitmask>", False),
        ("<collide_bitmask> 0 </collide_bitmask>", False),
        ("<collide_bitmask>0x02</collide_bitmask>", True),
        ("<collide_bitmask>65535</collide_bitmask>", True),
        ("<collide_without_contact>1</collide_without_contact>", False),
        ("<collide_without_contact>0</collide_without_contact><ode/>", True),
    ],
)
def test_what_touches_nothing_is_not_solid(tmp_path: Path, contact: str, solid: bool) -> None:
    surface = f"<surface><contact>{contact}</contact></surface></collision>"
    wall = _model("m", _box().replace("</collision>", surface), "<pose>1 0 0 0 0 0</pose>")
    bodies = [body for body in load_world(saved_world(tmp_path, wall)).bodies if body.model == "m"]
    assert any(body.collides for body in bodies) is solid


def test_state_says_where_models_are(tmp_path: Path) -> None:
    state = "<state world_name='w'><model name='m'><pose>7 8 0 0 0 0</pose></model></state>"
    model = _model("m", _box(), "<pose>1 2 0 0 0 0</pose>")
    assert _position(saved_world(tmp_path, model + state), "m") == pytest.approx((7, 8, 0))


def test_two_models_of_a_name_get_two_names(tmp_path: Path) -> None:
    world = load_world(saved_world(tmp_path, _model("m", _box()) + _model("m", _box())))
    assert [b.model for b in world.bodies if b.model != "ground_plane"] == ["m", "m_1"]
    assert "model 'm': is there twice; the second is called 'm_1'" in texts(world.notes)


def test_shipped_map_is_the_shipped_room() -> None:
    by_map = simulator(ROOT / "maps" / "arjuna_room.yaml")
    by_file = simulator(ROOM)
    scans = [run(sim, 0.2).scan for sim in (by_map, by_file)]
    assert scans[0] is not None
    assert scans[1] is not None
    gap = np.abs(scans[0].ranges - scans[1].ranges)
    assert np.median(gap) < 0.06


def occupied(*rows: str) -> NDArray[np.bool_]:
    """Return cells, the first row lowest; `#` is occupied."""
    return np.array([[cell == "#" for cell in row] for row in rows])


@pytest.mark.parametrize(
    ("rows", "boxes"),
    [
        (("...", "..."), []),
        (("###", "###"), [(0, 0, 2, 3)]),
        (("#.#",), [(0, 0, 1, 1), (0, 2, 1, 1)]),
        (("##.", "##.", ".##"), [(0, 0, 2, 2), (2, 1, 1, 2)]),
        (("#..", "#..", "###"), [(0, 0, 2, 1), (2, 0, 1, 3)]),
        ((".#.", "...", ".#."), [(0, 1, 1, 1), (2, 1, 1, 1)]),  # a gap ends a run
    ],
)
def test_stacked_equal_runs_are_a_box(rows: tuple[str, ...], boxes: list[tuple[int, ...]]) -> None:
    assert list(map(tuple, rectangles(occupied(*rows)).tolist())) == boxes


def test_boxes_cover_what_is_occupied_once() -> None:
    rng = np.random.default_rng(5)
    for _ in range(30):
        cells = rng.random(tuple(rng.integers(1, 12, 2))) < rng.uniform(0.1, 0.9)
        count = np.zeros(cells.shape, int)
        for row, column, rows, columns in rectangles(cells):
            count[row : row + rows, column : column + columns] += 1
        assert (count == cells).all()


def saved(
    folder: Path, data: list[list[int]], origin: SE2 = IDENTITY, mode: str = "trinary"
) -> Path:
    grid = OccupancyGrid(GridFrame(0.5, len(data[0]), len(data), origin), np.array(data, np.int8))
    return save_map(grid, folder / "made", options=MapOptions(mode=mode))[0]


def test_walls_stand_where_the_map_has_them_on_the_floor(tmp_path: Path) -> None:
    path = saved(tmp_path, [[0, 100, 100], [-1, 0, 0]], SE2(1.0, 2.0, np.pi / 2))
    world = load_map_world(path)
    walls = [body for body in world.bodies if body.model == WALLS]
    assert [body.collides for body in walls] == [True, False]
    for body in walls:
        assert body.part.shape.size == pytest.approx((1.0, 0.5, 1.0))
        # The box's middle is 1 m along the map's x and 0.25 m along its y, a quarter turned.
        assert body.part.pose.position == pytest.approx((0.75, 3.0, 0.5))
        assert body.part.pose.planar().theta == pytest.approx(np.pi / 2)
    assert (world.path, world.name) == (path, "made")
    assert len(world.bodies) > len(walls)  # the floor


def test_too_many_walls_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = saved(tmp_path, [[100, 0, 100, 0, 100]])
    monkeypatch.setattr(world_file, "_BOXES_MAX", 3)
    load_map_world(path)
    monkeypatch.setattr(world_file, "_BOXES_MAX", 2)
    with pytest.raises(WorldError, match="has walls of 3 boxes; valid: up to 2"):
        load_map_world(str(path))


@pytest.mark.parametrize(
    "text", ['include "map.inc"', "# a maze\n\nwindow\n(\n)", "resolution 0.02"]
)
def test_worlds_of_stage_are_told_as_such(tmp_path: Path, text: str) -> None:
    path = tmp_path / "maze.world"
    path.write_text(f"{text}\nfloorplan\n( bitmap 'maze.png' )\n", encoding="utf-8")
    with pytest.raises(WorldError, match="is a world of Stage, not SDF; the YAML of a map"):
        load_world(path)


def test_a_map_that_does_not_exist_is_the_worlds_error(tmp_path: Path) -> None:
    with pytest.raises(WorldError, match=r"none\.yaml"):
        load_map_world(tmp_path / "none.yaml")


def test_cells_are_walls_from_65_per_cent_on(tmp_path: Path) -> None:
    world = load_map_world(saved(tmp_path, [[64, 65, 0, 100]], mode="raw"))
    walls = [body for body in world.bodies if body.model == WALLS and body.collides]
    assert [body.part.pose.position[0] for body in walls] == [0.75, 1.75]


_WORLD = shipped_file("worlds/pillar_arena.world")
_PILLARS = set(itertools.product((-1.1, 0.0, 1.1), repeat=2))


def test_pillars_stand_where_turtlebot3s_do() -> None:
    world = load_world(_WORLD)
    positions = {
        tuple(round(value, 6) for value in body.T_world_model.position[:2])
        for body in world.bodies
        if body.model.startswith("pillar")
    }
    assert positions == _PILLARS


@pytest.mark.parametrize("start", [(-2.0, -0.5), (-2.0, 0.0), (-1.5, 0.5)])
def test_starts_of_the_guides_are_free_and_inside(start: tuple[float, float]) -> None:
    """TurtleBot3 spawns at the first, a guide at the second, and its AMCL begins at the third."""
    sim = simulator(_WORLD, spawn=SE2(*start), robot=shipped_file("urdf/burger.urdf"))
    assert sim.robot.spawn == SE2(*start)
    assert not any("start" in note for note in sim.notes)


def test_the_shipped_map_lies_on_the_world() -> None:
    """Each surface at the lidar's height has an occupied cell within two cells, but for a tenth."""
    grid = load_map(shipped_file("maps/pillar_arena.yaml"))
    ends = surfaces(load_world(_WORLD), 0.17)
    middles = (ends[:, :2] + ends[:, 2:]) / 2.0
    frame, (rows, columns) = grid.frame, np.nonzero(grid.occupied())
    occupied = (np.column_stack((columns, rows)) + 0.5) * frame.resolution
    occupied += (frame.origin.x, frame.origin.y)
    gaps = np.linalg.norm(middles[:, None] - occupied[None], axis=2).min(axis=1)
    pillars = np.abs(middles).max(axis=1) < 1.3  # walls are seen from inside only
    assert np.mean(gaps[pillars] < 2.0 * frame.resolution) > 0.9
