"""Two processes with nodes of one name are warned of, those that died are not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from bringup.processes import reporter
from bringup.processes.reporter import Twins

pytestmark = pytest.mark.ros
PAIRS = [("sim", "/"), ("sim", "/other"), ("amcl", "/")]


class Graph:
    """A node that sees nodes and keeps what it is to log."""

    def __init__(self) -> None:
        self.pairs = list(PAIRS)
        self.warnings: list[str] = []

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        return self.pairs

    def get_logger(self) -> Any:
        return SimpleNamespace(warning=self.warnings.append)


@pytest.fixture
def graph(monkeypatch: pytest.MonkeyPatch) -> Graph:
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    monkeypatch.setattr(reporter, "any_dead", lambda node: False)
    return Graph()


def test_each_pair_is_warned_of_once(graph: Graph) -> None:
    looking = Twins(graph, ["/sim", "/amcl"])
    looking.look(0.0)
    assert graph.warnings == []
    graph.pairs = [*PAIRS, ("sim", "/")]
    for now in (1.0, 2.0, 3.0):
        looking.look(now)
    assert graph.warnings == [
        "another process has /sim too: end one of the two, or give one a --namespace or another"
        " --domain-id (here 7)"
    ]
    graph.pairs = PAIRS
    looking.look(4.0)
    graph.pairs = [*PAIRS, ("sim", "/")]
    looking.look(5.0)
    assert len(graph.warnings) == 2


def test_a_dead_process_may_be_remembered(graph: Graph, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reporter, "any_dead", lambda node: True)
    graph.pairs = [*PAIRS, ("sim", "/")]
    looking = Twins(graph, ["/sim"])
    for now in range(25):
        looking.look(float(now))
    assert graph.warnings == []
    looking.look(25.0)
    assert len(graph.warnings) == 1


def test_a_second_filter_of_odometry_is_told_how_the_simulators_gives_way(graph: Graph) -> None:
    looking = Twins(graph, ["/ekf_filter_node"])
    graph.pairs = [("ekf_filter_node", "/")] * 2
    looking.look(0.0)
    (warning,) = graph.warnings
    assert "the simulator's own gives way to 'sim --params FILE'" in warning
