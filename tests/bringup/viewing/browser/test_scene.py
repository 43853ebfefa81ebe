"""Claims: each kind of drawing becomes a scene node, changes in place where it can, and goes."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser", reason="no viewer here")

import viser

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.pose3 import Pose3
from bringup.viewing.browser.scene import Scene
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.drawing.solids import solids
from bringup.viewing.drawing.values import (
    Arrows,
    Axes,
    Drawing,
    Grid,
    Label,
    Line,
    Points,
    Segments,
    Solids,
)

XYZ = np.zeros((3, 3), np.float32)
ENDS = np.arange(18, dtype=np.float32).reshape(3, 2, 3)
ROW = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (1, 2, 3), 1.0)
COLOURS = np.zeros((3, 3), np.uint8)
GRID = OccupancyGrid(GridFrame(0.5, 4, 2), np.zeros((2, 4), np.int8))
KINDS: tuple[tuple[Drawing, dict[str, Any], str], ...] = (
    (Points(points=XYZ, colour=(1, 2, 3)), {"points": XYZ[:2] + 1}, "points"),
    (Points(points=XYZ, colour=COLOURS), {"points": XYZ[:2] + 1, "colour": COLOURS[:2]}, "points"),
    (Line(points=XYZ, colour=(1, 2, 3)), {"points": XYZ + 1}, "points"),
    (Arrows(segments=ENDS, colour=(1, 2, 3)), {"segments": ENDS[:2] + 1}, "points"),
    (
        Segments(segments=ENDS, colours=np.zeros((3, 2, 3), np.uint8), width=0.1),
        {"segments": ENDS + 1},
        "points",
    ),
    (solids("box", [ROW, ROW]), {"positions": XYZ[:2] + 1}, "batched_positions"),
    (Axes(positions=XYZ, wxyzs=np.ones((3, 4), np.float32)), {"positions": XYZ + 1}, "visible"),
    (Label(text="a"), {"text": "b"}, "text"),
    (Grid(grid=GRID, opacity=0.5), {}, "visible"),
)


@pytest.fixture
def scene(server: viser.ViserServer) -> Scene:
    made = Scene(server)
    made.add("one", True)
    return made


def node(scene: Scene) -> Any:
    return scene._drawn["one", ""][1]


@pytest.mark.parametrize(
    ("drawing", "change", "field"), KINDS, ids=[type(d).__name__ for d, _, _ in KINDS]
)
def test_a_drawing_changes_its_node_and_removes_it(
    drawing: Drawing, change: dict[str, Any], field: str, scene: Scene
) -> None:
    scene.draw("one", {"": drawing})
    scene.update(Frames("map"))
    before = node(scene)
    assert before.visible
    scene.draw("one", {"": replace(drawing, **change)})
    scene.update(Frames("map"))
    assert node(scene) is before
    if change and field != "visible":
        value = next(iter(change.values()))
        assert np.shape(getattr(before, field))[1:] == np.shape(value)[1:] or field == "points"
        assert (
            np.array_equal(getattr(before, field), np.asarray(value)) or drawing.__class__ is Line
        )
    scene.draw("one", {})
    assert before._impl.removed


def test_few_numbers_of_bodies_are_another_node(scene: Scene) -> None:
    nodes = []
    for count in (3, 4, 5):
        scene.draw("one", {"": solids("sphere", [ROW] * count)})
        scene.update(Frames("map"))
        assert isinstance(scene._drawn["one", ""][0], Solids)
        nodes.append(node(scene))
        assert np.count_nonzero(nodes[-1].batched_scales[:, 0]) == count
    assert nodes[0] is nodes[1]
    assert nodes[1] is not nodes[2]
    scene.draw("one", {"": solids("sphere", [])})
    assert not scene._drawn


@pytest.mark.parametrize("opacity", [None, 0.5])
def test_a_map_that_comes_again_is_not_sent_again(opacity: float | None, scene: Scene) -> None:
    other = OccupancyGrid(GRID.frame, np.full((2, 4), 100, np.int8))
    nodes, pictures = [], []
    for grid in (GRID, OccupancyGrid(GRID.frame, GRID.data.copy()), other):
        scene.draw("one", {"": Grid(grid=grid, opacity=opacity)})
        nodes.append(node(scene))
        pictures.append(id(getattr(nodes[-1], "image", None)))
    assert nodes[0] is nodes[1]
    assert (nodes[1] is nodes[2]) is (opacity is not None)  # a browser decodes maps meanwhile
    assert pictures[0] == pictures[1]


def test_bodies_have_opacities_only_where_they_are_seen_through(scene: Scene) -> None:
    clear = (*ROW[:4], 0.5)
    for row, opaque in ((ROW, True), (clear, False), (ROW, True)):
        scene.draw("one", {"": solids("box", [row])})
        assert (node(scene).batched_opacities is None) is opaque


def test_a_newcomer_looks_where_all_were_turned_to(scene: Scene) -> None:
    scene.frame_map(Grid(grid=GRID))
    camera = SimpleNamespace(position=None, look_at=None)
    client = SimpleNamespace(camera=camera, client_id=1)
    scene.greet(client)
    camera.look_at = np.zeros(3)  # it had not begun yet
    scene.confirm(client)
    assert camera.look_at == pytest.approx([1.0, 0.5, 0.0])
    assert camera.position == pytest.approx([1.0, -1.0, 2.25])
    scene.confirm(client)
    camera.look_at = np.zeros(3)  # a person turns it
    scene.confirm(client)
    assert camera.look_at == pytest.approx([0.0, 0.0, 0.0])


def test_many_arrows_are_lines(scene: Scene) -> None:
    arrows = Arrows(segments=np.zeros((101, 2, 3), np.float32), colour=(1, 2, 3))
    scene.draw("one", {"": arrows})
    assert type(node(scene)).__name__ == "LineSegmentsHandle"
    scene.draw("one", {"": replace(arrows, segments=arrows.segments[:5])})
    assert type(node(scene)).__name__ == "ArrowsHandle"


def test_points_on_the_floor_are_there_whatever_the_sensor_s_height(scene: Scene) -> None:
    frames = Frames("map")
    frames.insert("map", "lidar", 0.0, Pose3((1.0, 2.0, 0.4)), static=True)
    scan = Points(points=XYZ, colour=(1, 2, 3), frame="lidar", floor=True)
    scene.draw("one", {"": scan})
    scene.update(frames)
    assert node(scene).position == pytest.approx((1.0, 2.0, 0.02))
