from __future__ import annotations

from collections.abc import Generator

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.graph.place_match import Place, PlaceMatcher, Search
from arjuna_slam.mapping.submap import Submap
from arjuna_slam.matching.scan_matcher import ScanMatcher

Wall = tuple[float, float, float, float]  # from x, y to x, y [m]
CORRIDOR: tuple[Wall, ...] = ((0.0, 0.0, 16.0, 0.0), (0.0, 2.0, 16.0, 2.0))
JAMB: Wall = (7.5, 2.0, 7.5, 2.6)
ENDS: tuple[Wall, ...] = ((0.5, -6.0, 0.5, 0.0), (15.5, 2.0, 15.5, 11.0))
MOVED = SE2(0.3, -0.1, 0.02)


def submap(walls: tuple[Wall, ...], T: SE2) -> Submap:
    """What walls look like from a frame that T takes them to."""
    result = Submap(SlamConfig().field())
    for ax, ay, bx, by in walls:
        a, way = np.array([ax, ay]), np.array([bx - ax, by - ay])
        length = float(np.hypot(*way))
        points = a + np.linspace(0.0, 1.0, int(length / 0.02))[:, None] * way
        normals = np.tile(np.array([-way[1], way[0]]) / length, (len(points), 1))
        result.field.add(T.apply(points), SE2(0.0, 0.0, T.theta).apply(normals))
    return result


def find(walls: tuple[Wall, ...]) -> Place:
    """Look for walls where they are, from a frame that is off."""
    config = SlamConfig()
    matcher = PlaceMatcher(config, ScanMatcher(config), config.max_laser_range)
    window = Search(SE2(), np.diag([0.25, 0.25, 0.01]), 1.0, 0.1)
    work = matcher.find(submap(walls, MOVED.inverse()), submap(walls, SE2()), window, [])
    found: list[Place | None] = []

    def finished() -> Generator[None, None, None]:
        found.append((yield from work))

    assert list(finished())
    assert found[0] is not None
    return found[0]


@pytest.mark.parametrize(
    ("walls", "least", "most"), [((*CORRIDOR, JAMB), 1.0, 2.0), ((*CORRIDOR, *ENDS), 13.0, 18.0)]
)
def test_a_door_holds_a_corridor_on_less_ground_than_its_ends(
    walls: tuple[Wall, ...], least: float, most: float
) -> None:
    place = find(walls)
    assert place.T_past_query.distance(MOVED) < 0.02
    assert least <= place.area <= most
