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


def world_of(folder: Path, material: str, geometry: str = "box") -> World:
    """Return a world with one board that has a material."""
    size = "<size>0.02 0.5 0.5</size>" if geometry == "box" else "<radius>0.3</radius>"
    shape = f"<geometry><{geometry}>{size}</{geometry}></geometry>"
    text = (
        "<sdf version='1.7'><world name='w'><model name='board'><static>1</static>"
        f"<pose>1.21 0 0.16 0 0 0</pose><link name='l'><collision name='c'>{shape}</collision>"
        f"<visual name='v'>{shape}<material>{material}</material></visual></link></model>"
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


def test_what_is_missing_broken_or_on_no_box_is_noted(tmp_path: Path) -> None:
    four_colours(tmp_path / "face.png")
    (tmp_path / "no.png").write_text("no picture")
    for material, geometry, problem in (
        (PBR.format("nowhere.png"), "box", "does not exist"),
        (PBR.format("no.png"), "box", "cannot be read"),
        (PBR.format("face.png"), "sphere", "the mean colour is drawn"),
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
    picture = sim.robot.picture().color
    sim.close()
    assert picture is not None
    return picture


@pytest.mark.parametrize("start", [SE2(), SE2(2.42, 0.0, np.pi)])
def test_picture_stands_upright_before_the_camera(tmp_path: Path, start: SE2) -> None:
    four_colours(tmp_path / "face.png")
    picture = seen_from(world_of(tmp_path, PBR.format("face.png")), start).astype(int)
    rows, columns = 480 // 2 + np.array([-40, 40]), 640 // 2 + np.array([-40, 40])
    for spot, colour in zip(
        picture[np.ix_(rows, columns)].reshape(-1, 3), COLOURS.values(), strict=True
    ):
        assert ((spot > 60) == (np.array(colour) > 0)).all(), (spot, colour)


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
