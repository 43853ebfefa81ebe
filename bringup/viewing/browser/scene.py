"""The picture: the drawings of displays as viser's scene nodes, each in its frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import viser

from arjuna_core.pose3 import ORIGIN, Pose3
from bringup.viewing.drawing import textures
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.drawing.solids import triangles
from bringup.viewing.drawing.values import (
    Arrows,
    Axes,
    Drawing,
    Grid,
    Label,
    Line,
    Model,
    Parts,
    Points,
    Segments,
    Solids,
)

_WORLD = "/world"
_FLOOR = 0.02  # above the map


class _Strokes(Arrows):
    """So many arrows that they are lines, which cost less."""


class Scene:
    """Draws displays; a drawing replaces the one before of the same display and name.

    Args:
        decoding: Ticks that a browser takes for a map's picture.
        most_arrows: The most of a drawing that are drawn as such.
    """

    def __init__(
        self, server: viser.ViserServer, decoding: int = 20, most_arrows: int = 100
    ) -> None:
        self._server, self._decoding, self._most_arrows = server, decoding, most_arrows
        self._scene = server.scene
        self._world = self._scene.add_frame(_WORLD, show_axes=False)
        self._groups: dict[str, Any] = {}
        self._drawn: dict[tuple[str, str], tuple[Drawing, Any]] = {}
        self._unplaced: set[tuple[str, str]] = set()
        self._old: list[tuple[int, Any]] = []
        self._maps = 0
        self._looked = False
        self._turning: set[int] = set()
        self._middle, self._extent = np.zeros(3), 8.0
        self._scene.world_axes.visible = False
        # plain light: shadows and reflections are most of a frame's cost without a GPU
        self._scene.configure_default_lights(cast_shadow=False)
        self._scene.configure_environment_map(None)
        self._scene.add_light_ambient("/light", intensity=1.0)
        server.initial_camera.position, server.initial_camera.look_at = (0, -7, 9), (0, 0, 0)

    def add(self, display: str, shown: bool) -> None:
        """Add a display."""
        self._groups[display] = self._scene.add_frame(
            f"{_WORLD}/{display}", show_axes=False, visible=shown
        )

    def remove(self, display: str) -> None:
        """Remove a display with all that it drew."""
        self.draw(display, {})
        self._groups.pop(display).remove()

    def show(self, display: str, shown: bool) -> None:
        """Show or hide a display."""
        self._groups[display].visible = shown

    def draw(self, display: str, parts: Parts) -> None:
        """Draw something in place of a display's last; it appears when its frame is known."""
        parts = {
            name: part
            for name, part in parts.items()
            if not isinstance(part, Solids | Axes) or len(part.positions)
        }
        for key in [key for key in self._drawn if key[0] == display and key[1] not in parts]:
            self._drawn.pop(key)[1].remove()
            self._unplaced.discard(key)
        for name, drawing in parts.items():
            self._draw_one((display, name), drawing)

    def _draw_one(self, key: tuple[str, str], drawing: Drawing) -> None:
        if isinstance(drawing, Arrows) and len(drawing.segments) > self._most_arrows:
            drawing = _Strokes(**vars(drawing))
        drawing = _padded(drawing)
        before, handle = self._drawn.get(key, (None, None))
        if type(before) is type(drawing) and _renewed(before, handle, drawing):
            self._drawn[key] = (drawing, handle)
        else:
            display, name = key
            path = f"{_WORLD}/{display}/{path_part(name)}"
            if isinstance(drawing, Grid) and drawing.opacity is None:
                # a browser takes a moment to decode it: the old one stays meanwhile
                self._maps += 1
                path += str(self._maps)
                self._old += [] if handle is None else [(self._decoding, handle)]
            elif handle is not None and type(before) is not type(drawing):
                handle.remove()
            self._drawn[key] = (drawing, _MAKERS[type(drawing)](self._scene, path, drawing))
        self._unplaced.add(key)

    def update(self, frames: Frames) -> None:
        """Put every drawing where its frame is."""
        for key, (drawing, handle) in self._drawn.items():
            if drawing.stamp is not None and key not in self._unplaced:
                continue
            pose = frames.pose(drawing.frame, drawing.stamp) if drawing.frame else ORIGIN
            if pose is None:
                continue
            pose = pose @ drawing.pose @ _inside(drawing)
            if isinstance(drawing, Points) and drawing.floor:
                pose = Pose3((*pose.position[:2], _FLOOR), pose.quaternion)
            put(handle, pose)
            if key in self._unplaced:
                self._unplaced.discard(key)
                if not handle.visible:
                    handle.visible = True

    def drop_old(self) -> None:
        """Remove maps that newer ones have replaced some ticks ago; called once a tick."""
        for handle in (handle for ticks, handle in self._old if ticks == 0):
            handle.remove()
        self._old = [(ticks - 1, handle) for ticks, handle in self._old if ticks > 0]

    @property
    def offset(self) -> tuple[float, float]:
        """The point of the ground that is drawn at the origin [m]."""
        x, y, _ = self._world.position
        return -float(x), -float(y)

    def centre(self, point: tuple[float, float]) -> None:
        """Draw a point of the ground [m] at the origin, so that the view follows it."""
        put(self._world, Pose3((-point[0], -point[1], 0.0)))

    def frame_map(self, drawing: Grid) -> None:
        """Turn the view, once, to a map."""
        width, height = drawing.size
        x, y = drawing.pose.planar().apply(np.array([[width, height]]) / 2.0)[0]
        self._middle, self._extent = np.array([x, y, 0.0]), max(width, height, 3.0)
        if not self._looked:
            self.look(np.array((0.0, -0.5, 0.75)))

    def look(self, direction: Any, whole: bool = True) -> None:
        """Look from a direction, at the whole map or at the origin from near by."""
        middle = self._middle - (*self.offset, 0.0) if whole else np.zeros(3)
        self.place(middle + (self._extent if whole else 5.0) * direction, middle)

    def place(self, eye: Any, middle: Any) -> None:
        """Look from a point at another [m], of what is drawn about the origin."""
        self._looked = True
        self._server.initial_camera.position, self._server.initial_camera.look_at = eye, middle
        for client in self._server.get_clients().values():
            self.greet(client)

    def greet(self, client: Any) -> None:
        """Turn a browser to the last view that all were turned to."""
        self._turning.add(client.client_id)
        initial = self._server.initial_camera
        client.camera.position, client.camera.look_at = initial.position, initial.look_at

    def confirm(self, client: Any) -> None:
        """Turn a browser again that says it looks elsewhere: amid its start it may miss it."""
        if client.client_id in self._turning:
            if np.allclose(client.camera.look_at, self._server.initial_camera.look_at, atol=0.01):
                self._turning.discard(client.client_id)
            else:
                self.greet(client)


def _inside(drawing: Drawing) -> Pose3:
    """Return the pose of a drawing's node in it; an image's origin is its middle."""
    if isinstance(drawing, Grid) and drawing.opacity is not None:
        width, height = drawing.size
        return Pose3((width / 2.0, height / 2.0, 0.0))
    return ORIGIN


def _grid(scene: Any, name: str, drawing: Grid) -> Any:
    if drawing.opacity is None:
        glb = textures.map_glb(drawing.grid, *drawing.size)
        return scene.add_glb(name, glb, visible=False)
    pixels = textures.cost_pixels(drawing.grid, drawing.opacity)
    return scene.add_image(name, pixels, *drawing.size, format="png", visible=False)


def _points(scene: Any, name: str, drawing: Points) -> Any:
    return scene.add_point_cloud(
        *(name, drawing.points, drawing.colour),
        point_size=drawing.size, point_shape="square" if len(drawing.points) > 5000 else "circle",
        precision="float32", point_shading="flat", visible=False,
    )  # fmt: skip


def _lines(scene: Any, name: str, drawing: Line | Arrows | Segments) -> Any:
    colours = drawing.colours if isinstance(drawing, Segments) else drawing.colour
    thickness = drawing.width if isinstance(drawing, Line | Segments) else 1.5
    units = "world" if isinstance(drawing, Segments) else "screen"
    return scene.add_line_segments(
        *(name, drawing.segments, colours),
        visible=False, thickness=thickness, thickness_units=units,
    )  # fmt: skip


def _arrows(scene: Any, name: str, drawing: Arrows) -> Any:
    width = drawing.width
    return scene.add_arrows(
        *(name, drawing.segments, drawing.colour), visible=False,
        shaft_radius=width / 2, head_radius=width * 1.6, head_length=width * 4,
    )  # fmt: skip


def _solids(scene: Any, name: str, drawing: Solids) -> Any:
    return scene.add_batched_meshes_simple(
        name, *triangles(drawing.shape), drawing.wxyzs, drawing.positions,
        batched_scales=drawing.sizes, batched_colors=drawing.colours,
        batched_opacities=_prop(drawing, "opacities"), lod="off", visible=False, material="toon3",
    )  # fmt: skip


def _axes(scene: Any, name: str, drawing: Axes) -> Any:
    length = drawing.length
    return scene.add_batched_axes(
        *(name, drawing.wxyzs, drawing.positions),
        axes_length=length, axes_radius=length / 30.0, visible=False,
    )  # fmt: skip


def _label(scene: Any, name: str, drawing: Label) -> Any:
    size: dict[str, Any] = {"font_size_mode": "screen", "font_screen_scale": 0.8}
    if drawing.height is not None:
        size = {"font_size_mode": "scene", "font_scene_height": drawing.height}
    return scene.add_label(name, drawing.text, visible=False, **size)


def _model(scene: Any, name: str, drawing: Model) -> Any:
    return scene.add_glb(name, drawing.glb, scale=drawing.scale, visible=False)


_MAKERS: dict[type[Drawing], Callable[[Any, str, Any], Any]] = {
    Grid: _grid,
    Points: _points,
    Line: _lines,
    Segments: _lines,
    Arrows: _arrows,
    _Strokes: _lines,
    Solids: _solids,
    Axes: _axes,
    Label: _label,
    Model: _model,
}
"""Makes the scene node of each kind of drawing, hidden until it has a place."""
_FIELDS = {
    Points: {"points": "points", "colour": "colors"},
    Line: {"segments": "points"},
    Arrows: {"segments": "points"},
    _Strokes: {"segments": "points"},
    Segments: {"segments": "points", "colours": "colors"},
    Axes: {"wxyzs": "batched_wxyzs", "positions": "batched_positions"},
    Solids: {
        "wxyzs": "batched_wxyzs",
        "positions": "batched_positions",
        "sizes": "batched_scales",
        "colours": "batched_colors",
        "opacities": "batched_opacities",
    },
    Label: {"text": "text"},
}
"""The fields of a drawing that a node's properties follow."""


def _padded(drawing: Drawing) -> Drawing:
    """Return instances padded to a power of two, so that few of their numbers are new.

    A browser compiles the shaders of a node with another number of instances again.
    """
    if not isinstance(drawing, Arrows | Axes | Solids):
        return drawing
    names = tuple(_FIELDS[type(drawing)])
    count = len(getattr(drawing, names[0]))
    rows = np.minimum(np.arange(1 << max(count - 1, 0).bit_length()), max(count - 1, 0))
    fields: dict[str, Any] = {name: getattr(drawing, name)[rows] for name in names if count}
    if "sizes" in fields:
        fields["sizes"] = np.where(np.arange(len(rows))[:, None] < count, fields["sizes"], 0.0)
    return replace(drawing, **fields)


def _renewed(before: Drawing, handle: Any, drawing: Drawing) -> bool:
    """Change what is drawn already, where that is enough; return whether it was."""
    if isinstance(before, Grid) and isinstance(drawing, Grid):
        same = (before.grid.frame, before.opacity) == (drawing.grid.frame, drawing.opacity)
        if same and np.array_equal(before.grid.data, drawing.grid.data):
            return True
        if before.size != drawing.size or None in (before.opacity, drawing.opacity):
            return False
        assert drawing.opacity is not None
        handle.image = textures.cost_pixels(drawing.grid, drawing.opacity)
        return True
    if isinstance(before, Model) and isinstance(drawing, Model):
        return before.glb == drawing.glb and before.scale == drawing.scale
    fields = _FIELDS.get(type(drawing))
    if fields is None:
        return False
    for name in ("size", "width", "height", "length", "shape", "floor"):
        if getattr(before, name, None) != getattr(drawing, name, None):
            return False
    old, new = ([np.shape(getattr(each, f)) for f in fields] for each in (before, drawing))
    if old != new:
        empty = not old[0] or not old[0][0] * new[0][0]
        if isinstance(drawing, Solids | Axes) or empty or [*map(len, old)] != [*map(len, new)]:
            return False
    for mine, theirs in fields.items():
        setattr(handle, theirs, _prop(drawing, mine))
    return True


def _prop(drawing: Drawing, field: str) -> Any:
    """Return a node's property; opaque bodies have no opacities, which would sort every frame."""
    value = getattr(drawing, field)
    if field == "opacities" and (value >= 1.0).all():
        return None
    return value if isinstance(value, str) else np.asarray(value)


def path_part(name: str) -> str:
    """Return a name as one step of a scene node's path."""
    return name.replace("/", "|") or "|"


def put(handle: Any, pose: Pose3) -> None:
    """Move a scene node, if it is elsewhere."""
    if max(abs(handle.position - pose.position)) > 1e-4:
        handle.position = pose.position
    if max(abs(handle.wxyz - pose.quaternion)) > 1e-4:
        handle.wxyz = pose.quaternion
