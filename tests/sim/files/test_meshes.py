"""Mesh files of every form, the bounds on what is read, and a hollow mesh to drive in."""

from __future__ import annotations

import struct
import time
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import Delaunay

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.files import meshes as triangles
from arjuna_sim.files.meshes import MeshError, read_skinned
from arjuna_sim.files.search_path import EscapeError, SearchPath
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.geometry.convex_pieces import hull, pieces
from arjuna_sim.model.geometry.walls import surfaces
from tests.sim.builders import run, saved_world, simulator
from tests.sim.world_cases import stl as binary_stl
from tests.sim.world_cases import write_stl

_RING = ((-1, -1), (1, -1), (1, 1), (-1, 1))
HALL = """<model name="hall"><static>true</static>
<link name="l"><collision name="c"><geometry><mesh><uri>hall.stl</uri><scale>2 2 1</scale></mesh>
</geometry></collision></link></model>"""


def _prism(height: float = 1.0) -> NDArray[np.float64]:
    """Return the four outward walls of a square tube, edges 2."""
    faces = []
    for (x0, y0), (x1, y1) in zip(_RING, _RING[1:] + _RING[:1], strict=True):
        a, b, c, d = (x0, y0, 0.0), (x1, y1, 0.0), (x1, y1, height), (x0, y0, height)
        faces += [(a, b, c), (a, c, d)]
    return np.array(faces, np.float64)


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("a.stl", b"solid nothing\nendsolid", "has no triangles"),
        ("a.stl", binary_stl(np.full((1, 3, 3), np.nan)), "must be finite"),
        ("a.dae", b"<COLLADA><asset>", "line 1: is broken XML"),
        ("a.dae", b"<!DOCTYPE a [<!ENTITY b 'c'>]><COLLADA/>", "declares a DTD or entities"),
    ],
)
def test_broken_mesh_is_refused(tmp_path: Path, name: str, content: bytes, problem: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(MeshError, match=problem):
        read_skinned(tmp_path / name)


@pytest.mark.parametrize("most", [24, 200, 1000])
def test_mesh_of_too_many_faces_is_touched_within_a_bound(most: int) -> None:
    rng = np.random.default_rng(1)
    u, v = np.meshgrid(np.linspace(0, 2, 41), np.linspace(0, 1, 21))
    w = 0.3 * np.sin(5 * u) * np.cos(4 * v)  # a sheet that is not convex anywhere
    grid = np.stack((u, v, w), axis=-1)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    sheet = np.concatenate([np.stack(f, axis=2).reshape(-1, 3, 3) for f in ((a, b, c), (a, c, d))])
    found = pieces(sheet, most)
    assert 0.0 < found.within < 1.5
    assert most / 4 < len(found.corners) <= most
    weights = rng.dirichlet(np.ones(3), 300)
    points = np.einsum("ij,ijk->ik", weights, sheet[rng.integers(len(sheet), size=300)])
    hulls = [Delaunay(corners) for corners in found.corners]
    assert np.all([h.find_simplex(points, tol=1e-6) >= 0 for h in hulls], axis=0).sum() == 0
    covered = np.any([h.find_simplex(points, tol=1e-6) >= 0 for h in hulls], axis=0)
    assert covered.all()  # no face can be passed through


def test_large_mesh_is_split_in_a_moment_and_little_memory() -> None:
    corners = np.random.default_rng(0).random((60_000, 1, 3)) * (20, 20, 3)
    faces = corners + 0.05 * np.random.default_rng(1).random((60_000, 3, 3))
    start = time.process_time()
    found = pieces(faces, 500)
    assert len(found.corners) <= 500
    assert time.process_time() - start < 10.0
    assert len(hull(faces.reshape(-1, 3))) > 8  # of many points, as of few


def test_robot_drives_inside_a_hollow_mesh_until_it_meets_its_wall(tmp_path: Path) -> None:
    write_stl(tmp_path / "hall.stl", _prism()[:, ::-1])
    path = saved_world(tmp_path, HALL)
    cut = surfaces(load_world(path), 0.28)
    assert sorted(np.unique(np.abs(cut).max(axis=1)).tolist()) == [2.0]
    sim = simulator(path, spawn=SE2(-1.0, 0.0, 0.0))
    free = run(sim, 2.0, Velocity(0.5))
    assert free.contacts == ()
    assert free.scan is None or np.nanmin(free.scan.ranges) < 2.1
    stopped = run(sim, 4.0, Velocity(0.5))
    assert stopped.contacts == ("hall",)
    assert 1.6 < stopped.truth.pose.x < 2.0


def test_search_path_finds_packages_and_keeps_inside_them(tmp_path: Path) -> None:
    mesh = tmp_path / "stack" / "robot_description" / "meshes" / "a.stl"
    mesh.parent.mkdir(parents=True)
    mesh.write_bytes(b"")
    (tmp_path / "secret.stl").write_bytes(b"")
    beside = Path("/nowhere/robot.urdf")
    for folder in (tmp_path / "stack" / "robot_description", tmp_path / "stack", tmp_path):
        search = SearchPath.of([folder])
        assert search.find(beside, "package://robot_description/meshes/a.stl") == mesh
        with pytest.raises(EscapeError, match="leads out of its package"):
            search.find(beside, "package://robot_description/../../secret.stl")
    assert SearchPath.of([tmp_path]).find(beside, "package://../secret.stl") is None


SQUARE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 2.0]])
CORNERS = "\n".join(f"v {x} {y} {z}" for x, y, z in SQUARE)
FAN = SQUARE[[[0, 1, 2], [0, 2, 3]]]


def read(folder: Path, name: str, content: str | bytes, part: str = "") -> np.ndarray:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_skinned(path, part)[0]


def turned(triangles: np.ndarray) -> list[list[list[float]]]:
    """Return triangles, each from its least corner on, in an order of their own."""
    return sorted(min(face[i:] + face[:i] for i in range(3)) for face in triangles.tolist())


def stl(count: int, said: int | None = None, header: bytes = b"", more: bytes = b"") -> bytes:
    """Return binary STL of faces whose corners are (i, i, i), (i + 1, 0, 0) and (0, i, 0)."""
    faces = [struct.pack("<12fH", 9, 9, 9, i, i, i, i + 1, 0, 0, 0, i, 0, 7) for i in range(count)]
    given = struct.pack("<I", count if said is None else said)
    return header.ljust(80, b"\0") + given + b"".join(faces) + more


def expected(count: int) -> list[list[list[float]]]:
    return [[[i, i, i], [i + 1, 0, 0], [0, i, 0]] for i in range(count)]


@pytest.mark.parametrize(
    "faces",
    ["f 1 2 3 4", "f 1/9 2/9/9 3//9 4", "f -4 -3 -2 -1", "f 1 2 3\nf 1 3 4", "f 1 -3 3 -1"],
)
def test_faces_name_corners_from_one_or_from_the_last(tmp_path: Path, faces: str) -> None:
    found = read(tmp_path, "a.obj", f"# plate\nvn 1 2 3\nvt 1 2\n{CORNERS}\n{faces}\nf 1 2\n")
    assert turned(found) == turned(FAN)


def test_a_corner_may_have_colours_after_its_position(tmp_path: Path) -> None:
    coloured = CORNERS.replace("\n", " 1 0 0\n") + " 1 0 0 1"
    assert turned(read(tmp_path, "A.OBJ", f"{coloured}\nf 1 2 3 4")) == turned(FAN)


def test_faces_count_back_from_the_corners_before_them(tmp_path: Path) -> None:
    later = "\nf -4 -3 -2\nv 5 5 5\nf -1 -5 -4"
    found = read(tmp_path, "a.obj", CORNERS + later)
    np.testing.assert_array_equal(found[0], SQUARE[:3])
    np.testing.assert_array_equal(found[1], [(5, 5, 5), SQUARE[0], SQUARE[1]])


def test_a_part_is_an_object_or_one_of_a_faces_groups(tmp_path: Path) -> None:
    text = f"{CORNERS}\no plate\nf 1 2 3\ng lid top\nf 1 3 4\ng\nf 2 3 4\n"
    counts = {
        part: len(read(tmp_path, "a.obj", text, part)) for part in ("", "plate", "lid", "top")
    }
    assert counts == {"": 3, "plate": 1, "lid": 1, "top": 1}
    assert turned(read(tmp_path, "a.obj", text, "top")) == turned(FAN[1:])
    assert read(tmp_path, "a.obj", text, "none").shape == (0, 3, 3)
    assert read(tmp_path, "a.stl", stl(2), "none").shape == (0, 3, 3)


@pytest.mark.parametrize("faces", ["f 0 1 2", "f 1 2 5", "f -5 1 2", "f 1 x 2"])
def test_faces_of_no_corner_are_refused(tmp_path: Path, faces: str) -> None:
    with pytest.raises(MeshError, match=r"a corner that does not exist|invalid literal"):
        read(tmp_path, "a.obj", f"{CORNERS}\n{faces}")


@pytest.mark.parametrize(
    ("content", "count"),
    [
        (stl(3), 3),
        (stl(3, more=b"trailer"), 3),
        (stl(3, said=2), 2),
        (stl(3, header=b"solid by CAD"), 3),  # binary all the same: its size says so
    ],
)
def test_binary_stl_is_known_by_its_size(tmp_path: Path, content: bytes, count: int) -> None:
    assert read(tmp_path, "a.stl", content).tolist() == expected(count)


@pytest.mark.parametrize("content", [stl(3)[:-1], stl(3, said=4), b"", b"\0" * 83])
def test_stl_that_is_cut_off_is_refused(tmp_path: Path, content: bytes) -> None:
    with pytest.raises(MeshError, match="cut off"):
        read(tmp_path, "a.stl", content)


@pytest.mark.parametrize("start", ["solid", "\n  solid name"])
def test_text_stl_holds_its_vertices_three_to_a_face(tmp_path: Path, start: str) -> None:
    loop = "facet normal 0 0 1\nouter loop\n{}\nendloop\nendfacet"
    corners = "\n".join(f"   vertex {x} {y} {z}" for x, y, z in FAN.reshape(-1, 3))
    found = read(tmp_path, "a.stl", f"{start}\n{loop.format(corners)}\nendsolid")
    assert turned(found) == turned(FAN)


def test_corners_end_at_a_thousand_million(tmp_path: Path) -> None:
    near, far = (CORNERS.replace("2.0", value) + "\nf 1 2 3 4" for value in ("-9.9e8", "-1e9"))
    assert len(read(tmp_path, "a.obj", near)) == 2
    with pytest.raises(MeshError, match="must be finite, below 1e9"):
        read(tmp_path, "a.obj", far)


@pytest.mark.parametrize(
    ("bound", "least", "problem"),
    [
        ("MESH_BYTES_MAX", len(stl(3)), r"has 234 bytes; at most 233 are read"),
        ("_FACES_MAX", 3, r"has 3 triangles; at most 2 are read"),
    ],
)
def test_stl_of_the_most_that_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, bound: str, least: int, problem: str
) -> None:
    monkeypatch.setattr(triangles, bound, least)
    assert len(read(tmp_path, "a.stl", stl(3))) == 3
    monkeypatch.setattr(triangles, bound, least - 1)
    with pytest.raises(MeshError, match=problem):
        read(tmp_path, "a.stl", stl(3))


def test_text_of_the_most_that_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = f"{CORNERS}\nf 1 2 3 4"
    for bound, least in (("_TEXT_MAX", len(text)), ("_LINES_MAX", 4), ("_FACES_MAX", 2)):
        with monkeypatch.context() as patch:
            patch.setattr(triangles, bound, least)
            assert len(read(tmp_path, "a.obj", text)) == 2
            patch.setattr(triangles, bound, least - 1)
            with pytest.raises(MeshError, match=r"valid: up to|at most 1 are read"):
                read(tmp_path, "a.obj", text)


def test_what_is_not_there_or_no_mesh_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="cannot be read: No such file"):
        read_skinned(tmp_path / "none.stl")
    with pytest.raises(MeshError, match=r"has the form '.txt'; valid: .dae, .obj, .stl"):
        read(tmp_path, "a.txt", "")
    with pytest.raises(MeshError, match="has no triangles"):
        read(tmp_path, "a.obj", CORNERS)
