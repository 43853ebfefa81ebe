"""An SDF world's pieces."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.geometry.shapes import Kind
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.robot import SOLO
from arjuna_sim.model.world import GROUND, World
from tests.sim.builders import run, saved_world, simulator, texts
from tests.sim.world_cases import WorldMaker, write_stl

LINK = "<link name='{name}'>{pose}<collision name='c'><geometry>{shape}</geometry></collision>\
{inertial}</link>"


def _link(shape: str, name: str = "l", pose: str = "", inertial: str = "") -> str:
    return LINK.format(shape=shape, name=name, pose=pose, inertial=inertial)


def _static(inside: str, name: str = "m", pose: str = "") -> str:
    return f"<model name='{name}'><static>1</static>{pose}{inside}</model>"


def _loaded(folder: Path, inside: str) -> World:
    return load_world(saved_world(folder, inside))


@pytest.mark.parametrize("seed", range(12))
def test_nested_and_included_models_stand_where_they_were_put(tmp_path: Path, seed: int) -> None:
    case = WorldMaker(tmp_path, seed).make(6)
    world = load_world(case.path)
    found = {
        round(body.part.shape.size[0], 6): body.part.pose.position
        for body in world.bodies
        if body.collides and body.part.shape.kind is Kind.BOX
    }
    assert set(found) == set(case.positions)
    for edge, point in case.positions.items():
        assert found[edge] == pytest.approx(point, abs=1e-9)
    given = " ".join(texts(world.notes))
    assert all(name in given for name in case.left_out)
    assert world.movable == {}
    simulator(case.path)


def test_friction_that_is_no_number_costs_no_shape(tmp_path: Path) -> None:
    rubs = "<surface><friction><ode><mu>inf</mu></ode></friction></surface></collision>"
    world = _loaded(
        tmp_path, _static(_link("<box><size>1 1 1</size></box>"), "m").replace("</collision>", rubs)
    )
    (body,) = (body for body in world.bodies if body.model == "m")
    assert body.part.friction is None
    assert any("'inf' must be finite" in note for note in texts(world.notes))


BOX = "<box><size>1 1 1</size></box>"
_SOLID = f"<collision name='c'><geometry>{BOX}</geometry></collision>"
STL = "<mesh><uri>{}</uri></mesh>"


@pytest.mark.parametrize(
    "uri",
    [
        "file://models/crate/meshes/a.stl",
        "models/crate/meshes/a.stl",
        "model://crate/meshes/a.stl",
        "model:///crate/meshes/a.stl",
        "file:///home/somebody/ws/src/shop/models/crate/meshes/a.stl",
        "package://shop/models/crate/meshes/a.stl",
        "https://fuel.gazebosim.org/1.0/Someone/models/crate/2/files/meshes/a.stl",
    ],
)
def test_mesh_is_found_however_it_is_called(tmp_path: Path, uri: str) -> None:
    package = tmp_path / "src" / "shop"
    (package / "models" / "crate" / "meshes").mkdir(parents=True)
    (package / "worlds").mkdir()
    (package / "package.xml").write_text("<package><name>shop</name></package>", encoding="utf-8")
    triangles = np.random.default_rng(0).random((8, 3, 3))
    write_stl(package / "models" / "crate" / "meshes" / "a.stl", triangles)
    path = saved_world(package / "worlds", _static(_link(STL.format(uri))))
    world = load_world(path, SearchPath())
    assert [b.part.shape.kind for b in world.bodies if b.model == "m"] == [Kind.MESH]


@pytest.mark.parametrize("version", ["", "/1", "/tip"])
def test_downloaded_models_are_found_by_their_address(tmp_path: Path, version: str) -> None:
    for number, edge in ((1, 1.0), (3, 3.0), (12, 12.0)):
        folder = tmp_path / "fuel" / "fuel.gazebosim.org" / "openrobotics" / "models" / "big box"
        folder = folder / str(number)
        folder.mkdir(parents=True)
        shape = f"<box><size>{edge} 1 1</size></box>"
        text = f"<sdf version='1.6'>{_static(_link(shape))}</sdf>"
        (folder / "box.sdf").write_text(text, encoding="utf-8")
        manifest = "<model><sdf version='1.6'>box.sdf</sdf><sdf version='1.4'>old.sdf</sdf></model>"
        (folder / "model.config").write_text(manifest, encoding="utf-8")
    uri = f"https://fuel.gazebosim.org/1.0/OpenRobotics/models/Big%20Box{version}"
    path = saved_world(tmp_path, f"<include>\n<uri>\n {uri}\n</uri></include>")
    world = load_world(path, SearchPath(caches=(tmp_path / "fuel",)))
    edge = next(b.part.shape.size[0] for b in world.bodies if b.model == "m")
    assert edge == (1.0 if version == "/1" else 12.0)
    (note,) = load_world(path, SearchPath()).notes[:1]
    assert note.kind is NoteKind.MISSING


def test_what_is_broken_is_left_out_and_the_rest_stands(tmp_path: Path) -> None:
    (tmp_path / "torn").mkdir()
    (tmp_path / "torn" / "model.sdf").write_text("<sdf version='1.6'><model", encoding="utf-8")
    world = _loaded(
        tmp_path,
        "<include><uri>model://torn</uri></include>"
        + _static(_link(BOX), "fallen", "<pose>1 2 -7.5e8 0 0 0</pose>")
        + _static(_link("<box><size>0 1 1</size></box>") + _link(BOX, "good"), "half")
        + _static(_link(BOX, pose="<pose>1 2</pose>") + _link(BOX, "good"), "other")
        + "<model name='empty'/>",
    )
    assert [b.model for b in world.bodies if b.model != GROUND] == ["half", "other"]
    broken = [note.text for note in world.notes if note.kind is NoteKind.BROKEN]
    assert len(broken) == 4
    for what, text in zip(("model://torn", "'fallen'", "'half'", "'other'"), broken, strict=True):
        assert re.search(f"{what}.* is left out: ", text)


def _drawn(shape: str) -> str:
    return f"<visual name='v'><geometry>{shape}</geometry></visual>"


@pytest.mark.parametrize(
    ("visual", "drawn"),
    [
        ("", 0),
        (_drawn("<sphere><radius>1</radius></sphere>"), 1),
        (_drawn("<mesh><uri>model://none/m.stl</uri></mesh>"), 1),
        (_drawn("<empty/>"), 0),
    ],
)
def test_a_collision_is_drawn_where_no_visual_can_be(
    tmp_path: Path, visual: str, drawn: int
) -> None:
    world = _loaded(tmp_path, _static(f"<link name='l'>{_SOLID}{visual}</link>"))
    found = [body.collides for body in world.bodies if body.model == "m"]
    assert found == [True] + [False] * drawn
    assert any("is drawn, as no <visual>" in t for t in texts(world.notes)) == ("mesh" in visual)


def test_what_a_urdf_says_otherwise_is_noted_and_left_out_as_gazebo_does(tmp_path: Path) -> None:
    inertial = "<inertial><origin xyz='9 0 0'/><mass value='5'/></inertial>"
    solid = _SOLID.replace("<geometry>", "<origin xyz='9 0 0'/><geometry>")
    world = _loaded(tmp_path, f"<model name='m'><link name='l'>{inertial}{solid}</link></model>")
    (body,) = (body for body in world.bodies if body.model == "m")
    assert body.part.pose.position == (0.0, 0.0, 0.0)
    assert world.movable["m"].mass == 1.0  # SDF's default
    said = "model 'm': <origin> of <collision>, <inertial>: no tag of SDF, and left out, as Gazebo"
    assert f"{said} does; <pose> places it" in texts(world.notes)


def test_an_actor_of_links_is_as_they_are_and_as_high_as_it_begins(tmp_path: Path) -> None:
    way = "".join(
        f"<waypoint><time>{t}</time><pose>{t} 1 0.5 0 0 0</pose></waypoint>" for t in (0, 2)
    )
    script = f"<script><trajectory id='0' type='square'>{way}</trajectory></script>"
    link = f"<link name='l'><pose>0 0 0.2 0 0 0</pose>{_drawn(BOX)}</link>"
    (cart,) = _loaded(tmp_path, f"<actor name='cart'>{link}{script}</actor>").actors
    (part,) = cart.parts
    assert part.shape.kind is Kind.BOX
    assert part.pose.position == pytest.approx((0.0, 0.0, 0.7))
    assert cart.start == SE2(0.0, 1.0, 0.0)


@pytest.mark.parametrize(
    ("factor", "noted"), [("1.0", False), ("0", False), ("2", True), ("fast", True)]
)
def test_a_pace_that_the_file_asks_for_is_noted(tmp_path: Path, factor: str, noted: bool) -> None:
    tag = f"<physics type='ode'><real_time_factor>{factor}</real_time_factor></physics>"
    world = _loaded(tmp_path, tag + _static(_link(BOX)))
    assert any("real_time_factor" in text for text in texts(world.notes)) == noted


@pytest.mark.parametrize(
    ("tag", "most"), [("latitude_deg", 90.0), ("longitude_deg", -360.0), ("heading_deg", 360.0)]
)
def test_a_place_on_earth_has_angles_up_to_a_turn(tmp_path: Path, tag: str, most: float) -> None:
    place = f"<spherical_coordinates><{tag}>{{:g}}</{tag}></spherical_coordinates>"
    nowhere = _loaded(tmp_path, "")
    assert _loaded(tmp_path, place.format(most)).notes == nowhere.notes
    beyond = _loaded(tmp_path, place.format(1.1 * most))
    (text,) = set(texts(beyond.notes)) - set(texts(nowhere.notes))
    assert text.endswith(f"<{tag}> is {1.1 * most:g}; valid: up to {abs(most):g}")
    assert beyond.earth == nowhere.earth


def test_world_with_a_flat_mesh_loads_and_the_robot_meets_it(tmp_path: Path) -> None:
    sheet = np.array(
        [[(1, -1, 0), (1, 1, 0), (1.3, 1, 1)], [(1, -1, 0), (1.3, 1, 1), (1.3, -1, 1)]]
    )
    write_stl(tmp_path / "sheet.stl", sheet)
    write_stl(tmp_path / "one.stl", np.array([[(3, -1, 0), (3, 1, 0), (3, 0, 1)]]))
    shapes = "".join(_link(STL.format(f"{name}.stl"), name) for name in ("sheet", "one"))
    sim = simulator(saved_world(tmp_path, _static(shapes, "sheets")))
    last = run(sim, 6.0, Velocity(0.4))
    assert last.contacts == ("sheets",)
    assert last.truth.pose.x < 1.0


def test_heavy_mesh_of_many_faces_stands_and_so_does_the_robot(tmp_path: Path) -> None:
    ring = trimesh.creation.annulus(0.4, 0.9, 1.0, sections=60).triangles
    write_stl(tmp_path / "ring.stl", np.add(ring, (0.0, 0.0, 0.5)))
    mass = "<inertial><mass>400</mass></inertial>"
    link = _link(STL.format("ring.stl"), inertial=mass)
    pose = "<pose>3 0 0.01 0 0 0</pose>"
    path = saved_world(tmp_path, f"<model name='ring'>{pose}{link}</model>")
    sim = simulator(path)
    assert any(re.search("'ring'.*convex pieces, within", note) for note in sim.notes)
    last = run(sim, 4.0)
    assert abs(last.truth.z) < 0.02
    assert sim.stage.motion("ring").pose.position == pytest.approx((3.0, 0.0, 0.0), abs=0.02)


DOOR = """<model name='door'><pose>2 0 0 0 0 0</pose>
<link name='frame'><pose>0 -0.6 0.5 0 0 0</pose>{frame}</link>
<link name='leaf'><pose>0 0 0.5 0 0 0</pose>{leaf}<inertial><mass>2</mass></inertial></link>
<joint name='fix' type='fixed'><parent>world</parent><child>frame</child></joint>
<joint name='hinge' type='revolute'><parent>frame</parent><child>leaf</child>
<pose>0 -0.5 0 0 0 0</pose><axis><xyz>0 0 1</xyz><limit><lower>-1.2</lower><upper>1.2</upper>
</limit></axis></joint></model>"""


def test_door_swings_open_when_the_robot_pushes_it(tmp_path: Path) -> None:
    shape = "<collision name='c'><geometry><box><size>{}</size></box></geometry></collision>"
    frame, leaf = (shape.format(size) for size in ("0.1 0.1 1", "0.05 0.9 1"))
    sim = simulator(saved_world(tmp_path, DOOR.format(frame=frame, leaf=leaf)))
    assert {e.name for e in sim.stage.entities} == {"door", "door::leaf"}
    run(sim, 1.0)
    assert sim.stage.motion("door::leaf").pose.position == pytest.approx((2, 0, 0.5), abs=1e-6)
    last = run(sim, 7.0, Velocity(0.4))
    leaf_pose = sim.stage.motion("door::leaf").pose
    assert last.truth.pose.x > 2.0
    hinge = leaf_pose.apply(np.array([[0.0, -0.5, 0.0]]))[0]
    assert hinge == pytest.approx((2.0, -0.5, 0.5), abs=1e-3)
    assert abs(leaf_pose.rpy()[2]) > 0.8


def test_what_gravity_leaves_alone_floats_and_links_apart_move_apart(tmp_path: Path) -> None:
    ball = "<sphere><radius>0.1</radius></sphere>"
    no = "<gravity>0</gravity>"
    two = _link(ball, "a", "<pose>1 1 0.1 0 0 0</pose>") + _link(
        ball, "b", "<pose>1 3 2 0 0 0</pose>"
    )
    lamp = _link(ball, pose="<pose>4 4 2 0 0 0</pose>", inertial=no)
    sim = simulator(
        saved_world(tmp_path, f"<model name='two'>{two}</model><model name='lamp'>{lamp}</model>")
    )
    run(sim, 2.0)
    heights = {n: sim.stage.motion(n).pose.position[2] for n in ("two", "two::b", "lamp")}
    assert heights == pytest.approx({"two": 0.1, "two::b": 0.1, "lamp": 2.0}, abs=0.01)


def test_shapes_are_met_where_they_are(tmp_path: Path) -> None:
    """A ray along x meets each shape at its closed-form distance."""
    polyline = "".join(
        f"<point>{x} {y}</point>" for x, y in ((0, -1), (2, -1), (2, 1), (0, 1), (0.5, 0))
    )
    shapes = {
        "<ellipsoid><radii>0.5 1 2</radii></ellipsoid>": -0.5,
        "<capsule><radius>0.3</radius><length>1</length></capsule>": -0.3,
        "<cone><radius>0.5</radius><length>2</length></cone>": -0.5 * (1.0 - 0.28) / 2.0,
        f"<polyline>{polyline}<height>2</height></polyline>": 0.5,
        "<plane><normal>-1 0 0</normal></plane>": 0.0,
    }
    for shape, front in shapes.items():
        pose = "<pose>3 0 0 0 0 0</pose>"
        sim = simulator(saved_world(tmp_path, _static(_link(shape), pose=pose)))
        scan = run(sim, 0.2).scan
        assert scan is not None
        ahead = scan.ranges[np.argmin(np.abs(scan.angles))]
        lidar = sim.robot.model.urdf.T_root("lidar_link").position
        height = sim.stage.scene.robots[SOLO].support.ride_height + lidar[2]
        if "cone" in shape:
            front = -0.5 * (1.0 - height) / 2.0
        elif "ellipsoid" in shape:
            front = -0.5 * np.sqrt(1.0 - (height / 2.0) ** 2)
        assert ahead + lidar[0] == pytest.approx(3.0 + front, abs=0.03), shape


def test_robot_stands_on_a_terrain(tmp_path: Path) -> None:
    ramp = np.tile(np.linspace(0, 65535, 65), (65, 1)).astype(np.uint16)
    Image.fromarray(ramp).save(tmp_path / "ramp.png")
    terrain = "<heightmap><uri>file://ramp.png</uri><size>20 20 2</size></heightmap>"
    path = saved_world(tmp_path, _static(_link(terrain), "hills"))
    world = load_world(path)
    assert [body.model for body in world.bodies] == ["hills"]
    last = run(simulator(path), 3.0)
    assert last.truth.z == pytest.approx(1.0, abs=0.05)
    assert last.truth.pitch == pytest.approx(-np.arctan(0.1), abs=0.01)


def test_model_without_a_mass_is_as_heavy_as_its_shapes(tmp_path: Path) -> None:
    link = _link("<box><size>1 1 0.1</size></box>", inertial="<inertial><mass>0</mass></inertial>")
    world = _loaded(tmp_path, f"<model name='plank'>{link}</model>")
    assert set(world.movable) == {"plank"}
    assert world.movable["plank"].mass == pytest.approx(50.0)
    assert "model 'plank': has no mass; it gets 50 kg, by its shapes" in texts(world.notes)


def test_model_of_too_great_a_mass_gets_the_greatest(tmp_path: Path) -> None:
    heavy = "<inertial><mass>1.1e7</mass></inertial>"
    link = _link("<box><size>1 1 1</size></box>", inertial=heavy)
    world = _loaded(tmp_path, f"<model name='rock'>{link}</model>")
    assert world.movable["rock"].mass == 1e7
    assert "model 'rock': weighs 1.1e+07 kg; it gets 1e+07 kg" in texts(world.notes)


def test_world_with_macros_and_strange_prefixes_loads(tmp_path: Path) -> None:
    path = tmp_path / "w.sdf.xacro"
    head = "<sdf version='1.6' xmlns:xacro='http://www.ros.org/wiki/xacro'><world name='w'>"
    arg = "<xacro:arg name='edge' default='2'/>"
    box = "<box><size>$(arg edge) 1 1</size></box>"
    path.write_text(f"{head}{arg}{_static(_link(box))}</world></sdf>", encoding="utf-8")
    assert load_world(path).bodies[0].part.shape.size == (2.0, 1.0, 1.0)
    strange = "<plugin name='p' filename='f'><gz:system gz:speed='1'/></plugin>"
    assert _loaded(tmp_path, strange + _static(_link(BOX))).bodies[0].model == "m"
