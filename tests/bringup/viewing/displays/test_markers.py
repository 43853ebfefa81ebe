"""Claims: markers of every kind, their frames, lifetimes and ends, drawn with few drawings."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from bringup.viewing.displays.base import DisplaySpec, Moment
from bringup.viewing.displays.markers import InteractiveMarkers, MarkerArray
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.drawing.values import Axes, Drawing, Label, Model, Points, Segments, Solids
from tests.bringup.viewing.drives import header, make, pose

ADD, DELETE, DELETE_ALL = 0, 2, 3
ARROW, CUBE, LINE_STRIP, CUBE_LIST, POINTS, TEXT, MESH = 0, 1, 4, 6, 8, 9, 10
CORNERS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]


def point(x: float, y: float, z: float = 0.0) -> Any:
    return make("geometry_msgs/msg/Point", x=x, y=y, z=z)


def vector(x: float, y: float, z: float) -> Any:
    return make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)


def colour(red: float, alpha: float = 1.0) -> Any:
    return make("std_msgs/msg/ColorRGBA", r=red, a=alpha)


def time(seconds: float) -> Any:
    whole = int(seconds)
    return make("builtin_interfaces/msg/Time", sec=whole, nanosec=round(1e9 * (seconds - whole)))


def marker(
    kind: int = CUBE, frame: str = "map", stamp: float = 0.0, lifetime: float = 0.0, **fields: Any
) -> Any:
    head = header(frame)
    head.stamp = time(stamp)
    given = {"scale": vector(0.2, 0.4, 0.6), "color": colour(1.0), "pose": pose(2.0)} | fields
    return make(
        "visualization_msgs/msg/Marker", header=head, type=kind, lifetime=time(lifetime), **given
    )


class Shown:
    """A display of marker arrays with a tree of frames: map, and odom 1 m beside it."""

    def __init__(self, **settings: Any) -> None:
        display = DisplaySpec("MarkerArray", "markers", settings=settings).make()
        assert isinstance(display, MarkerArray)
        self.display, self.frames = display, Frames("map")
        self.frames.insert("map", "odom", 1.0, Pose3((0.0, 1.0, 0.0)))

    def take(self, *markers: Any) -> None:
        self.display.take(SimpleNamespace(markers=markers))

    def changed(self, now: float = 0.0) -> bool:
        return self.display.tick(Moment(now, self.frames)) is not None

    def drawn(self, now: float = 0.0) -> list[Any]:
        parts = self.display.tick(Moment(now, self.frames))
        assert parts is not None
        return list(parts.values())

    def count(self, now: float = 0.0) -> int:
        return sum(len(each.positions) for each in self.drawn(now))


@pytest.mark.parametrize(
    ("kind", "fields", "drawing", "values"),
    [
        (CUBE, {}, Solids, {"shape": "box", "positions": [[2, 0, 0]], "sizes": [[0.2, 0.4, 0.6]]}),
        (2, {}, Solids, {"shape": "sphere", "colours": [[255, 0, 0]]}),
        (3, {"color": colour(0.0, 0.5)}, Solids, {"shape": "cylinder", "opacities": [0.5]}),
        (ARROW, {}, Solids, {"shape": "arrow", "positions": [[2.1, 0, 0]]}),  # of its middle
        (ARROW, {"points": [point(0, 0), point(0, 4)]}, Solids, {"positions": [[2, 2, 0]]}),
        (12, {"points": [point(*p) for p in CORNERS]}, Solids, {"shape": "arrow"}),
        (LINE_STRIP, {"points": [point(*p) for p in CORNERS]}, Segments, {"width": 0.2}),
        (5, {"points": [point(*p) for p in CORNERS]}, Segments, {"width": 0.2}),
        (CUBE_LIST, {"points": [point(0, 3)]}, Solids, {"positions": [[2, 3, 0]]}),
        (7, {"points": [point(0, 3)] * 2}, Solids, {"shape": "sphere"}),
        (POINTS, {"points": [point(0, 3)]}, Points, {"points": [[2, 3, 0]], "size": 0.4}),
        (TEXT, {"text": "here"}, Label, {"text": "here", "height": 0.6}),
        (11, {"points": [point(*p) for p in CORNERS[:3]]}, Model, {}),
    ],
)
def test_every_kind_is_drawn(
    kind: int, fields: dict[str, Any], drawing: type[Drawing], values: dict[str, Any]
) -> None:
    shown = Shown()
    shown.take(marker(kind, **fields))
    (drawn,) = shown.drawn()
    assert isinstance(drawn, drawing)
    for name, value in values.items():
        found = getattr(drawn, name)
        assert found == value if isinstance(value, str) else found == pytest.approx(np.array(value))


@pytest.mark.parametrize(("kind", "ends"), [(LINE_STRIP, 3), (5, 2)])
def test_lines_and_colours_go_from_point_to_point(kind: int, ends: int) -> None:
    shown = Shown()
    colours = [colour(each) for each in (0.0, 0.2, 0.4, 0.6)]
    shown.take(marker(kind, points=[point(*p) for p in CORNERS], colors=colours))
    (drawn,) = shown.drawn()
    assert isinstance(drawn, Segments)
    assert drawn.segments.shape == (ends, 2, 3)
    assert drawn.segments[0].tolist() == [[2, 0, 0], [3, 0, 0]]
    assert drawn.colours[0, :, 0].tolist() == [0, 51]


@pytest.mark.parametrize(
    ("markers", "left"),
    [
        ([marker(id=1), marker(id=2)], 2),
        ([marker(id=1), marker(id=1)], 1),  # the newer one replaces it
        ([marker(id=1), marker(id=1, ns="other")], 2),
        ([marker(id=1), marker(id=2), marker(id=1, action=DELETE)], 1),
        ([marker(id=1), marker(id=1, ns="other"), marker(id=1, action=DELETE)], 1),
        ([marker(id=7, action=DELETE), marker(id=1)], 1),  # what is not there is not missed
        ([marker(id=1), marker(id=2), marker(action=DELETE_ALL), marker(id=3)], 1),
        ([marker(id=1), marker(ns="a"), marker(ns="a", action=DELETE_ALL)], 1),
    ],
)
def test_markers_are_added_replaced_and_deleted(markers: list[Any], left: int) -> None:
    shown = Shown()
    shown.take(*markers)
    assert shown.count() == left


def test_one_lives_as_long_as_it_says_from_when_it_was_drawn() -> None:
    shown = Shown()
    shown.take(marker(id=1, lifetime=0.5), marker(id=2))
    assert shown.count(now=10.0) == 2
    assert not shown.changed(now=10.4)  # nothing to draw again
    assert shown.count(now=10.6) == 1
    shown.take(marker(id=1, lifetime=0.5))
    assert shown.count(now=11.0) == 2


def test_hidden_namespaces_are_left_out() -> None:
    shown = Shown(namespaces="path of a;b")
    shown.take(marker(ns="path of a"), marker(ns="b"), marker(ns="c"))
    assert shown.count() == 1


def test_one_without_a_stamp_moves_with_its_frame_one_with_a_stamp_stays() -> None:
    shown = Shown()
    shown.take(marker(frame="odom", id=1), marker(frame="odom", id=2, stamp=1.0))
    shown.take(marker(frame="odom", id=3, stamp=1.0, frame_locked=True))
    moving, placed = shown.drawn()
    assert (moving.frame, len(moving.positions)) == ("odom", 2)
    assert (placed.frame, placed.pose.position) == ("", (0.0, 1.0, 0.0))


def test_one_with_a_stamp_waits_for_its_frame() -> None:
    shown = Shown()
    shown.take(marker(frame="odom", stamp=2.0))
    assert shown.count() == 0
    shown.frames.insert("map", "odom", 3.0, Pose3((0.0, 3.0, 0.0)))
    (placed,) = shown.drawn()
    assert placed.pose.position == pytest.approx((0.0, 2.0, 0.0))


def test_five_hundred_are_four_drawings() -> None:
    shown = Shown()
    shown.take(*(marker(number % 4, id=number) for number in range(500)))
    assert len(shown.drawn()) == 4
    assert not shown.changed()


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"kind": 99}, "marker n/5 is of type 99; valid: 0 to 12"),
        ({"pose": pose(np.nan)}, "marker n/5 is not finite"),
        ({"kind": POINTS, "points": [point(np.inf, 0.0)]}, "a point of marker n/5 is not finite"),
    ],
)
def test_one_that_makes_no_sense_is_named(fields: dict[str, Any], problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        Shown().take(marker(ns="n", id=5, **fields))


def test_interactive_markers_are_drawn_moved_and_erased() -> None:
    display = DisplaySpec("InteractiveMarkers", "", "tool/update").make()
    assert isinstance(display, InteractiveMarkers)
    assert [each.topic for each in display.wanted()] == [
        "tool/update",
        "tool/get_interactive_markers",
    ]
    control = make("visualization_msgs/msg/InteractiveMarkerControl", markers=[marker()])
    one = make(
        "visualization_msgs/msg/InteractiveMarker",
        header=header("map"), pose=pose(1.0), name="one", description="grip",
        controls=[control], scale=0.4,
    )  # fmt: skip
    update = "visualization_msgs/msg/InteractiveMarkerUpdate"
    moved = make("visualization_msgs/msg/InteractiveMarkerPose", name="one", pose=pose(5.0))
    boxes = []
    for message in (
        SimpleNamespace(markers=[one]),  # of the service
        make(update, poses=[moved]),
        make(update, erases=["one"]),
    ):
        display.take(message)
        drawn = list((display.tick(Moment(0.0, Frames("map"))) or {}).values())
        boxes += [float(each.positions[0, 0]) for each in drawn if isinstance(each, Solids)]
        kinds = {type(each) for each in drawn}
        assert kinds == ({Solids, Axes, Label} if drawn else set())
    assert boxes == [3.0, 7.0]
