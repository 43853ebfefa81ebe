"""SDF's geometries and materials, tag by tag."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from arjuna_core.errors import WorldError
from arjuna_core.pose3 import ORIGIN
from arjuna_sim.files.sdf.geometry_tags import Placed, read_colour, read_friction, read_shape
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.shapes import GREY, Kind
from arjuna_sim.model.notes import NoteKind


def file(inside: str, folder: Path = Path()) -> XmlFile:
    text = f"<sdf><visual><geometry>{inside}</geometry>{inside}</visual></sdf>"
    return XmlFile(folder / "w.sdf", "sdf", WorldError, text.encode())


def read(inside: str, folder: Path = Path()) -> Placed | None:
    xml = file(inside, folder)
    return read_shape(xml, xml.child(xml.root, "visual/geometry", "w"), "it")


def placed(inside: str, folder: Path = Path()) -> Placed:
    found = read(inside, folder)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("inside", "kind", "size"),
    [
        ("<!-- a --><box><size>1 2 3</size></box>", Kind.BOX, (1.0, 2.0, 3.0)),
        ("<sphere><radius>0.5</radius></sphere>", Kind.SPHERE, (0.5,)),
        ("<ellipsoid><radii>1 2 3</radii></ellipsoid>", Kind.ELLIPSOID, (1.0, 2.0, 3.0)),
        ("<cylinder><length>2</length><radius>1</radius></cylinder>", Kind.CYLINDER, (1.0, 2.0)),
        ("<capsule><length>2</length><radius>1</radius></capsule>", Kind.CAPSULE, (1.0, 2.0)),
    ],
)
def test_a_shape_has_its_tags_sizes(inside: str, kind: Kind, size: tuple[float, ...]) -> None:
    shape, pose = placed(inside)
    assert (shape.kind, shape.size, pose) == (kind, size, ORIGIN)


@pytest.mark.parametrize(
    ("inside", "problem"),
    [
        ("", r"<geometry> is empty; valid: box, cylinder, .*, mesh"),
        ("<blob/>", r"<blob> is unknown; valid: box"),
        ("<box/>", r"lacks <size>"),
        ("<box><size>1 2</size></box>", r"has 2 numbers"),
        ("<sphere><radius>0</radius></sphere>", r"must be above zero"),
        ("<plane><normal>0 0 0</normal></plane>", r"<normal>.*must not be zero"),
        ("<polyline><point>0 0</point><point>1 0</point></polyline>", r"<polyline> has 2 corners"),
    ],
)
def test_what_is_no_shape_is_refused(inside: str, problem: str) -> None:
    with pytest.raises(WorldError, match=problem):
        read(inside)


@pytest.mark.parametrize(
    ("inside", "kind"),
    [("<empty/>", NoteKind.IGNORED), ("<image/>", NoteKind.UNSUPPORTED)],
)
def test_what_is_not_simulated_is_noted(inside: str, kind: NoteKind) -> None:
    xml = file(inside)
    assert read_shape(xml, xml.child(xml.root, "visual/geometry", "w"), "it") is None
    assert [note.kind for note in xml.notes] == [kind]


@pytest.mark.parametrize(
    "normal", [(0, 0, 1), (0, 0, -2), (1, 0, 0), (0, -3, 0), (1, 2, 3), (-1, 0.5, -0.2)]
)
def test_a_planes_z_is_its_normal(normal: tuple[float, float, float]) -> None:
    shape, pose = placed(f"<plane><normal>{' '.join(map(str, normal))}</normal></plane>")
    assert shape.kind is Kind.PLANE
    expected = np.array(normal) / math.sqrt(sum(value**2 for value in normal))
    np.testing.assert_allclose(pose.rotation()[:, 2], expected, atol=1e-9)
    assert placed("<plane/>")[1].rotation() == pytest.approx(np.eye(3))


POINTS = "".join(f"<point>{x} {y}</point>" for x, y in ((0, 0), (2, 0), (2, 3), (0, 3)))


def test_cones_and_polylines_are_meshes_the_same_for_the_same() -> None:
    for inside, high in (
        (f"<polyline>{POINTS}<height>0.5</height></polyline>", (2.0, 3.0, 0.5)),
        (f"<polyline>{POINTS}</polyline>", (2.0, 3.0, 1.0)),
        ("<cone><radius>0.5</radius><length>2</length></cone>", (0.5, 0.5, 1.0)),
    ):
        xml = file(inside)
        geometry = xml.child(xml.root, "visual/geometry", "w")
        first, again = (read_shape(xml, geometry, "it") for _ in range(2))
        assert first is not None
        assert again is not None
        mesh = first[0].mesh
        assert mesh is not None
        assert first[0].size == (1.0, 1.0, 1.0)
        assert again[0].mesh is mesh
        assert mesh.triangles.reshape(-1, 3).max(axis=0) == pytest.approx(high)
        assert str(mesh.path).startswith("w.sdf#")


def test_a_heightmap_has_its_first_row_at_the_far_side(tmp_path: Path) -> None:
    picture = np.array([[0, 51, 102], [153, 204, 255]], np.uint8)
    Image.fromarray(picture).save(tmp_path / "hill.png")
    inside = "<heightmap><uri>hill.png</uri>{}</heightmap>"
    given = "<size>4 2 3</size><pos>1 2 3</pos>"
    shape, pose = placed(inside.format(given), tmp_path)
    assert shape.terrain is not None
    assert (shape.kind, shape.size, pose.position) == (Kind.TERRAIN, (4, 2, 3), (1, 2, 3))
    np.testing.assert_allclose(shape.terrain.heights, [[0.6, 0.8, 1.0], [0.0, 0.2, 0.4]])
    plain, pose = placed(inside.format(""), tmp_path)
    assert (plain.size, pose) == ((1.0, 1.0, 1.0), ORIGIN)
    xml = file(inside.format("").replace("hill", "none"), tmp_path)
    assert read_shape(xml, xml.child(xml.root, "visual/geometry", "w"), "it") is None
    (note,) = xml.notes
    assert (note.kind, note.text) == (
        NoteKind.MISSING,
        "it: heightmap 'none.png' does not exist, so it is left out",
    )


@pytest.mark.parametrize(
    ("material", "colour"),
    [
        ("", GREY),
        ("<diffuse>0.1 0.2 0.3 0.4</diffuse><ambient>1 1 1 1</ambient>", (0.1, 0.2, 0.3, 0.4)),
        ("<diffuse>0.1 0.2 0.3</diffuse>", (0.1, 0.2, 0.3, 1.0)),
        ("<ambient>0.5 0.6 0.7 1</ambient>", (0.5, 0.6, 0.7, 1.0)),
        ("<script><name>Gazebo/Nobody</name></script>", GREY),
    ],
)
def test_a_colour_is_diffuse_before_ambient(material: str, colour: tuple[float, ...]) -> None:
    xml = file(f"<material>{material}</material>")
    assert read_colour(xml, xml.child(xml.root, "visual", "w"), "it") == pytest.approx(colour)


@pytest.mark.parametrize(
    ("surface", "friction", "said"),
    [
        ("<friction><ode><mu>0.5</mu></ode></friction>", 0.5, ()),
        ("<friction><ode><mu>1</mu><slip1>1</slip1></ode></friction>", 1.0, ("slip1",)),
        (
            "<bounce><restitution_coefficient>1</restitution_coefficient></bounce>",
            None,
            ("restitution_coefficient",),
        ),
        ("<bounce><restitution_coefficient>0</restitution_coefficient></bounce>", None, ()),
    ],
)
def test_what_a_surface_does_beside_rubbing_is_noted(
    surface: str, friction: float | None, said: tuple[str, ...]
) -> None:
    xml = file(f"<surface>{surface}</surface>")
    assert read_friction(xml, xml.child(xml.root, "visual", "w"), "it") == friction
    assert [note.text for note in xml.notes] == [f"it: <{tag}>: not simulated" for tag in said]


@pytest.mark.parametrize(("mask", "noted"), [("0xFF", False), ("65535", False), ("0x02", True)])
def test_what_touches_some_things_only_is_noted(mask: str, noted: bool) -> None:
    xml = file(f"<surface><contact><collide_bitmask>{mask}</collide_bitmask></contact></surface>")
    read_friction(xml, xml.child(xml.root, "visual", "w"), "it")
    text = f"it: <collide_bitmask> {mask}: it touches everything"
    assert [note.text for note in xml.notes] == [text] * noted
