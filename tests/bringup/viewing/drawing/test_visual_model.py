"""Claims: every link that can be seen is drawn, in its colour; the rest is said, not fatal."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
import trimesh

from bringup.viewing.drawing import visual_model

SHIPPED = Path(__file__).resolve().parents[4] / "urdf/arjuna.urdf"


def urdf(visual: str) -> str:
    return f"<robot name='r'><link name='base'><visual>{visual}</visual></link></robot>"


def scene(glb: bytes) -> trimesh.Scene:
    return trimesh.load_scene(io.BytesIO(glb), file_type="glb")


def nowhere(uri: str) -> Path | None:
    return None


def test_the_shipped_robot_is_drawn_whole() -> None:
    found = visual_model.read(SHIPPED.read_text(), nowhere)
    assert found.root == "base_footprint"
    assert not found.notes
    assert {"base_link", "front_left_wheel", "lidar_link", "camera_link"} <= set(found.glbs)


def test_a_box_stands_where_its_origin_says() -> None:
    text = urdf("<origin xyz='1 0 0'/><geometry><box size='0.2 0.4 0.6'/></geometry>")
    bounds = scene(visual_model.read(text, nowhere).glbs["base"]).bounds
    assert bounds == pytest.approx(np.array([[0.9, -0.2, -0.3], [1.1, 0.2, 0.3]]))


def test_an_sdf_model_is_drawn_as_its_urdf() -> None:
    box = "<geometry><box><size>0.2 0.4 0.6</size></box></geometry>"
    link = f"<link name='base'><visual name='v'><pose>1 0 0 0 0 0</pose>{box}</visual></link>"
    model = f"<sdf version='1.8'><model name='r'>{link}</model></sdf>"
    found = visual_model.read(model, nowhere)
    bounds = scene(found.glbs["base"]).bounds
    assert (found.root, found.name) == ("base", "r")
    assert bounds == pytest.approx(np.array([[0.9, -0.2, -0.3], [1.1, 0.2, 0.3]]))
    with pytest.raises(visual_model.VisualError, match="must hold a <model>"):
        visual_model.read("<sdf version='1.8'/>", nowhere)


def test_a_material_named_for_the_whole_robot_colours_its_links() -> None:
    text = urdf("<geometry><sphere radius='1'/></geometry><material name='red'/>").replace(
        "<link", "<material name='red'><color rgba='1 0 0 0.5'/></material><link", 1
    )
    (mesh,) = scene(visual_model.read(text, nowhere).glbs["base"]).geometry.values()
    assert mesh.visual.material.baseColorFactor.tolist() == [255, 0, 0, 128]


def test_a_mesh_is_found_and_scaled(tmp_path: Path) -> None:
    path = tmp_path / "cube.stl"
    trimesh.creation.box(extents=(1, 1, 1)).export(path)
    text = urdf("<geometry><mesh filename='package://p/cube.stl' scale='2 2 4'/></geometry>")
    found = visual_model.read(text, {"package://p/cube.stl": path}.get)
    extents = scene(found.glbs["base"]).extents
    assert extents == pytest.approx(np.array([2, 2, 4]))


def test_a_mesh_that_is_missing_is_noted() -> None:
    found = visual_model.read(urdf("<geometry><mesh filename='gone.stl'/></geometry>"), nowhere)
    assert found.glbs == {}
    assert found.notes == ("base: 'gone.stl' is not found; --package-path adds folders",)


@pytest.mark.parametrize("content", [b"", b"solid nothing"])
def test_a_mesh_that_is_broken_is_noted(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "broken.stl"
    path.write_bytes(content)
    found = visual_model.read(
        urdf("<geometry><mesh filename='broken.stl'/></geometry>"), lambda uri: path
    )
    assert len(found.notes) == 1


@pytest.mark.parametrize(
    "text",
    [
        "",
        "no xml",
        "<!DOCTYPE r [<!ENTITY x 'y'>]><robot name='r'><link name='&x;'/></robot>",
        "<robot name='r'/>",
    ],
)
def test_what_is_no_robot_is_refused(text: str) -> None:
    with pytest.raises(visual_model.VisualError, match="robot's description"):
        visual_model.read(text, nowhere)
