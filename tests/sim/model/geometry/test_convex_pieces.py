"""Into which convex pieces meshes are split, and what their corners are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from arjuna_core.pose3 import Pose3
from arjuna_sim.files.sdf.solids import prism
from arjuna_sim.model.geometry.convex_pieces import (
    CUBE,
    PIECES_MAX,
    hull,
    kept_pieces,
    pieces,
    surface,
)
from arjuna_sim.model.geometry.shapes import Kind, Mesh, Part, Shape, Terrain
from arjuna_sim.model.geometry.walls import surfaces
from arjuna_sim.model.world import Body, World

FACE = np.array([[[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 3.0, 1.0]]])  # looks up
SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
TILTED = Pose3.from_rpy((1.0, 2.0, 3.0), (0.3, -0.5, 0.7))
DEPTH, SHEET = 0.05, 1.5e-3  # of what is solid, and of what is open
ROUGH = 1e-4


def tube() -> NDArray[np.float64]:
    """Return the eight faces of a square tube of edge 1 without ends, four walls."""
    return prism(SQUARE, 1.0)[-8:]


def sheet(count: int) -> NDArray[np.float64]:
    """Return the faces of a rough square metre that looks up, `2 count^2` of them."""
    rough = ROUGH * np.random.default_rng(1).random((count + 1, count + 1))
    return Terrain(Path("rough.png"), rough).triangles((1.0, 1.0, 1.0))


def moved(faces: NDArray[np.float64], by: tuple[float, float, float]) -> NDArray[np.float64]:
    result: NDArray[np.float64] = faces + np.array(by)
    return result


def volumes(found: list[NDArray[np.float64]]) -> list[float]:
    return [float(ConvexHull(each).volume) for each in found]


@pytest.mark.parametrize(
    ("spans", "volume"),
    [
        ((3.0, 2.0, 1.0), 6.0),
        ((3.0, 2.0, 1.1e-3), 6.6e-3),
        ((3.0, 2.0, 0.9e-3), 6e-3),  # what is flat becomes a millimetre thick
        ((3.0, 2.0, 0.0), 6e-3),
        ((3.0, 0.0, 0.0), 3e-6),
        ((3.0, 0.9e-3, 0.0), 3e-6),
        ((0.0, 0.0, 0.0), 1e-9),
    ],
)
def test_a_hull_is_a_millimetre_thick(spans: tuple[float, float, float], volume: float) -> None:
    points = TILTED.apply(CUBE * np.array(spans) / 2)
    inside = points.mean(axis=0)[None]
    found = hull(np.vstack((points, inside, points)))
    assert len(found) == 8
    assert volumes([found]) == pytest.approx([volume], rel=1e-3)
    np.testing.assert_allclose(found.mean(axis=0), TILTED.position, atol=1e-6)


def test_a_face_is_a_slab_behind_it_and_a_sliver_nothing() -> None:
    (slab,) = pieces(FACE).corners
    np.testing.assert_allclose(slab, np.vstack((FACE[0], FACE[0] - (0.0, 0.0, SHEET))))
    (other,) = pieces(FACE[:, ::-1]).corners
    np.testing.assert_allclose(other[3:] - other[:3], [(0.0, 0.0, SHEET)] * 3)
    sliver = np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1e-10, 0.0]]])
    assert len(pieces(np.concatenate((tube(), sliver + 3.0))).corners) == 4
    assert surface(np.concatenate((FACE, tube()))) == pytest.approx(3.0 + 4.0)


@pytest.mark.parametrize("most", [4, 5])
def test_an_open_body_is_its_walls_while_these_are_few_enough(most: int) -> None:
    found = pieces(tube(), most)
    assert (len(found.corners), found.within) == (4, 0.0)
    assert volumes(found.corners) == pytest.approx([SHEET] * 4)


def test_too_many_walls_are_joined_cell_by_cell() -> None:
    found = pieces(tube(), 3)
    assert 0 < len(found.corners) <= 3
    assert 0.0 < found.within < 1.5
    whole = pieces(tube(), 1)
    assert volumes(whole.corners) == pytest.approx([1.0])
    assert whole.within == pytest.approx(1.0)  # as far as it reaches


def notched(depth: float) -> NDArray[np.float64]:
    """Return the faces of a cube of edge 1 with a notch over all of one side [m]."""
    top = np.array([[1.0, 1.0], [0.6, 1.0], [0.5, 1.0 - depth], [0.4, 1.0], [0.0, 1.0]])
    return prism(np.vstack((SQUARE[:2], top)), 1.0)


@pytest.mark.parametrize(("depth", "is_whole"), [(1.9e-3, True), (2.1e-3, False)])
def test_a_body_with_hollows_of_millimetres_is_one_piece(depth: float, is_whole: bool) -> None:
    body = notched(depth)
    far = moved(TILTED.apply(body.reshape(-1, 3)).reshape(-1, 3, 3), (100.0, -50.0, 20.0))
    for each in (body, body[:, ::-1], far):
        assert (len(pieces(each).corners) == 1) == is_whole


def test_hollows_of_a_centimetre_are_filled_where_there_are_too_many_pieces() -> None:
    body = notched(9e-3)
    found = pieces(body, 8)
    assert (len(found.corners), found.within) == (1, 1e-2)
    assert len(pieces(body).corners) > 8
    assert len(pieces(notched(11e-3), 8).corners) > 1


def test_bodies_apart_are_pieces_in_the_order_of_their_first_faces() -> None:
    boxes = [moved(prism(SQUARE, 1.0), (x, 0.0, 0.0)) for x in (5.0, 0.0, 2.0)]
    mixed = np.concatenate([box[part] for part in (slice(3), slice(3, None)) for box in boxes])
    found = pieces(mixed, 3)
    assert found.within == 0.0
    assert [each[:, 0].min() for each in found.corners] == [5.0, 0.0, 2.0]
    assert volumes(found.corners) == pytest.approx([1.0] * 3)
    assert pieces(mixed, 2).within > 0.0
    on_edge = np.concatenate((boxes[1], moved(boxes[1], (1.0, 1.0, 0.0))))
    assert volumes(pieces(on_edge).corners) == pytest.approx([1.0, 1.0])


def test_a_thick_body_is_slabs_of_a_depth_and_a_thin_one_as_deep_as_it_is() -> None:
    outline = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 0.02), (0.3, 0.02), (0.3, 1.0), (0.0, 1.0)])
    found = pieces(prism(outline, 1.0)).corners
    tops = [each for each in found if np.ptp(each[:, 1]) < 0.3 and each[:, 1].max() > 0.9]
    thin = [each for each in found if each[:, 1].max() < 0.021 and np.ptp(each[:, 0]) > 0.6]
    assert [np.ptp(each[:, 1]) for each in tops] == pytest.approx([DEPTH] * len(tops))
    assert [np.ptp(each[:, 1]) for each in thin] == pytest.approx([0.02] * len(thin))
    assert tops
    assert thin


def test_cells_of_faces_of_one_side_reach_a_slab_deep() -> None:
    found = pieces(sheet(8), 16)
    assert 4 <= len(found.corners) <= 16
    assert 0.25 <= found.within < 0.25 * 1.25**4  # no finer than all can have, and little coarser
    for corner in found.corners:
        ends = corner[:, 2].min(), corner[:, 2].max()
        assert ends == pytest.approx((-SHEET, ROUGH), abs=1e-5 + ROUGH)
        assert np.ptp(corner[:, :2], axis=0).max() < 2.0 * found.within
    both = np.concatenate((sheet(8), sheet(8)[:, ::-1]))
    for corner in pieces(both, 16).corners:
        assert np.ptp(corner[:, 2]) == pytest.approx(1e-3, abs=ROUGH)
    covered = np.concatenate([corner[:, :2] for corner in found.corners])
    assert (covered.min(), covered.max()) == pytest.approx((-0.5, 0.5))


def test_large_faces_are_cut_before_they_are_sorted_into_cells() -> None:
    found = pieces(np.concatenate((sheet(1), moved(sheet(8), (0.0, 0.0, 3.0)))), 64)
    low = [corner for corner in found.corners if corner[:, 2].max() < 1.0]
    assert len(low) >= 9
    assert sum(volumes(low)) == pytest.approx(SHEET, rel=0.2)  # each point of it once


def test_a_hollow_mesh_is_cut_in_its_own_outline_and_not_its_hulls() -> None:
    outline = np.array([(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)])
    mesh = Mesh(Path("l.stl"), prism(outline, 1.0))
    assert mesh.reach == 3.0
    shape = Shape(Kind.MESH, (2.0, 1.0, 3.0), mesh)
    world = World(Path("w"), "w", (Body("m", Part(shape), True),), ())
    lines = surfaces(world, 1.7)
    length = np.hypot(lines[:, 2] - lines[:, 0], lines[:, 3] - lines[:, 1]).sum()
    assert length == pytest.approx(2.0 * (6.0 + 2.0))
    ends = {tuple(np.round(end, 6)) for end in lines.reshape(-1, 2).tolist()}
    assert {(2.0 * x, y) for x, y in outline.tolist()} <= ends
    assert len(surfaces(world, 3.1)) == len(surfaces(world, -0.1)) == 0
    assert mesh.hull((2.0, 1.0, 3.0)) is mesh.hull((2.0, 1.0, 3.0))
    assert mesh.hull((2.0, 1.0, 3.0)).max(axis=0).tolist() == [6.0, 2.0, 3.0]
    assert mesh.pieces((1.0, 1.0, 1.0), 99) is mesh.pieces((1.0, 1.0, 1.0), 99)
    assert mesh.pieces((1.0, 1.0, 1.0), 1).within > 0.0  # of another budget, others


@pytest.mark.parametrize("most", [PIECES_MAX, 24])
def test_kept_pieces_are_those_that_are_made(
    most: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    faces = np.asarray(trimesh.creation.torus(0.5, 0.1).triangles, np.float64)
    made = pieces(faces, most)
    for _ in range(2):
        kept = kept_pieces(faces, most)
        assert kept.within == made.within
        for one, other in zip(kept.corners, made.corners, strict=True):
            np.testing.assert_array_equal(one, other)
    assert len(list(tmp_path.rglob("*.npz"))) == 1
