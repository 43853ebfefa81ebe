from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import InputFileError
from arjuna_slam.graph.optimizer import optimize
from tests.helpers.posegraph import read_graph

G2O = """\
# a comment
VERTEX_SE2 7 1 0 1.5707963267948966
VERTEX_SE2 3 0 0 0
EDGE_SE2 3 7 1 0 1.5707963267948966 4 1 0 9 0 25
"""
TORO = """\
VERTEX2 3 0 0 0
VERTEX2 7 1 0 1.5707963267948966
EDGE2 3 7 1 0 1.5707963267948966 4 1 9 25 0 0
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "graph"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("text", [G2O, TORO])
def test_both_formats_give_the_same_graph(tmp_path: Path, text: str) -> None:
    poses, edges = read_graph(written(tmp_path, text))
    assert poses[:, 0].tolist() == [0.0, 1.0]
    assert (edges.i.tolist(), edges.j.tolist()) == ([0], [1])
    assert edges.measured[0] == pytest.approx([1.0, 0.0, math.pi / 2])


def test_information_is_in_the_axes_of_the_second_node(tmp_path: Path) -> None:
    """The files measure the error in the frame that the measurement turns to."""
    _, edges = read_graph(written(tmp_path, G2O))
    expected = np.array([(9.0, -1.0, 0.0), (-1.0, 4.0, 0.0), (0.0, 0.0, 25.0)])
    assert edges.information[0] == pytest.approx(expected)
    moved = np.array([(0.0, 0.0, 0.0), (1.0, 0.5, math.pi / 2)])
    assert optimize(moved, edges).trace[0] == pytest.approx(4.0 * 0.5**2)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("VERTEX_SE2 0 0 0\n", "line 1: 3 finite numbers are valid"),
        ("VERTEX_SE2 0 0 0 nan\n", "line 1: 3 finite numbers are valid"),
        ("VERTEX_SE2 0 0 0 0\n", "has no edges"),
        ("VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 9 1 0 0 1 0 0 1 0 1\n", r"nodes \[9\] have no vertex"),
    ],
)
def test_a_broken_file_is_refused_with_its_line(tmp_path: Path, text: str, problem: str) -> None:
    with pytest.raises(InputFileError, match=problem):
        read_graph(written(tmp_path, text))
