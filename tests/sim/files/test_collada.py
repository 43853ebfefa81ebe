"""COLLADA's forms of faces and of poses, against the corners that they mean."""

from __future__ import annotations

from pathlib import Path
from tempfile import NamedTemporaryFile

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_sim.files.meshes import MeshError, read_skinned

SQUARE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
HALVES = SQUARE[[[0, 1, 2], [0, 2, 3]]]
TRIANGLES = "<triangles count='2'>{input}<p>0 1 2 0 2 3</p></triangles>"
POLYLIST = "<polylist count='2'>{input}<vcount>4 3</vcount><p>0 1 2 3 0 1 2</p></polylist>"
POLYGONS = "<polygons count='2'>{input}<p>0 1 2 3</p><p>0 1 2</p></polygons>"
VERTEX = "<input semantic='VERTEX' source='#v' offset='0'/>"


def file(faces: str, nodes: str, numbers: str = "", library: str = "", asset: str = "") -> bytes:
    """Return a file of one square in faces of some form, placed by nodes."""
    numbers = numbers or " ".join(str(value) for value in SQUARE.ravel())
    count = len(numbers.split())
    params = "".join(f"<param name='{name}' type='float'/>" for name in "XYZ")
    return f"""<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{asset}</asset><library_geometries><geometry id="g" name="plate"><mesh>
<source id="p"><float_array id="a" count="{count}">{numbers}</float_array><technique_common>
<accessor source="#a" count="{count // 3}" stride="3">{params}</accessor>
</technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
{faces.format(input=VERTEX)}</mesh></geometry></library_geometries>
<library_nodes>{library}</library_nodes>
<library_visual_scenes><visual_scene id="s">{nodes}</visual_scene></library_visual_scenes>
</COLLADA>""".encode()


def read_collada(content: bytes, part: str = "") -> NDArray[np.float64]:
    with NamedTemporaryFile(suffix=".dae") as kept:
        kept.write(content)
        kept.flush()
        return read_skinned(Path(kept.name), part)[0]


def node(
    positions: str = "", inside: str = "<instance_geometry url='#g'/>", name: str = "n"
) -> str:
    return f"<node id='{name}' name='{name}'>{positions}{inside}</node>"


def test_it_is_in_metres_and_keeps_its_axes() -> None:
    asset = "<unit meter='0.5'/><up_axis>Y_UP</up_axis>"
    np.testing.assert_array_equal(read_collada(file(TRIANGLES, node(), asset=asset)), HALVES / 2)


@pytest.mark.parametrize("faces", [POLYLIST, POLYGONS])
def test_a_face_of_many_corners_is_a_fan(faces: str) -> None:
    found = read_collada(file(faces, node()))
    np.testing.assert_array_equal(found, np.concatenate((HALVES, HALVES[:1])))


def test_nodes_may_be_nested_but_in_no_circle() -> None:
    nested = node()
    for level in range(40):
        nested = node(inside=nested, name=f"n{level}")
    np.testing.assert_array_equal(read_collada(file(TRIANGLES, nested)), HALVES)
    again = "<instance_node url='#m'/>"
    with pytest.raises(MeshError, match="nested too deeply or form a cycle"):
        read_collada(file(TRIANGLES, node(inside=again), library=node(inside=again, name="m")))


@pytest.mark.parametrize("blank", ["", " ", "\n  "])
def test_a_list_without_corners_adds_none(blank: str) -> None:
    faces = TRIANGLES + f"<triangles count='0'>{{input}}<p>{blank}</p></triangles>"
    np.testing.assert_array_equal(read_collada(file(faces, node())), HALVES)


def test_other_inputs_between_the_corners_are_passed_over() -> None:
    faces = (
        "<triangles count='2'><input semantic='NORMAL' source='#p' offset='0'/>"
        "<input semantic='VERTEX' source='#v' offset='1'/>"
        "<p>3 0 3 1 3 2 3 0 3 2 3 3</p></triangles>"
    )
    np.testing.assert_array_equal(read_collada(file(faces, node())), HALVES)


@pytest.mark.parametrize(
    ("positions", "corner"),  # where (1, 1, 0) comes to lie
    [
        ("<translate>1 2 3</translate>", (2.0, 3.0, 3.0)),
        ("<scale>2 3 4</scale>", (2.0, 3.0, 0.0)),
        ("<rotate>0 0 1 90</rotate>", (-1.0, 1.0, 0.0)),
        ("<rotate>1 0 0 90</rotate>", (1.0, 0.0, 1.0)),
        ("<translate>1 0 0</translate><rotate>0 0 1 90</rotate>", (0.0, 1.0, 0.0)),
        ("<rotate>0 0 1 90</rotate><translate>1 0 0</translate>", (-1.0, 2.0, 0.0)),
        ("<matrix>0 -1 0 5 1 0 0 6 0 0 1 7 0 0 0 1</matrix>", (4.0, 7.0, 7.0)),
    ],
)
def test_a_node_transforms_what_it_holds(positions: str, corner: tuple[float, ...]) -> None:
    found = read_collada(file(TRIANGLES, node(positions)))
    assert found[0, 2] == pytest.approx(corner, abs=1e-6)


def test_nodes_transform_nodes_and_those_of_the_library() -> None:
    inner = node("<translate>0 0 1</translate>", name="inner")
    outer = node("<scale>2 2 2</scale>", inner, name="outer")
    assert read_collada(file(TRIANGLES, outer))[0, 2] == pytest.approx((2.0, 2.0, 2.0))
    called = node("<translate>5 0 0</translate>", "<instance_node url='#inner'/>")
    found = read_collada(file(TRIANGLES, called, library=inner))
    assert found[0, 2] == pytest.approx((6.0, 1.0, 1.0))


def parts(part: str) -> NDArray[np.float64]:
    nodes = node(name="left") + node("<translate>3 0 0</translate>", name="right")
    return read_collada(file(TRIANGLES, nodes), part)


def test_a_part_is_named_by_its_node_or_its_geometry() -> None:
    assert parts("").shape == (4, 3, 3)
    assert parts("right")[:, :, 0].min() == 3.0
    assert len(parts("plate")) == len(parts("g")) == 4
    assert len(parts("nobody")) == 0


def test_a_file_without_a_scene_is_read_whole() -> None:
    np.testing.assert_array_equal(read_collada(file(TRIANGLES, "")), HALVES)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (file(TRIANGLES.replace("2 3", "2 4"), node()), "go beyond the limits of the source"),
        (file(TRIANGLES.replace("{input}", ""), node()), "is a broken mesh"),
        (file(TRIANGLES, node(inside="<instance_node url='#n'/>")), "form a cycle"),
        (file(TRIANGLES, node(), "0 a b"), "is a broken mesh: DaeMalformedError"),
    ],
)
def test_what_leads_nowhere_is_refused(content: bytes, problem: str) -> None:
    with pytest.raises(MeshError, match=problem):
        read_collada(content)
