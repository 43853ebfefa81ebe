from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_slam.graph.hypotheses import Closure, Hypotheses
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph

CERTAIN = np.diag([1e4, 1e4, 1e6])
OFF = SE2(1.2, -0.4, 0.01)  # where drift has put the second lap


def laps(count: int = 40) -> PoseGraph:
    """Two laps of a ring of 40 m radius; the second as drift has it."""
    graph = PoseGraph()
    for k in range(2 * count):
        angle = 2.0 * math.pi * k / count
        pose = SE2(40.0 * math.sin(angle), -40.0 * math.cos(angle), angle)
        graph.add_node(OFF @ pose if k >= count else pose)
    for k in range(2 * count - 1):
        T = graph.pose(k).inverse() @ graph.pose(k + 1)
        graph.add_edge(Edge(k, k + 1, T, CERTAIN, EdgeKind.ODOMETRY))
    return graph


def closure(
    place: int,
    off: SE2 | None = None,
    *,
    weight: float = 1.0,
    enough: float = 2.0,
    information: Floats = CERTAIN,
    wide: bool = False,
) -> Closure:
    """The second lap's node at a place on the first's, or off it."""
    edge = Edge(place, place + 40, off or SE2(), information, EdgeKind.LOOP)
    return Closure(20 + place // 2, place // 2, edge, weight, enough, wide)


def test_one_closure_is_not_believed() -> None:
    graph = laps()
    assert Hypotheses().add(graph, closure(4)) == []


def test_closures_that_agree_are_believed_together() -> None:
    graph, held = laps(), Hypotheses()
    first, second = closure(4), closure(8)
    assert held.add(graph, first) == []
    assert held.add(graph, second) == [second, first]


def test_submaps_that_overlap_count_once() -> None:
    graph, held = laps(), Hypotheses()
    held.add(graph, closure(4))
    assert held.add(graph, closure(6)) == []


def test_submaps_that_overlap_on_one_side_alone_count_twice() -> None:
    graph, held = laps(), Hypotheses()
    first, second = closure(4), replace(closure(8), past=2)
    held.add(graph, first)
    assert held.add(graph, second) == [second, first]


@pytest.mark.parametrize(("gap", "believed"), [(0.1, 2), (0.4, 0)])
def test_closures_that_claim_to_know_all_agree_to_a_hand_s_breadth(
    gap: float, believed: int
) -> None:
    graph, held = laps(), Hypotheses()
    held.add(graph, closure(4, information=1e6 * CERTAIN))
    other = closure(8, SE2(gap, 0.0, 0.0), information=1e6 * CERTAIN)
    assert len(held.add(graph, other)) == believed


def test_a_closure_that_disagrees_is_left_out() -> None:
    graph, held = laps(), Hypotheses()
    wrong = closure(6, SE2(5.0, 0.0, 0.0))
    for one in (closure(4, enough=3.0), wrong, closure(8, enough=3.0)):
        assert held.add(graph, one) == []
    believed = held.add(graph, closure(12, enough=3.0))
    assert len(believed) == 3
    assert wrong not in believed


def test_what_may_as_well_be_elsewhere_counts_half() -> None:
    graph, held = laps(), Hypotheses()
    held.add(graph, closure(4, weight=0.5))
    assert held.add(graph, closure(8, weight=0.5)) == []


def test_what_does_not_see_a_direction_bears_nothing_out_along_it() -> None:
    """Along a corridor half of what is matched knows nothing, and would agree with any door."""
    graph, held = laps(), Hypotheses()
    door = closure(4, SE2(1.2, 0.0, 0.0))
    walls = [closure(place, information=np.diag([1e-4, 1e4, 1e6])) for place in (0, 8, 12)]
    believed = [one for entry in (door, *walls) for one in held.add(graph, entry)]
    assert len(believed) > 1
    assert door not in believed


def test_what_needs_little_does_not_make_others_believed() -> None:
    graph, held = laps(), Hypotheses()
    first, sure = closure(4, enough=3.0), closure(8, enough=0.5)
    assert held.add(graph, first) == []
    assert held.add(graph, sure) == [sure]


def off_by(graph: PoseGraph, place: int, gap: float) -> SE2:
    """Where a place was seen again if the second lap is off by so much [m]."""
    return graph.pose(place).inverse() @ graph.pose(place + 40) @ SE2(gap, 0.0, 0.0)


def test_what_much_of_a_place_holds_near_by_is_believed_alone() -> None:
    graph = laps()
    near, far = (closure(4, off_by(graph, 4, gap), wide=True) for gap in (1.0, 2.5))
    assert Hypotheses().add(graph, near) == [near]
    assert Hypotheses().add(graph, far) == []


def test_what_others_have_bent_near_is_believed_with_the_next() -> None:
    """How near a closure lies is asked anew; drift has been taken out of the graph since."""
    graph, held = laps(), Hypotheses()
    first = closure(4, off_by(graph, 4, 2.5), wide=True)
    second = closure(30, off_by(graph, 30, 2.5), weight=0.5, enough=0.5)
    assert held.add(graph, first) == []
    for node in range(40, 80):
        graph.poses[node] = (graph.pose(node) @ SE2(2.0, 0.0, 0.0)).array()
    assert first in held.add(graph, second)


def aside(graph: PoseGraph, place: int, gap: float, *, wide: bool = False) -> Closure:
    """A place seen again in what would be another corridor, so far beside [m]."""
    found = graph.pose(place).inverse() @ SE2(0.0, gap, 0.0) @ graph.pose(place + 40)
    return closure(place, found, weight=1.0 if wide else 0.5, wide=wide)


def test_another_corridor_is_believed_in_only_with_a_wide_place() -> None:
    """Equal doors agree in a corridor side by side as well, as many of them as there are."""
    graph, places = laps(), range(0, 40, 4)
    for gap, wide_places, count in ((1.2, (), 8), (3.7, (), 0), (3.7, (20,), 6)):
        held = Hypotheses()
        doors = [aside(graph, place, gap, wide=place in wide_places) for place in places]
        assert len([one for entry in doors for one in held.add(graph, entry)]) == count


def test_doors_of_the_next_corridor_do_not_hold_back_wide_places() -> None:
    graph, held = laps(), Hypotheses()
    for place in range(0, 40, 4):
        assert not held.add(graph, aside(graph, place, 3.7))
    wide = [closure(place, wide=True) for place in (10, 14)]
    assert [one for entry in wide for one in held.add(graph, entry)] == wide
