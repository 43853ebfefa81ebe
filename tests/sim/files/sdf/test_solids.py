"""Cones and prisms against the solids that their numbers describe."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_sim.files.sdf import solids
from arjuna_sim.files.sdf.solids import cone, prism

L = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]
COMB = [
    *((0.0, 0.0), (7.0, 0.0), (7.0, 3.0), (6.0, 3.0), (6.0, 1.0), (4.0, 1.0), (4.0, 3.0)),
    *((3.0, 3.0), (3.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)),
]
ARROW = [(0.0, 0.0), (2.0, -1.0), (0.5, 0.0), (2.0, 1.0)]  # its tail is notched
STRAIGHT = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0), (0.0, 2.0)]
AREAS = [(L, 4.0), (COMB, 13.0), (ARROW, 0.5), (STRAIGHT, 4.0)]


def star(count: int, seed: int) -> NDArray[np.float64]:
    """Return a polygon about the origin whose corners are now near and now far."""
    rng = np.random.default_rng(seed)
    angles = (np.arange(count) + rng.uniform(0.0, 0.8, count)) * 2.0 * math.pi / count
    ring = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    corners: NDArray[np.float64] = rng.uniform(0.3, 2.0, count)[:, None] * ring
    return corners


def area(corners: NDArray[np.float64]) -> float:
    """Return a polygon's area, a triangle from the origin for each of its edges."""
    total = 0.0
    for i in range(len(corners)):
        (x0, y0), (x1, y1) = corners[i - 1], corners[i]
        total += 0.5 * (x0 * y1 - x1 * y0)
    return total


def normals(faces: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the areas of faces along their outward normals, `(N, 3)`."""
    return np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0]) / 2.0


def edges(faces: NDArray[np.float64]) -> dict[tuple[tuple[float, ...], tuple[float, ...]], int]:
    """Count the directed edges of faces."""
    count: dict[tuple[tuple[float, ...], tuple[float, ...]], int] = {}
    for face in np.round(faces, 9).tolist():
        a, b, c = (tuple(corner) for corner in face)
        for edge in ((a, b), (b, c), (c, a)):
            count[edge] = count.get(edge, 0) + 1
    return count


def is_closed(faces: NDArray[np.float64]) -> bool:
    """Return whether each edge occurs once, and once in reverse in its neighbour."""
    found = edges(faces)
    return all(n == 1 and found.get((b, a)) == 1 for (a, b), n in found.items())


@pytest.mark.parametrize("scale", [1.0, 1e-3])
@pytest.mark.parametrize(("outline", "size"), AREAS)
def test_caps_of_a_prism_fill_its_outline_and_no_more(
    outline: list[tuple[float, float]], size: float, scale: float
) -> None:
    corners = np.array(outline) * scale
    for turned in (1, -1):
        faces = prism(np.roll(corners, 2, axis=0)[::turned], 0.5 * scale)
        up = normals(faces)[:, 2]
        level = np.ptp(faces[..., 2], axis=1) == 0.0
        assert up[up > 0.0].sum() == pytest.approx(size * scale**2)
        assert up[up < 0.0].sum() == pytest.approx(-size * scale**2)
        assert np.abs(up[~level]).max() < 1e-12


@pytest.mark.parametrize("outline", [L, COMB, ARROW], ids=["l", "comb", "arrow"])
def test_each_edge_of_a_prism_joins_two_faces(outline: list[tuple[float, float]]) -> None:
    faces = prism(np.array(outline), 2.0)
    assert len(faces) == 2 * (len(outline) - 2) + 2 * len(outline)
    assert is_closed(faces)
    assert sorted(set(faces[..., 2].ravel().tolist())) == [0.0, 2.0]


@pytest.mark.parametrize(
    ("outline", "size"),
    [
        ([(0, 0), (4, 0), (4, 4), (2, 0), (0, 4)], 8.0),  # a corner on the other side's edge
        ([(0, 4), (2, 0), (4, 4), (4, 0), (0, 0)], 8.0),
        (
            [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)],
            12.0,  # a frame, cut open from corner to corner
        ),
    ],
)
def test_an_outline_may_touch_itself(outline: list[tuple[int, int]], size: float) -> None:
    up = normals(prism(np.array(outline, np.float64), 1.0))[:, 2]
    assert up[up > 0.0].sum() == pytest.approx(size)
    assert up[up < 0.0].sum() == pytest.approx(-size)


@pytest.mark.parametrize("seed", range(6))
def test_any_outline_that_does_not_cross_itself_is_cut_into_triangles(seed: int) -> None:
    outline = star(9 + seed, seed)
    faces = prism(outline, 1.0)
    assert is_closed(faces)
    up = normals(faces)[:, 2]
    assert up[up > 1e-12].sum() == pytest.approx(area(outline))
    assert up[up < -1e-12].sum() == pytest.approx(-area(outline))


def test_an_outline_has_up_to_a_thousand_corners() -> None:
    angles = np.arange(1000) * 2.0 * math.pi / 1000
    ring = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    short = np.delete(ring, slice(4, None), axis=0)  # a sliver of four corners
    assert len(prism(short, 1.0)) == 2 * 2 + 2 * 4
    assert len(prism(np.eye(3)[:, :2], 1.0)) == 2 + 6
    with pytest.raises(ValueError, match="has 1001 corners; valid: 3 to 1000"):
        prism(np.vstack((ring, [[0.0, 0.0]])), 1.0)


def test_the_most_corners_are_still_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solids, "_CORNERS_MAX", 6)
    closed = np.array([*L, L[0]])  # the last corner is the first again
    assert len(prism(closed, 1.0)) == 2 * 4 + 2 * 6


@pytest.mark.parametrize(
    "corners",
    [
        [(0, 0), (2, 2), (2, 0), (0, 2)],
        [(0, 0), (1, 0), (2, 0), (3, 0)],
        [(0, 0), (1, 1), (2, 2)],
    ],
)
def test_what_crosses_itself_or_is_flat_is_refused(corners: list[tuple[float, float]]) -> None:
    with pytest.raises(ValueError, match=r"crosses itself|has no area"):
        prism(np.array(corners, np.float64), 1.0)


def test_a_cone_is_a_regular_pyramid_of_48_sides() -> None:
    radius, length = 0.5, 1.2
    faces = cone(radius, length)
    assert faces.shape == (96, 3, 3)
    assert is_closed(faces)
    base = 48 / 2 * radius**2 * math.sin(2.0 * math.pi / 48)
    up = normals(faces)
    assert up[up[:, 2] < 0.0, 2].sum() == pytest.approx(-base)
    held = np.einsum("ij,ij->", faces[:, 0], up) / 3.0
    assert held == pytest.approx(base * length / 3.0)
    # The tip and the middle of the foot are on the axis, all other corners on the rim.
    reach = np.hypot(faces[..., 0], faces[..., 1]).ravel()
    heights = faces[..., 2].ravel()
    assert np.sum(reach < 1e-12) == 96
    assert heights[reach < 1e-12] == pytest.approx([0.6] * 48 + [-0.6] * 48)
    assert heights[reach > 1e-12] == pytest.approx(-0.6)
    assert reach[reach > 1e-12] == pytest.approx(radius)
    slopes = up[up[:, 2] > 0.0]  # of the side: a normal rises by radius over apothem-length
    apothem = radius * math.cos(math.pi / 48)
    tilt = slopes[:, 2] / np.hypot(slopes[:, 0], slopes[:, 1])
    assert tilt == pytest.approx(apothem / length)
