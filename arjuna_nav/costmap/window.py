"""Windows of cells: what of a grid has changed, and what that reaches."""

from __future__ import annotations

import numpy as np

from arjuna_core.arrays import Bools

Window = tuple[slice, slice]
"""Rows and columns of a grid, of whole numbers."""


def whole(shape: tuple[int, ...]) -> Window:
    """Return the window of all cells of a grid."""
    return slice(0, shape[0]), slice(0, shape[1])


def clipped(row0: int, row1: int, column0: int, column1: int, shape: tuple[int, ...]) -> Window:
    """Return the part of a window, its ends excluded, that lies in a grid; it may be empty."""
    rows = slice(min(max(row0, 0), shape[0]), max(min(row1, shape[0]), 0))
    columns = slice(min(max(column0, 0), shape[1]), max(min(column1, shape[1]), 0))
    return rows, columns


def grown(window: Window, by: int, shape: tuple[int, ...]) -> Window:
    """Return a window with so many more cells on each side, as far as the grid goes."""
    rows, columns = window
    return clipped(rows.start - by, rows.stop + by, columns.start - by, columns.stop + by, shape)


def joined(a: Window | None, b: Window | None) -> Window | None:
    """Return the least window that holds two others."""
    if a is None or b is None:
        return a or b
    rows, columns = (
        slice(min(p.start, q.start), max(p.stop, q.stop)) for p, q in zip(a, b, strict=True)
    )
    return rows, columns


def seen_in(window: Window, outer: Window) -> Window:
    """Return a window as it lies in another that holds it."""
    rows, columns = (
        slice(p.start - q.start, p.stop - q.start) for p, q in zip(window, outer, strict=True)
    )
    return rows, columns


def within(window: Window, changed: Bools) -> Window | None:
    """Return the least window of the cells that have changed in one, None where none has."""
    rows, columns = (np.flatnonzero(changed.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return None
    row, column = window[0].start, window[1].start
    return (
        slice(row + int(rows[0]), row + int(rows[-1]) + 1),
        slice(column + int(columns[0]), column + int(columns[-1]) + 1),
    )
