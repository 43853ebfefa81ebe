"""Meshes: every form reads to the same triangles, and a hollow one can be driven into."""

from __future__ import annotations

import struct
import time
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, Delaunay

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.files.meshes import MeshError, read_mesh
from arjuna_sim.files.sdf.solids import cone, prism
from arjuna_sim.files.search_path import EscapeError, SearchPath
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.geometry.convex_pieces import hull, pieces
from arjuna_sim.model.geometry.walls import surfaces
from tests.sim.builders import run, simulator

_RING = ((-1, -1), (1, -1), (1, 1), (-1, 1))
DAE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.5"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
  <source id="p"><float_array id="a" count="{count}">{numbers}</float_array>
    <technique_common><accessor source="#a" count="{corners}" stride="3">
      <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
    </accessor></technique_common></source>
  <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
  <triangles count="{faces}"><input semantic="VERTEX" source="#v" offset="0"/>
    <p>{order}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><translate>2 0 0</translate>
  <instance_geometry url="#g"/></node></visual_scene></library_visual_scenes></COLLADA>"""
WORLD = """<sdf version="1.6"><world name="w"><model name="hall"><static>true</static>
<link name="l"><collision name="c"><geometry><mesh><uri>hall.stl</uri><scale>2 2 1</scale></mesh>
</geometry></collision></link></model></world></sdf>"""


def _prism(height: float = 1.0) -> NDArray[np.float64]:
    """Return the four outward walls of a square tube, edges 2."""
    faces = []
    for (x0, y0), (x1, y1) in zip(_RING, _RING[1:] + _RING[:1], strict=True):
        a, b, c, d = (x0, y0, 0.0), (x1, y1, 0.0), (x1, y1, height), (x0, y0, height)
        faces += [(a, b, c), (a, c, d)]
    return np.array(faces, np.float64)


def _binary_stl(triangles: NDArray[np.float64]) -> bytes:
    faces = [struct.pack("<12fH", 0, 0, 0, *face.ravel(), 0) for face in triangles]
    return bytes(80) + struct.pack("<I", len(triangles)) + b"".join(faces)


def _write(folder: Path, form: str, triangles: NDArray[np.float64]) -> Path:
    path, points = folder / f"mesh.{form}", triangles.reshape(-1, 3)
    if form == "obj":
        lines = [f"v {x} {y} {z}" for x, y, z in points]
        lines += [f"f {3 * i + 1}/1 {3 * i + 2}/1 {3 * i + 3}/1" for i in range(len(triangles))]
        path.write_text("\n".join(lines), encoding="utf-8")
    elif form == "dae":
        numbers = " ".join(str(v) for v in (points * 2 - (2, 0, 0)).ravel())
        order = " ".join(str(i) for i in range(len(points)))
        text = DAE.format(
            count=points.size,
            corners=len(points),
            numbers=numbers,
            faces=len(triangles),
            order=order,
        )
        path.write_text(text, encoding="utf-8")
    else:
        path.write_bytes(_binary_stl(triangles))
    return path


@pytest.mark.parametrize("form", ["stl", "obj", "dae"])
def test_every_form_reads_to_the_same_triangles(tmp_path: Path, form: str) -> None:
    assert np.allclose(read_mesh(_write(tmp_path, form, _prism())), _prism())


def test_text_stl_is_read(tmp_path: Path) -> None:
    path = tmp_path / "mesh.stl"
    corners = "\n".join(f"vertex {x} {y} {z}" for x, y, z in _prism().reshape(-1, 3))
    path.write_text(f"solid tube\n{corners}\nendsolid", encoding="utf-8")
    assert np.allclose(read_mesh(path), _prism())


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("a.stl", b"solid nothing\nendsolid", "has no triangles"),
        ("a.stl", bytes(80) + struct.pack("<I", 10**9), "cut off"),
        ("a.stl", _binary_stl(np.full((1, 3, 3), np.nan)), "must be finite"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9", "a corner that does not exist"),
        ("a.dae", b"<COLLADA><asset>", "line 1: broken XML"),
        ("a.dae", b"<!DOCTYPE a [<!ENTITY b 'c'>]><COLLADA/>", "declares a DTD or entities"),
        ("a.ply", b"ply", "valid: .dae, .obj, .stl"),
    ],
)
def test_broken_mesh_is_refused(tmp_path: Path, name: str, content: bytes, problem: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(MeshError, match=problem):
        read_mesh(tmp_path / name)


def test_tube_is_touched_wall_by_wall_and_a_box_as_one(tmp_path: Path) -> None:
    assert len(pieces(_prism()).corners) == 8
    lid = np.array([[(-1, -1), (1, -1), (1, 1)], [(-1, -1), (1, 1), (-1, 1)]], np.float64)
    top = np.dstack([lid, np.ones((2, 3))])
    bottom = np.dstack([lid[:, ::-1], np.zeros((2, 3))])
    box = np.concatenate([_prism(), top, bottom])
    assert len(pieces(box).corners) == 1
    assert len(hull(box.reshape(-1, 3))) == 8


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


@pytest.mark.parametrize("flat", ["level", "tilted", "line", "point", "tiny"])
def test_hull_of_what_is_flat_is_thin(flat: str) -> None:
    points = np.random.default_rng(2).random((20, 3))
    if flat == "tilted":
        points[:, 2] = 0.7 * points[:, 0] - 0.4 * points[:, 1]
    elif flat == "tiny":
        points *= 1e-5
    else:
        points[:, {"level": 2, "line": 1, "point": 0}[flat] :] = 0.5
    solid = ConvexHull(hull(points))
    assert 0.0 < solid.volume < 2e-3
    assert (points @ solid.equations[:, :3].T + solid.equations[:, 3]).max() < 1e-9


def test_robot_drives_inside_a_hollow_mesh_until_it_meets_its_wall(tmp_path: Path) -> None:
    inward = _prism()[:, ::-1]
    (tmp_path / "hall.stl").write_bytes(_binary_stl(inward))
    path = tmp_path / "hall.world"
    path.write_text(WORLD, encoding="utf-8")
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


@pytest.mark.parametrize("turned", [1, -1])
def test_a_prism_stands_on_the_ground_closed_and_faces_outward(turned: int) -> None:
    outline = np.array([(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)])
    for corners in (outline[::turned], np.vstack((outline, outline[:1]))[::turned]):
        faces = prism(corners, 0.5)
        assert np.ptp(faces[..., 2]) == faces[..., 2].max() == 0.5
        # Outward and closed faces enclose, by the divergence theorem, what they hold.
        held = np.einsum("ij,ij->", faces[:, 0], np.cross(faces[:, 1], faces[:, 2])) / 6.0
        assert held == pytest.approx(4.0 * 0.5)
        far = faces + np.array((100.0, -50.0, 20.0))
        moved = np.einsum("ij,ij->", far[:, 0], np.cross(far[:, 1], far[:, 2])) / 6.0
        assert moved == pytest.approx(4.0 * 0.5)


def test_a_cone_is_closed_about_its_middle() -> None:
    faces = cone(0.5, 1.2)
    assert (faces[..., 2].min(), faces[..., 2].max()) == (-0.6, 0.6)
    assert np.hypot(faces[..., 0], faces[..., 1]).max() == pytest.approx(0.5)
    held = np.einsum("ij,ij->", faces[:, 0], np.cross(faces[:, 1], faces[:, 2])) / 6.0
    assert held == pytest.approx(np.pi * 0.5**2 * 1.2 / 3.0, rel=0.01)


@pytest.mark.parametrize(
    ("corners", "problem"),
    [
        ([(0, 0), (1, 0)], "has 2 corners; valid: 3 to"),
        ([(0, 0), (1, 0), (0, 0)], "has 2 corners"),
        ([(0, 0), (2, 2), (2, 0), (0, 2)], "crosses itself|has no area"),
        ([(0, 0), (1, 0), (2, 0), (3, 0)], "has no area"),
    ],
)
def test_an_outline_that_is_none_makes_no_prism(
    corners: list[tuple[float, float]], problem: str
) -> None:
    with pytest.raises(ValueError, match=problem):
        prism(np.array(corners, np.float64), 1.0)
