"""Rivals: other poses where a submap fits a past one as well, as far as the past one has seen.

In a row of equal doors a submap fits a door further on as well; there it often reaches beyond what
the past one has seen. Where nobody has looked nothing speaks against it, so only what lies on
ground that was seen is compared.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from arjuna_core.arrays import Bools, Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.matching.contradiction import gone_through
from arjuna_slam.matching.correlative import Window, searching
from arjuna_slam.matching.field import Field

APART = 0.8  # another peak is one that lies so far from the best [m]

Views = Sequence[tuple[Scan, SE2]]


@dataclass(frozen=True)
class SeenField:
    """A past submap's likelihoods, and where it has seen anything."""

    field: Field  # the likelihoods
    seen: Bools  # of each of its cells, `(H, W) bool`

    @staticmethod
    def of(surface: Field, field: Field, views: Views, range_max: float) -> SeenField:
        """Find the cells of a field that scans have seen: near its walls, and where beams pass.

        Points far along a corridor lie apart from each other: between them nothing is known.
        `field` is the submap's `surface` in cells twice as wide; views are in its frame.
        """
        block = 4  # cells in a row that are asked together whether they were seen
        size = block * field.resolution
        height, width = field.score.shape
        rows, columns = -(-height // block), -(-width // block)
        walls = np.zeros((2 * block * rows, 2 * block * columns), np.bool_)
        walls[: surface.index.shape[0], : surface.index.shape[1]] = surface.index > 0
        blocks = walls.reshape(rows, 2 * block, columns, 2 * block).any(axis=(1, 3))
        near = sliding_window_view(np.pad(blocks, 1), (3, 3)).any(axis=(2, 3))
        middles = np.indices((rows, columns)).reshape(2, -1).T[:, ::-1] + 0.5
        free = gone_through(field.origin + size * middles, views, range_max)
        blocks = near | free.reshape(rows, columns)
        cells = blocks.repeat(block, axis=0).repeat(block, axis=1)
        return SeenField(field, cells[:height, :width] | (field.score > 0))

    def neutral(self, likelihood: float, reach: float) -> Field:
        """Return a field in which what was not seen, `reach` [m] around too, has one likelihood."""
        border = int(np.ceil(reach / self.field.resolution))
        level = np.uint8(255.0 * likelihood)
        result = Field(self.field.resolution, self.field.sigma)
        score = np.where(self.seen, self.field.score, level)
        result.score = np.pad(score, border, constant_values=level)
        result.origin = self.field.origin - border * self.field.resolution
        return result


def rival(
    past: SeenField,
    points: Floats,
    best: SE2,
    pieces: Sequence[tuple[SE2, Window]],
    share: float,
    contradicted: Callable[[SE2], bool],
) -> Generator[None, None, SE2 | None]:
    """Return another pose where a submap fits as well as at the best, or None.

    `points` are some of the submap's, `pieces` those of the window, each with its middle. A rival
    has at least a share of the best mean likelihood on seen ground, and is not contradicted.
    """
    neutral = 0.83  # of the best mean, of ground that nobody has seen: so much must be seen
    placed = best.apply(points)
    on = past.field.at(placed, past.seen)
    mean = float(past.field.likelihood(placed[on]).mean()) if on.any() else 0.0
    reach = max(middle.distance(best) + piece.xy for middle, piece in pieces)
    field = past.neutral(neutral * mean, 2.0 * reach + float(np.hypot(*points.T).max()))
    yield
    refused = [best]
    seen_min, most = 0.4, 16  # share on seen ground, of that at the best pose; peaks that are tried
    for middle, piece in pieces:
        while True:
            beside = refused, APART
            found = yield from searching(field, points, middle, piece, share * mean, beside)
            yield
            if found is None:
                break
            there = float(past.field.at(found[0].apply(points), past.seen).mean())
            fits = there >= seen_min * on.mean() and not contradicted(found[0])
            if fits or len(refused) == most:
                return found[0]
            refused.append(found[0])
    return None
