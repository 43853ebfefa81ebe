"""Which closures agree, what supports a correction, and which sets outweigh others."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.graph.hypotheses import Closure, Hypotheses
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph
from arjuna_slam.graph.uncertainty import relative_covariances

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
    node: int,
    off: SE2 | None = None,
    *,
    weight: float = 1.0,
    enough: float = 2.0,
    information: Floats = CERTAIN,
    wide: bool = False,
) -> Closure:
    """The second lap's node at a node on the first's, or off it."""
    edge = Edge(node, node + 40, off or SE2(), information, EdgeKind.LOOP)
    return Closure(20 + node // 2, node // 2, edge, weight, enough, wide)


def test_closures_that_agree_are_believed_together() -> None:
    graph, held = laps(), Hypotheses()
    first, second = closure(4), closure(8)
    assert held.add(graph, first) == []
    assert held.add(graph, second) == [second, first]


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


def test_what_needs_little_does_not_make_others_believed() -> None:
    graph, held = laps(), Hypotheses()
    first, sure = closure(4, enough=3.0), closure(8, enough=0.5)
    assert held.add(graph, first) == []
    assert held.add(graph, sure) == [sure]


def off_by(graph: PoseGraph, node: int, gap: float) -> SE2:
    """Return a node's pose seen again if the second lap is off by so much [m]."""
    return graph.pose(node).inverse() @ graph.pose(node + 40) @ SE2(gap, 0.0, 0.0)


def test_what_others_have_bent_near_is_believed_with_the_next() -> None:
    """A closure's distance is asked again: the graph has been corrected since."""
    graph, held = laps(), Hypotheses()
    first = closure(4, off_by(graph, 4, 2.5), wide=True)
    second = closure(30, off_by(graph, 30, 2.5), weight=0.5, enough=0.5)
    assert held.add(graph, first) == []
    for node in range(40, 80):
        graph.poses[node] = (graph.pose(node) @ SE2(2.0, 0.0, 0.0)).array()
    assert first in held.add(graph, second)


def aside(graph: PoseGraph, node: int, gap: float, *, wide: bool = False) -> Closure:
    """A node seen again in what would be another corridor, so far beside [m]."""
    found = graph.pose(node).inverse() @ SE2(0.0, gap, 0.0) @ graph.pose(node + 40)
    return closure(node, found, weight=1.0 if wide else 0.5, wide=wide)


def test_another_corridor_is_believed_in_only_with_a_wide_closure() -> None:
    """Equal doors agree in a corridor side by side as well, as many of them as there are."""
    graph, nodes = laps(), range(0, 40, 4)
    for gap, wide_nodes, count in ((1.2, (), 8), (3.7, (), 0), (3.7, (20,), 6)):
        held = Hypotheses()
        doors = [aside(graph, node, gap, wide=node in wide_nodes) for node in nodes]
        assert len([one for entry in doors for one in held.add(graph, entry)]) == count


DOOR = np.diag([25.0, 25.0, 1e6])  # known to 0.2 m
WALL = np.diag([1e-4, 1e4, 1e6])  # known across alone


def believed(graph: PoseGraph, *closures: Closure) -> list[Closure]:
    held = Hypotheses()
    return [one for entry in closures for one in held.add(graph, entry)]


def chain(parts: list[SE2], knows: list[Floats]) -> Floats:
    """Return the covariance of a chain by its numeric derivatives, `(3, 3) float64`."""

    def end(k: int, change: Floats) -> Floats:
        result = IDENTITY
        for n, part in enumerate(parts):
            result = result @ (SE2.from_array(part.array() + change) if n == k else part)
        return result.array()

    total = np.zeros((3, 3))
    for k, known in enumerate(knows):
        columns = [end(k, d) - end(k, -d) for d in 1e-6 * np.eye(3)]
        columns = [np.append(c[:2], math.remainder(c[2], 2.0 * math.pi)) / 2e-6 for c in columns]
        slope = np.column_stack(columns)
        total += slope @ known @ slope.T
    return total


def deviations(graph: PoseGraph, new: Edge, held: Edge) -> float:
    """Return by how many deviations, squared, two paths to the held one's second node differ."""
    to_held = graph.pose(new.i).inverse() @ graph.pose(held.i)
    from_new = graph.pose(new.j).inverse() @ graph.pose(held.j)
    at_i = relative_covariances(graph, new.i)[held.i]
    at_j = relative_covariances(graph, new.j)[held.j]
    known, also = (np.asarray(np.linalg.inv(e.information), np.float64) for e in (held, new))
    covariance = chain([to_held, held.T_i_j], [at_i, known])
    covariance += chain([new.T_i_j, from_new], [also, at_j])
    covariance += np.diag([0.05**2, 0.05**2, 0.005**2])
    error = (to_held @ held.T_i_j).array() - (new.T_i_j @ from_new).array()
    error[2] = math.remainder(error[2], 2.0 * math.pi)
    return float(error @ np.linalg.solve(covariance, error))


@pytest.mark.parametrize(
    "direction", [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (0.5, 0.5, -1)]
)
@pytest.mark.parametrize(
    ("first", "second", "nodes"),
    [
        (CERTAIN, CERTAIN, (4, 8)),
        (1e6 * CERTAIN, 1e6 * CERTAIN, (4, 8)),  # what is left where both claim to know better
        (DOOR, CERTAIN, (8, 4)),
        (CERTAIN, np.diag([30.0, 90.0, 1e4]), (4, 24)),  # where headings are half a turn apart
    ],
)
def test_closures_agree_up_to_what_they_and_the_graph_do_not_know(
    first: Floats, second: Floats, nodes: tuple[int, int], direction: tuple[float, float, float]
) -> None:
    """Up to 11.3 squared deviations: 99 % of pairs in three degrees of freedom."""
    graph = laps()
    graph.poses[40:] = graph.poses[:40]  # no drift: nothing else is asked of a closure
    held = closure(nodes[0], information=first)

    def off(by: float) -> Closure:
        return closure(nodes[1], SE2(*(by * part for part in direction)), information=second)

    low, high = (
        0.0,
        0.29 if direction[0] or direction[1] else 0.5,
    )  # m: no more is asked of what is small
    for _ in range(40):
        middle = 0.5 * (low + high)
        close = deviations(graph, off(middle).edge, held.edge) < 11.3
        low, high = (middle, high) if close else (low, middle)
    further = off(1.001 * low)
    agrees = deviations(graph, further.edge, held.edge) < 11.3
    assert len(believed(graph, held, further)) == (2 if agrees else 0)
    assert len(believed(graph, held, off(0.999 * low))) == 2


@pytest.mark.parametrize(("between", "is_held"), [(59, True), (60, False)])
def test_the_newest_sixty_are_held(between: int, is_held: bool) -> None:
    graph = laps()
    first, last = closure(4), closure(8)
    others = [closure(14 + k % 20, SE2(50.0 * (k + 1))) for k in range(between)]
    found = believed(graph, first, *others, last)
    assert found == ([last, first] if is_held else [])


def corrects(graph: PoseGraph, node: int, gap: float, known: Floats) -> Closure:
    """Return a closure that corrects the graph by so much ahead [m]."""
    return closure(node, off_by(graph, node, gap), information=known)


def along(deviation: float) -> Floats:
    return np.diag([deviation**-2, 1e4, 1e6])


@pytest.mark.parametrize(
    ("gap", "deviation", "alone"),
    [
        (0.29, 0.1, True),  # a small correction
        (0.31, 0.1, False),
        (0.8, 0.49, False),  # a direction that it knows
        (0.8, 0.51, True),
        (2.4, 0.79, False),  # or claims to, by correcting it so far
        (2.4, 0.81, True),
    ],
)
def test_small_unseen_corrections_are_believed(gap: float, deviation: float, alone: bool) -> None:
    graph = laps()
    door = corrects(graph, 4, gap, along(deviation))
    walls = [corrects(graph, node, 0.0, WALL) for node in (0, 8, 12)]
    assert (door in believed(graph, door, *walls)) is alone


def turned(degrees: float) -> Floats:
    """Return the information of what knows one direction alone, so far off its heading."""
    turn = SE2(0.0, 0.0, math.radians(degrees)).matrix()
    known: Floats = turn @ np.diag([25.0, 1e-4, 1e6]) @ turn.T
    return known


@pytest.mark.parametrize(
    ("gap", "degrees", "supports"),
    [
        (0.8, 0.0, True),
        (0.41, 0.0, True),  # moves it as far but for half
        (0.39, 0.0, False),
        (1.19, 0.0, True),
        (1.21, 0.0, False),
        (0.8, 44.0, True),  # sees that direction
        (0.8, -44.0, True),
        (0.8, 46.0, False),
        (0.8, 136.0, True),
    ],
)
def test_corrections_need_their_keyframes(gap: float, degrees: float, supports: bool) -> None:
    graph = laps()
    heading = graph.pose(4).theta

    def moved(node: int, by: float, known: Floats) -> Edge:
        """Return an edge that moves map ahead at the door."""
        change = SE2(by * math.cos(heading), by * math.sin(heading), 0.0)
        T = graph.pose(node).inverse() @ change @ graph.pose(node + 40)
        return Edge(node, node + 40, T, known, EdgeKind.LOOP)

    door = replace(closure(4), edge=moved(4, 0.8, turned(0.0)))
    angle = math.degrees(graph.pose(6).theta - heading)
    other = replace(closure(6), query=60, past=60, edge=moved(6, gap, turned(degrees - angle)))
    wall = replace(closure(4), query=70, past=70, enough=0.5, edge=moved(4, 0.0, WALL))
    assert (door in believed(graph, other, door, wall)) is supports


@pytest.mark.parametrize(
    ("queries", "pasts", "weights", "count"),
    [
        ((1, 1), (1, 1), (1.0, 1.0), 0),
        ((2, 0), (0, 1), (1.0, 1.0), 2),
        ((0, 1), (2, 0), (1.0, 1.0), 2),
        ((0, 1), (1, 0), (0.5, 2.0), 2),  # the heavier of two that see the same counts
        ((0, 1), (1, 0), (2.0, 0.5), 1),  # it was believed before
    ],
)
def test_what_overlaps_counts_once(
    queries: tuple[int, int], pasts: tuple[int, int], weights: tuple[float, float], count: int
) -> None:
    closures = [
        replace(closure(4 + 2 * k), query=30 + q, past=7 + p, weight=weight)
        for k, (q, p, weight) in enumerate(zip(queries, pasts, weights, strict=True))
    ]
    assert len(believed(laps(), *closures)) == count


@pytest.mark.parametrize(
    ("weight", "step", "count"),
    [(1.0, 0, 2), (1.1, 0, 0), (1.1, 1, 0), (1.1, -1, 0), (9.0, 2, 2), (9.0, -2, 2)],
)
def test_a_set_must_outweigh_its_rival(weight: float, step: int, count: int) -> None:
    graph = laps()
    rival = replace(closure(6, SE2(5.0)), query=30 + step, past=50, weight=weight, enough=99.0)
    pair = [replace(closure(4 + 4 * k), query=30, past=10 * k) for k in range(2)]
    held = Hypotheses()
    assert held.add(graph, rival) == []
    assert held.add(graph, pair[0]) == []
    assert len(held.add(graph, pair[1])) == count


@pytest.mark.parametrize(
    ("wide", "rival_wide", "count"),
    [(True, False, 2), (True, True, 0), (False, False, 0), (False, True, 0)],
)
def test_doors_alone_do_not_outweigh_wide_nodes(wide: bool, rival_wide: bool, count: int) -> None:
    """Four against four; but equal doors agree in the next corridor as well."""
    graph = laps()
    rivals = [
        replace(closure(5, SE2(5.0)), query=30, past=50 + 10 * k, enough=99.0, wide=rival_wide)
        for k in range(4)
    ]
    pair = [
        replace(closure(4 + 4 * k), query=30, past=10 * k, weight=2.0, enough=4.0, wide=wide)
        for k in range(2)
    ]
    assert len(believed(graph, *rivals, *pair)) == count


@pytest.mark.parametrize(
    ("gap", "enough", "alone"),
    [(1.4, 2.0, True), (1.49, 2.0, True), (1.51, 2.0, False), (0.5, 2.1, False)],
)
def test_a_close_wide_closure_counts_twice(gap: float, enough: float, alone: bool) -> None:
    graph = laps()
    wide = closure(4, off_by(graph, 4, gap), wide=True, enough=enough)
    assert believed(graph, wide) == ([wide] if alone else [])
