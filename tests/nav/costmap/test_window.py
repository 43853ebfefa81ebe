"""Windows of cells against the sets of cells that they stand for."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_nav.costmap.window import Window, clipped, grown, joined, seen_in, whole, within

SHAPE = (5, 7)
ALL = {(r, c) for r in range(5) for c in range(7)}


def cells(window: Window | None) -> set[tuple[int, int]]:
    if window is None:
        return set()
    rows, columns = window
    return {
        (r, c) for r in range(rows.start, rows.stop) for c in range(columns.start, columns.stop)
    }


@pytest.mark.parametrize("seed", range(60))
def test_clipping_and_growing_keep_to_the_grid(seed: int) -> None:
    r0, r1, c0, c1, by = (int(n) for n in np.random.default_rng(seed).integers(-3, 11, 5))
    window = clipped(r0, r1, c0, c1, SHAPE)
    assert cells(window) == {(r, c) for r, c in ALL if r0 <= r < r1 and c0 <= c < c1}
    rows, columns = window
    assert all(0 <= n <= 5 for n in (rows.start, rows.stop)), "numpy counts below 0 from the end"
    assert all(0 <= n <= 7 for n in (columns.start, columns.stop))
    if by >= 0 and cells(window):
        lows, highs = (rows.start - by, columns.start - by), (rows.stop + by, columns.stop + by)
        inside = {p for p in ALL if all(a <= n < b for a, n, b in zip(lows, p, highs, strict=True))}
        assert cells(grown(window, by, SHAPE)) == inside
    assert cells(whole(SHAPE)) == ALL


A, B = (slice(1, 3), slice(2, 6)), (slice(2, 5), slice(0, 3))


def test_two_windows_join_to_the_least_that_holds_both() -> None:
    assert joined(A, B) == joined(B, A) == (slice(1, 5), slice(0, 6))
    assert joined(A, None) == joined(None, A) == A
    assert joined(None, None) is None


def test_a_window_is_seen_in_another() -> None:
    grid = np.arange(35).reshape(SHAPE)
    outer = (slice(1, 5), slice(1, 7))
    np.testing.assert_array_equal(grid[outer][seen_in(A, outer)], grid[A])


@pytest.mark.parametrize("seed", range(20))
def test_the_least_window_of_what_has_changed(seed: int) -> None:
    changed = np.random.default_rng(seed).random((3, 4)) < 0.15
    found = within((slice(1, 4), slice(2, 6)), changed)
    cells = {(1 + int(r), 2 + int(c)) for r, c in np.argwhere(changed)}
    assert (found is None) == (not cells)
    if found is not None:
        rows, columns = [r for r, _ in cells], [c for _, c in cells]
        assert found == (
            slice(min(rows), max(rows) + 1),
            slice(min(columns), max(columns) + 1),
        )
