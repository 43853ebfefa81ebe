"""Markers of every kind, with frames, lifetimes and namespaces, and interactive ones."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np

from arjuna_core.param import param
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_core.readings import seconds
from bringup.viewing.displays.base import Display, Moment, Wanted, colour_of
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.drawing.messages import frame_of, pose3
from bringup.viewing.drawing.solids import arrow_pose, solids
from bringup.viewing.drawing.values import Axes, Drawing, Label, Model, Parts, Points, Segments

# visualization_msgs/Marker's types and actions
_ARROW, _CUBE, _SPHERE, _CYLINDER, _LINE_STRIP, _LINE_LIST = range(6)
_CUBE_LIST, _SPHERE_LIST, _POINTS, _TEXT, _MESH, _TRIANGLES, _ARROW_STRIP = range(6, 13)
_ADD, _DELETE, _DELETE_ALL = 0, 2, 3
_SHAPES = {_CUBE: "box", _SPHERE: "sphere", _CYLINDER: "cylinder"}
_LISTS = {_CUBE_LIST: "box", _SPHERE_LIST: "sphere"}


@dataclass
class _Kept:
    """A marker, as what it adds to drawings of many.

    Attributes:
        stamp: When its frame was where it is drawn [s]; None where it moves with the frame.
        placed: Pose of its frame at the stamp in the fixed one, once that is known.
        expires: End of its lifetime [s, monotonic]; None before it was drawn.
        items: Each with its kind: "solid", a shape and a row of `solids`; "points", a size [m],
            positions and colours; "line", a width [m], ends and colours; "single", a drawing.
    """

    frame: str
    stamp: float | None
    lifetime: float
    expires: float | None = None
    placed: Pose3 | None = None
    items: list[tuple[str, Any, Any]] = field(default_factory=list)


class MarkerArray(Display):
    """Arrays of markers."""

    types = ("visualization_msgs/msg/MarkerArray",)
    topic, every = "visualization_marker_array", True

    @dataclass(frozen=True)
    class Config:
        namespaces: str = param("", "Namespaces to hide, with semicolons between them.")

    def __init__(self, config: Any, topic: str) -> None:
        super().__init__(config, topic)
        self._kept: dict[tuple[str, int], _Kept] = {}
        self._changed = False

    def take(self, message: Any) -> None:
        hidden = self.config.namespaces.split(";") if self.config.namespaces else ()
        for marker in getattr(message, "markers", (message,)):
            key = marker.ns, marker.id
            if marker.action == _DELETE_ALL:
                self._kept = {
                    k: v for k, v in self._kept.items() if marker.ns and k[0] != marker.ns
                }
            elif marker.action == _DELETE:
                self._kept.pop(key, None)
            elif marker.ns not in hidden:
                self._kept[key] = _read(marker)
            self._changed = True

    def tick(self, moment: Moment) -> Parts | None:
        for key, each in list(self._kept.items()):
            if each.expires is None:
                each.expires = moment.now + each.lifetime if each.lifetime else math.inf
            if each.expires <= moment.now:
                del self._kept[key]
                self._changed = True
            elif each.stamp is not None and each.placed is None:
                each.placed = _at_stamp(moment.frames, each.frame, each.stamp)
                self._changed |= each.placed is not None
        if not self._changed:
            return None
        self._changed = False
        return _drawn(each for each in self._kept.values() if each.stamp is None or each.placed)


class Marker(MarkerArray):
    """A topic of markers one by one."""

    types = ("visualization_msgs/msg/Marker",)
    topic = "visualization_marker"


def _at_stamp(frames: Frames, frame: str, stamp: float) -> Pose3 | None:
    """Return a frame's pose at a time, or now where that has passed from memory."""
    found = frames.pose(frame, stamp)
    if found is None and stamp < frames.newest - 5.0:
        found = frames.pose(frame)
    return found


def _read(marker: Any, T_frame_parent: Pose3 = ORIGIN) -> _Kept:
    """Return a marker; its pose is one in a parent's.

    Raises:
        ValueError: A position or size of it is not finite, or its type is none.
    """
    stamp = seconds(marker.header.stamp)
    lifetime = seconds(marker.lifetime)
    moves = marker.frame_locked or stamp == 0.0
    kept = _Kept(frame_of(marker), None if moves else stamp, lifetime)
    pose, scale = pose3(marker.pose), (marker.scale.x, marker.scale.y, marker.scale.z)
    if not any(pose.quaternion):  # what a message leaves out is no turn
        pose = Pose3(pose.position)
    if not all(map(math.isfinite, (*pose.position, *pose.quaternion, *scale))):
        raise ValueError(f"marker {marker.ns}/{marker.id} is not finite")
    if T_frame_parent is not ORIGIN:
        pose = T_frame_parent @ pose
    colour, alpha, kind = colour_of(marker.color), marker.color.a, marker.type
    if kind in _SHAPES:
        kept.items = [("solid", _SHAPES[kind], (*_pose(pose), scale, colour, alpha))]
    elif kind in (_ARROW, _ARROW_STRIP):
        rows = _arrows(marker, pose, scale, colour, alpha)
        kept.items = [("solid", "arrow", row) for row in rows]
    elif kind == _TEXT:
        kept.items = [("single", "", Label(pose=pose, text=marker.text, height=scale[2]))]
    elif kind == _MESH:
        model = Model(pose=pose, glb=_mesh(marker.mesh_resource), scale=scale)
        kept.items = [("single", "", model)]
    elif kind in (*_LISTS, _POINTS, _LINE_STRIP, _LINE_LIST, _TRIANGLES):
        _read_points(kept, marker, pose, scale)
    else:
        raise ValueError(f"marker {marker.ns}/{marker.id} is of type {kind}; valid: 0 to 12")
    return kept


def _pose(pose: Pose3) -> tuple[Any, Any]:
    return pose.position, pose.quaternion


def _arrows(marker: Any, pose: Pose3, scale: Any, colour: Any, alpha: float) -> Iterable[Any]:
    if not marker.points:
        middle = pose @ Pose3((scale[0] / 2.0, 0.0, 0.0))
        yield (*_pose(middle), scale, colour, alpha)
        return
    width = max(scale[1], scale[0])  # of the head; the shaft's is half of it
    for tail, tip in pairwise(pose.apply(_xyz(marker.points))):
        if (found := arrow_pose(tail, tip)) is not None:
            yield (*found[:2], (found[2], width, width), colour, alpha)


def _read_points(kept: _Kept, marker: Any, pose: Pose3, scale: Any) -> None:
    points, kind = _xyz(marker.points), marker.type
    if not np.isfinite(points).all():
        raise ValueError(f"a point of marker {marker.ns}/{marker.id} is not finite")
    points = pose.apply(points)
    alpha = marker.color.a
    if len(marker.colors) == len(points) and len(points):
        colours = np.array([colour_of(each) for each in marker.colors], np.uint8)
    else:
        colours = np.tile(np.array(colour_of(marker.color), np.uint8), (len(points), 1))
    if kind in _LISTS:
        kept.items = [
            ("solid", _LISTS[kind], (point, pose.quaternion, scale, colour, alpha))
            for point, colour in zip(points, colours, strict=True)
        ]
    elif kind == _POINTS:
        kept.items = [("points", max(scale[0], scale[1]), (points, colours))]
    elif kind == _TRIANGLES:
        kept.items = [("single", "", Model(glb=_triangles(points, colours, alpha)))]
    else:
        step = 1 if kind == _LINE_STRIP else 2
        starts = np.arange(0, len(points) - 1, step)
        ends = np.stack([starts, starts + 1], axis=1)
        kept.items = [("line", scale[0], (points[ends], colours[ends]))]


def _xyz(points: Any) -> Any:
    return np.array([(p.x, p.y, p.z) for p in points], dtype=np.float64).reshape(-1, 3)


@cache
def _mesh(uri: str) -> bytes:
    from bringup.viewing.drawing.visual_model import mesh_glb

    return mesh_glb(uri)


def _triangles(points: Any, colours: Any, alpha: float) -> bytes:
    import trimesh

    count = len(points) // 3 * 3
    faces = np.arange(count).reshape(-1, 3)
    faces = np.concatenate([faces, faces[:, ::-1]])  # seen from both sides
    rgba = np.column_stack([colours, np.full(len(colours), round(255 * alpha), np.uint8)])
    mesh = trimesh.Trimesh(points, faces, vertex_colors=rgba, process=False)
    return bytes(trimesh.Scene([mesh]).export(file_type="glb"))


def _drawn(kept: Iterable[_Kept]) -> dict[str, Drawing]:
    """Return drawings of many markers each: of one frame or pose, and one shape or width."""
    groups: dict[Any, dict[Any, list[Any]]] = defaultdict(lambda: defaultdict(list))
    for each in kept:
        group = groups[each.frame if each.placed is None else each.placed]
        for name, detail, item in each.items:
            group[name, detail].append(item)
    parts: dict[str, Drawing] = {}
    for number, (where, group) in enumerate(groups.items()):
        # a drawing's own pose lies within the frame's at the time of its stamp
        at: Any = {"pose": where} if isinstance(where, Pose3) else {"frame": where}
        for (name, detail), items in group.items():
            key = f"{name} {detail} {number}"
            if name == "solid":
                parts[key] = solids(detail, items, **at)
            elif name == "single":
                for index, item in enumerate(items):
                    moved = {**at, "pose": at.get("pose", ORIGIN) @ item.pose}
                    parts[f"{key} {index}"] = replace(item, **moved)
            else:
                positions, colours = (np.concatenate(column) for column in zip(*items, strict=True))
                positions = positions.astype(np.float32)
                if name == "points":
                    parts[key] = Points(points=positions, colour=colours, size=detail, **at)
                else:
                    parts[key] = Segments(segments=positions, colours=colours, width=detail, **at)
    return parts


class InteractiveMarkers(MarkerArray):
    """Interactive markers as they stand; they are not moved from here."""

    types = ("visualization_msgs/msg/InteractiveMarkerUpdate",)
    topic, property = "basic_controls", "Interactive Markers Namespace"

    def __init__(self, config: Any, topic: str) -> None:
        super().__init__(config, topic)
        self._markers: dict[str, Any] = {}

    def wanted(self) -> tuple[Wanted, ...]:
        base = self.name.removesuffix("/update")
        service = "visualization_msgs/srv/GetInteractiveMarkers"
        return (
            Wanted(f"{base}/update", self.types, every=True),
            Wanted(f"{base}/get_interactive_markers", (service,)),
        )

    def take(self, message: Any) -> None:
        for each in message.markers:
            self._markers[each.name] = each
        for each in getattr(message, "poses", ()):
            if each.name in self._markers:
                self._markers[each.name].pose = each.pose
        for name in getattr(message, "erases", ()):
            self._markers.pop(name, None)
        self._kept = dict(self._pieces())
        self._changed = True

    def _pieces(self) -> Iterable[tuple[tuple[str, int], _Kept]]:
        for each in self._markers.values():
            pose, size = pose3(each.pose), each.scale or 1.0
            pose = pose if any(pose.quaternion) else Pose3(pose.position)
            handle = Axes(
                pose=pose, length=size / 2.0,
                positions=np.zeros((1, 3), np.float32), wxyzs=np.array([[1, 0, 0, 0]], np.float32),
            )  # fmt: skip
            words = Label(pose=pose @ Pose3((0.0, 0.0, size / 2.0)), text=each.description)
            for number, drawing in enumerate((handle, words)):
                kept = _Kept(frame_of(each), None, 0.0, items=[("single", "", drawing)])
                yield (each.name, -1 - number), kept
            markers = [marker for control in each.controls for marker in control.markers]
            for number, marker in enumerate(markers):
                kept = _read(marker, pose)
                kept.frame, kept.stamp = frame_of(each), None
                yield (each.name, number), kept
