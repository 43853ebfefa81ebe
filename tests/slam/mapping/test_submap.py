from __future__ import annotations

import numpy as np

from arjuna_core.se2 import SE2
from arjuna_slam.mapping.submap import LocalMap, SubmapConfig
from arjuna_slam.matching.surface import Surface

SEEN = Surface(np.array([[1.0, 0.0]]), np.array([[-1.0, 0.0]]), np.zeros(1, np.bool_))


def test_a_robot_that_drives_and_then_turns_stays_where_it_is() -> None:
    """Half full by way, then half full by count: three submaps are built at a time then."""
    local, at = LocalMap(SubmapConfig(submap_size=20, submap_length=10.0)), SE2()
    world: list[SE2] = []
    most = 0
    for node in range(60):
        step = SE2(0.0, 0.0, 0.4) if node % 20 > 6 else SE2(0.9, 0.0, 0.0)
        world.append((world[-1] if world else SE2(2.0, 1.0, 0.3)) @ step)
        if node:
            at = at @ (world[-2].inverse() @ world[-1])
        at = local.insert(node, SEEN, at)
        most = max(most, len(local.active))
        assert (world[local.reference.anchor] @ at).distance(world[-1]) < 1e-9
    assert most == 3
    assert all(submap.poses[0].distance(SE2()) < 1e-9 for submap in local.finished)


def test_only_the_fields_that_were_asked_for_last_stay_grids() -> None:
    local, at = LocalMap(SubmapConfig(submap_length=2.0)), SE2()
    for node in range(60):
        at = local.insert(node, SEEN, at @ SE2(0.9, 0.0, 0.0))
    assert len(local.finished) > 15
    first = local.finished[0].field
    assert local.finished[0].field is first
    assert all(len(submap.field.planes) > 1 for submap in local.finished)
    assert local.finished[0].field is not first
    assert np.array_equal(local.finished[0].field.score, first.score)
