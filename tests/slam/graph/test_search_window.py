"""The window in which a submap is looked for: how far it reaches, and its pieces."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_slam.graph.place_match import Search

PRIOR = SE2(4.0, -3.0, 1.0)


def search(xy: float, theta: float = 0.3) -> Search:
    return Search(PRIOR, np.eye(3), xy, theta)


@pytest.mark.parametrize(("xy", "reaches"), [(0.75, False), (0.85, True)])
@pytest.mark.parametrize("way", [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
def test_another_place_may_lie_where_the_window_reaches_beside_the_best(
    xy: float, reaches: bool, way: tuple[float, float]
) -> None:
    assert search(xy).reaches_beside(PRIOR) is reaches
    best = SE2(PRIOR.x + 0.3 * way[0], PRIOR.y + 0.3 * way[1], PRIOR.theta)
    assert search(xy - 0.3).reaches_beside(best) is reaches


def test_a_window_has_room_for_two_places_that_are_apart() -> None:
    assert search(1.65).ambiguous
    assert not search(1.55).ambiguous


@pytest.mark.parametrize(("xy", "theta"), [(0.2, 0.05), (1.0, 0.3), (3.0, 0.4), (8.0, 0.5)])
def test_pieces_cover_the_window_once_from_the_middle_outwards(xy: float, theta: float) -> None:
    pieces = search(xy, theta).pieces(0.05)
    assert all((middle.x, middle.y) == (PRIOR.x, PRIOR.y) for middle, _ in pieces)
    assert all(window.xy == xy for _, window in pieces)
    off = [middle.theta - PRIOR.theta for middle, _ in pieces]
    assert np.all(np.diff(np.abs(off)) > -1e-9)
    edges = sorted(
        (turn - window.theta, turn + window.theta)
        for turn, (_, window) in zip(off, pieces, strict=True)
    )
    assert edges[0][0] == pytest.approx(-theta)
    assert edges[-1][1] == pytest.approx(theta)
    assert [low for low, _ in edges[1:]] == pytest.approx([high for _, high in edges[:-1]])
    assert all(window.theta * xy**2 < 1.3 or window.theta <= 0.03 for _, window in pieces)


@pytest.mark.parametrize(
    ("xy", "theta", "count"), [(0.2, 0.05, 1), (1.0, 0.3, 1), (2.0, 0.5, 2), (3.0, 0.39, 3)]
)
def test_a_piece_holds_so_much_of_the_window_or_three_hundredths_of_a_radian(
    xy: float, theta: float, count: int
) -> None:
    assert len(search(xy, theta).pieces(0.05)) == count
    assert len(search(10.0, 0.295).pieces(0.05)) == 10


@pytest.mark.parametrize(
    ("xy", "resolution", "depth"),
    [
        (0.01, 0.1, 2),
        (0.39, 0.05, 2),
        (0.41, 0.05, 3),
        (1.59, 0.1, 3),
        (1.61, 0.05, 5),
        (9, 0.05, 5),
    ],
)
def test_blocks_of_a_search_are_up_to_32_cells_and_no_wider_than_the_window(
    xy: float, resolution: float, depth: int
) -> None:
    assert {window.depth for _, window in search(xy).pieces(resolution)} == {depth}
