"""NavFn over flat arrays in C, compiled here, as a peer to measure by."""

from __future__ import annotations

import ctypes

import numpy as np
from numpy.typing import NDArray

from tests.helpers import c_peer

_FAR = 1e9  # potentials beyond are of cells that the wave did not reach


class ArrayNavFn:
    """A plan's arrays for maps of one size, kept between plans as nav2's are.

    Args:
        library: Of `compiled`.
        shape: `(height, width)` of the maps.
    """

    def __init__(self, library: ctypes.CDLL, shape: tuple[int, ...]) -> None:
        self._library = library
        self._shape = shape
        self._plan = ctypes.c_void_p(library.plan_make(shape[1], shape[0]))

    def close(self) -> None:
        """Free the arrays."""
        self._library.plan_free(self._plan)

    def plan(
        self, data: NDArray[np.uint8], start: tuple[int, int], goal: tuple[int, int], astar: bool
    ) -> NDArray[np.float64]:
        """Return the path between two cells, `(N, 2)` rows and columns from the goal; (0, 2): none.

        Args:
            data: Costs of a costmap, of the shape of these arrays, contiguous.
            start: `(row, column)` where the wave begins.
            goal: As `start`.
            astar: Whether by A*, else by Dijkstra.
        """
        width = self._shape[1]
        cells = (cell[0] * width + cell[1] for cell in (start, goal))
        address = data.ctypes.data_as(ctypes.c_void_p)
        count = self._library.plan_path(self._plan, address, *cells, int(astar))
        y, x = (
            np.ctypeslib.as_array(ctypes.cast(get(self._plan), _FLOATS), (max(count, 1),))[:count]
            for get in (self._library.plan_y, self._library.plan_x)
        )
        return np.column_stack((y, x)).astype(np.float64)

    def potential(self) -> NDArray[np.float32]:
        """Return the potentials of the last plan, inf where its wave did not come."""
        address = ctypes.cast(self._library.plan_potential(self._plan), _FLOATS)
        found = np.ctypeslib.as_array(address, self._shape)
        result: NDArray[np.float32] = np.where(found < _FAR, found, np.float32(np.inf))
        return result


_FLOATS = ctypes.POINTER(ctypes.c_float)


def compiled() -> ctypes.CDLL | None:
    """Return the peer's library, optimised as releases are; None where no compiler is."""
    library = c_peer.compiled("navfn_array", "-O3")
    if library is None:
        return None
    for name in ("plan_make", "plan_potential", "plan_x", "plan_y"):
        getattr(library, name).restype = ctypes.c_void_p
    for name in ("plan_free", "plan_potential", "plan_x", "plan_y"):
        getattr(library, name).argtypes = [ctypes.c_void_p]
    return library
