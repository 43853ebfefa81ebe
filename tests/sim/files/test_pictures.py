"""Pictures of materials are found however files name them, and drawn upright."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from arjuna_core.errors import WorldError
from arjuna_core.files.shipped import shipped_file
from arjuna_core.se2 import SE2
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.camera import focal_length
from arjuna_sim.devices.sensors.camera import CameraSettings
from arjuna_sim.files.sdf.world import read_world
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.urdf.links_and_joints import read_urdf
from arjuna_sim.files.world_file import load_world
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.inputs import named_robot
from arjuna_sim.model.world import World
from arjuna_sim.simulation import Simulation, solo
from tests.sim.builders import first

PBR = "<pbr><metal><albedo_map>{}</albedo_map></metal></pbr>"
OGRE = (
    "<script><uri>model://board/materials/scripts</uri>"
    "<uri>model://board/materials/textures</uri><name>Board/Face</name></script>"
)
COLOURS = {"red": (200, 0, 0), "green": (0, 200, 0), "blue": (0, 0, 200), "white": (200,) * 3}


def four_colours(path: Path) -> Path:
    """Write a picture of red and green above blue and white."""
    path.parent.mkdir(parents=True, exist_ok=True)
    pixels = np.array([*COLOURS.values()], np.uint8).reshape(2, 2, 3)
    Image.fromarray(pixels).save(path)
    return path


BOX, BALL = "<box><size>0.02 0.5 0.5</size></box>", "<sphere><radius>0.3</radius></sphere>"


def world_of(folder: Path, material: str, geometry: str = BOX) -> World:
    """Return a world with one board that has a material, "" for none."""
    shape, material = (
        f"<geometry>{geometry}</geometry>",
        material and f"<material>{material}</material>",
    )
    text = (
        "<sdf version='1.7'><world name='w'><model name='board'><static>1</static>"
        f"<pose>1.21 0 0.16 0 0 0</pose><link name='l'><collision name='c'>{shape}</collision>"
        f"<visual name='v'>{shape}{material}</visual></link></model>"
        "</world></sdf>"
    )
    xml = XmlFile(folder / "w.world", "sdf", WorldError, text.encode(), SearchPath.of([folder]))
    return read_world(xml)


def drawn(world: World) -> list[Path]:
    pictures = (body.part.picture for body in world.bodies)
    return [picture.path for picture in pictures if picture is not None]


def test_physically_based_material_names_its_picture(tmp_path: Path) -> None:
    path = four_colours(tmp_path / "media" / "face.png")
    world = world_of(tmp_path, PBR.format("media/face.png"))
    assert drawn(world) == [path]
    assert not [note for note in world.notes if "picture" in note.text]


def test_script_of_ogre_names_its_picture(tmp_path: Path) -> None:
    materials = tmp_path / "board" / "materials"
    path = four_colours(materials / "textures" / "face.png")
    (materials / "scripts").mkdir()
    script = "material Board/Other\n{ texture_unit { texture other.png } }\n"
    script += (
        "material Board/Face\n{\n technique { pass { texture_unit {\n texture face.png\n } } }\n}\n"
    )
    (materials / "scripts" / "board.material").write_text(
        script.replace("{ texture o", "{\n texture o")
    )
    assert drawn(world_of(tmp_path, OGRE)) == [path]


def test_texture_of_a_urdf_is_its_picture(tmp_path: Path) -> None:
    path = four_colours(tmp_path / "face.png")
    text = (
        "<robot name='r'><link name='l'><visual><geometry><box size='1 1 1'/></geometry>"
        "<material name='m'><texture filename='face.png'/></material></visual></link></robot>"
    )
    urdf = read_urdf(XmlFile(tmp_path / "r.urdf", "robot", WorldError, text.encode()))
    (part,) = urdf.links["l"].visuals
    assert part.picture is not None
    assert part.picture.path == path


def test_what_is_missing_broken_or_without_a_place_is_noted(tmp_path: Path) -> None:
    four_colours(tmp_path / "face.png")
    (tmp_path / "no.png").write_text("no picture")
    for material, geometry, problem in (
        (PBR.format("nowhere.png"), BOX, "does not exist"),
        (PBR.format("no.png"), BOX, "cannot be read"),
        (PBR.format("face.png"), BALL, "the mean colour is drawn"),
    ):
        world = world_of(tmp_path, material, geometry)
        assert drawn(world) == []
        (note,) = (note for note in world.notes if "picture" in note.text)
        assert problem in note.text
    (ball,) = (b.part for b in world.bodies if b.model == "board" and not b.collides)
    assert ball.rgba == pytest.approx((100 / 255, 100 / 255, 100 / 255, 1.0))


def seen_from(world: World, start: SE2) -> np.ndarray:
    """Return what the shipped robot's camera sees from a pose."""
    rng = np.random.default_rng(0)
    sim = Simulation(solo(named_robot("", ""), start), world, SimulatorConfig(), rng)
    picture = sim.robot.picture(first(sim.robot.model, CameraSettings)).color
    sim.close()
    assert picture is not None
    return picture


OBJ = (
    "mtllib b.mtl\nv 0 .25 -.25\nv 0 -.25 -.25\nv 0 -.25 .25\nv 0 .25 .25\n"
    "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl face\nf 1/1 2/2 3/3 -1/-1\n"
)
MTL = "newmtl face\nKd 1 1 1\nmap_Kd face.png\n"
DAE = (Path(__file__).parent / "board.dae").read_text()
"""Shapes that carry the picture: files beside it, the geometry, and whose picture it is."""
FORMS = {
    "box": ({}, "<box><size>.02 .5 .5</size></box>", True),
    "obj": ({"b.obj": OBJ, "b.mtl": MTL}, "<mesh><uri>b.obj</uri></mesh>", False),
    "obj, the world's": ({"b.obj": OBJ}, "<mesh><uri>b.obj</uri></mesh>", True),
    "dae": ({"b.dae": DAE}, "<mesh><uri>b.dae</uri></mesh>", False),
}


@pytest.mark.parametrize("form", FORMS)
def test_picture_stands_upright_before_the_camera(tmp_path: Path, form: str) -> None:
    four_colours(tmp_path / "face.png")
    files, geometry, of_world = FORMS[form]
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    world = world_of(tmp_path, PBR.format("face.png") if of_world else "", geometry)
    assert drawn(world) == [tmp_path / "face.png"]
    for start in (SE2(), SE2(2.42, 0.0, np.pi)) if form == "box" else (SE2(),):
        picture = seen_from(world, start).astype(int)
        rows, columns = 480 // 2 + np.array([-40, 40]), 640 // 2 + np.array([-40, 40])
        for spot, colour in zip(
            picture[np.ix_(rows, columns)].reshape(-1, 3), COLOURS.values(), strict=True
        ):
            assert ((spot > 60) == (np.array(colour) > 0)).all(), (spot, colour)


def test_plane_has_its_picture_on_its_size_the_top_to_the_left(tmp_path: Path) -> None:
    path = four_colours(tmp_path / "face.png")
    plane = "<plane><normal>0 0 1</normal><size>4 2</size></plane>"
    world = world_of(tmp_path, PBR.format("face.png"), plane)
    assert drawn(world) == [path]
    (sheet,) = (b.part.shape.mesh for b in world.bodies if b.part.picture is not None)
    assert sheet is not None
    assert sheet.skin is not None
    corners, places = sheet.triangles.reshape(-1, 3), sheet.skin.places.reshape(-1, 2)
    assert corners[:, 0] == pytest.approx(4 * places[:, 0] - 2)
    assert corners[:, 1] == pytest.approx(1 - 2 * places[:, 1])


def test_mesh_of_two_materials_is_drawn_in_both(tmp_path: Path) -> None:
    second = "v 1 0 0\nv 1 1 0\nv 1 1 1\nusemtl plain\nf 5 6 7\nusemtl again\nf 5 6 7\n"
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "b.obj").write_text(OBJ + second)
    (tmp_path / "meshes" / "b.mtl").write_text(
        MTL + "newmtl plain\nKd 1 .5 0\nnewmtl again\nKd 1 .5 0\n"
    )
    four_colours(tmp_path / "materials" / "textures" / "face.png")  # not beside it
    world = world_of(tmp_path, "", "<mesh><uri>meshes/b.obj</uri></mesh>")
    looks = [b.part for b in world.bodies if b.model == "board" and not b.collides]
    assert sorted(len(part.shape.mesh.triangles) for part in looks if part.shape.mesh) == [2, 2]
    (plain,) = (part for part in looks if part.picture is None)
    assert plain.rgba == pytest.approx((1.0, 0.5, 0.0, 1.0), abs=0.01)
    (solid,) = (b.part for b in world.bodies if b.model == "board" and b.collides)
    assert solid.shape.mesh is not None
    assert len(solid.shape.mesh.triangles) == 4


def test_apriltag_is_found_where_it_stands() -> None:
    detector = pytest.importorskip("pupil_apriltags", reason="the detector is not installed")
    robot = named_robot("", "")
    camera = robot.settings.first(CameraSettings)
    assert camera is not None
    world = load_world(shipped_file("worlds/apriltag.world"))
    grey = seen_from(world, SE2()).mean(axis=2).astype(np.uint8)
    f, middle = focal_length(camera), (camera.width / 2, camera.height / 2)
    (found,) = detector.Detector(families="tag36h11").detect(
        grey, estimate_tag_pose=True, camera_params=(f, f, *middle), tag_size=0.2
    )
    assert found.tag_id == 0
    # 1 m before the camera, 0.09 m higher
    assert found.pose_t.ravel() == pytest.approx((0.0, -0.09, 1.0), abs=0.01)
    assert found.pose_R == pytest.approx(np.eye(3), abs=0.06)
