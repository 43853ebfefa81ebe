"""Small groups of lethal cells: noise that the denoise layer sets free, wherever a change cuts."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import FREE, LETHAL, UNKNOWN, LayeredCostmap, PlacedScan
from tests.helpers.nav.layers import costmap_config, see


def grid(*rows: str) -> NDArray[np.uint8]:
    """Return a grid drawn with # lethal, ? unknown."""
    table = {"#": LETHAL, "?": UNKNOWN, ".": FREE}
    return np.array([[table[c] for c in row] for row in rows], np.uint8)


DRAWN = ("#..##..", "...??..", ".#...#.", "..#...#", "......#")


@pytest.mark.parametrize(
    ("least", "connectivity", "left"),
    [
        (1, 8, DRAWN),
        (-1, 8, DRAWN),
        (1000, 8, (".......", "...??..", ".......", ".......", ".......")),
        (2, 8, ("...##..", "...??..", ".#...#.", "..#...#", "......#")),
        (2, 4, ("...##..", "...??..", ".......", "......#", "......#")),
        (3, 8, (".......", "...??..", ".....#.", "......#", "......#")),
    ],
)
def test_too_small_groups_are_free(least: int, connectivity: int, left: tuple[str, ...]) -> None:
    data = grid(*DRAWN)
    values = {"minimal_group_size": least, "group_connectivity_type": connectivity}
    layered = LayeredCostmap(costmap_config(plugins=("denoise_layer",), denoise_layer=values))
    layered.layers["denoise_layer"].write(data, (slice(0, 5), slice(0, 7)))
    assert np.array_equal(data, grid(*left))


def test_what_changes_is_as_if_all_were_composed() -> None:
    layers = "obstacle_layer", "denoise_layer", "inflation_layer"
    config = costmap_config(
        width=6,
        height=6,
        resolution=0.1,
        plugins=layers,
        denoise_layer={"minimal_group_size": 4},
        inflation_layer={"inflation_radius": 0.3},
    )
    layered, rng = LayeredCostmap(config), np.random.default_rng(4)
    for k in range(12):
        pose = SE2(3.0 + 0.1 * k, 3.0, 0.3 * k)
        scan = Scan(rng.uniform(0.4, 2.4, 60), -3.0, 0.02, 0.1, 10.0)
        see(layered, pose, float(k), [PlacedScan(scan, pose)])
        changed = layered.costmap.data.copy()
        layered.compose_again()
        assert np.array_equal(layered.costmap.data, changed)
    assert (layered.costmap.data == LETHAL).any()
