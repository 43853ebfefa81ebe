"""The picture: drawings as viser's scene nodes, each where its frame is."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from arjuna_core.se2 import SE2
from bringup.viewing.browser.nodes import plain, put, remove
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.drawing.layers import LAYERS
from bringup.viewing.drawing.values import (
    Arrows,
    Bodies,
    Drawing,
    Lines,
    Overlay,
    Picture,
    Points,
)

_EYE = (0.0, -0.5, 0.75)  # where the camera is at first, in parts of the map's size
_SMALLEST = 3.0  # map to look at from there [m]
_TICKS_TO_DECODE = 5


class Scene:
    """Draws layers; what is drawn again replaces what was there under the same key.

    Args:
        server: viser's server.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._scene = server.scene
        self._drawn: dict[str, tuple[Drawing, list[Any]]] = {}
        self._unplaced: set[str] = set()
        self._old: list[tuple[int, list[Any]]] = []
        self._pictures = 0
        self._looked = False
        self._groups = {
            name: self._scene.add_frame(f"/layers/{name}", show_axes=False, visible=layer.shown)
            for name, layer in LAYERS.items()
        }
        self._scene.world_axes.visible = False
        server.initial_camera.position, server.initial_camera.look_at = (0, -7, 9), (0, 0, 0)

    def show(self, layer: str, shown: bool) -> None:
        """Show or hide a layer."""
        self._groups[layer].visible = shown

    def draw(self, layer: str, key: str, drawing: Drawing) -> None:
        """Draw something in a layer; it appears when its frame is known."""
        before, handles = self._drawn.pop(key, (None, []))
        name = f"/layers/{layer}/{key}"
        if isinstance(drawing, Picture):
            # a browser takes a moment to decode it: the old one stays meanwhile
            self._pictures += 1
            name += str(self._pictures)
            self._old.append((_TICKS_TO_DECODE, handles))
        elif isinstance(drawing, Bodies) and before is not None and not _same(before, drawing):
            remove(handles)
        if _renew(before, handles, drawing):
            self._drawn[key] = (drawing, handles)
        else:
            self._drawn[key] = (drawing, self._add(name, drawing))
        self._unplaced.add(key)

    def _add(self, name: str, drawing: Drawing) -> list[Any]:
        """Add a drawing's nodes, not shown yet."""
        if isinstance(drawing, Bodies):
            return [self._add_body(name, body) for body in drawing.bodies]
        return [self._add_one(name, drawing)]

    def _add_one(self, name: str, drawing: Drawing) -> Any:
        if isinstance(drawing, Picture):
            return self._scene.add_glb(
                name, drawing.glb, visible=False, cast_shadow=False, receive_shadow=False
            )
        if isinstance(drawing, Overlay):
            return self._scene.add_image(
                *(name, drawing.pixels, *drawing.size),
                format="png", visible=False, cast_shadow=False, receive_shadow=False,
            )  # fmt: skip
        if isinstance(drawing, Points):
            return self._scene.add_point_cloud(
                *(name, drawing.points, drawing.colour),
                point_size=drawing.size, point_shape="circle", precision="float32", visible=False,
            )  # fmt: skip
        if isinstance(drawing, Lines):
            return self._scene.add_line_segments(
                *(name, drawing.segments, drawing.colour),
                thickness=drawing.width, thickness_units="screen", visible=False,
            )  # fmt: skip
        assert isinstance(drawing, Arrows)
        width = drawing.width
        return self._scene.add_arrows(
            *(name, drawing.segments, drawing.colour),
            shaft_radius=width / 2, head_radius=width * 1.6, head_length=width * 4, visible=False,
        )  # fmt: skip

    def _add_body(self, name: str, body: Any) -> Any:
        node = f"{name}/{plain(body.name)}"
        dx, dy, dz = body.size
        if body.person:
            return self._scene.add_cylinder(
                node, max(dx, dy) / 2, dz, body.colour, visible=False, cast_shadow=False
            )
        return self._scene.add_box(
            node, body.colour, body.size, opacity=0.8, visible=False, cast_shadow=False
        )

    def place(self, frames: Frames) -> None:
        """Put every drawing where its frame is; one with a stamp stays where it was put."""
        for key, (drawing, handles) in self._drawn.items():
            if key not in self._unplaced and drawing.stamp is not None:
                continue
            pose = frames.pose(drawing.frame, drawing.stamp)
            if pose is None:
                continue
            self._unplaced.discard(key)
            placed = pose @ drawing.pose
            bodies = drawing.bodies if isinstance(drawing, Bodies) else None
            for index, handle in enumerate(handles):
                put(handle, placed if bodies is None else placed @ bodies[index].pose)
                handle.visible = True

    def drop_old(self) -> None:
        """Remove pictures that newer ones have replaced some ticks ago; called once a tick."""
        for _, handles in (item for item in self._old if item[0] == 0):
            remove(handles)
        self._old = [(left - 1, handles) for left, handles in self._old if left > 0]

    def look_at(self, corner: SE2, size: tuple[float, float]) -> None:
        """Turn the view, once, to a map: its lower-left corner, its width and height [m]."""
        if self._looked:
            return
        self._looked = True
        x, y = corner.apply(np.array([size]) / 2.0)[0]
        middle = np.array([x, y, 0.0])
        eye = middle + max(*size, _SMALLEST) * np.array(_EYE)
        cameras: list[Any] = [self._server.initial_camera]
        cameras += [client.camera for client in self._server.get_clients().values()]
        for camera in cameras:
            camera.position, camera.look_at = eye, middle


def _renew(before: Drawing | None, handles: list[Any], drawing: Drawing) -> bool:
    """Change what is drawn already, where that is enough."""
    if isinstance(before, Overlay) and isinstance(drawing, Overlay) and before.size == drawing.size:
        handles[0].image = drawing.pixels
        return True
    return before is not None and isinstance(drawing, Bodies) and _same(before, drawing)


def _same(before: Drawing, after: Bodies) -> bool:
    """Tell whether bodies are the same, wherever they are."""
    assert isinstance(before, Bodies)
    looks = [[(b.name, b.size, b.colour) for b in bodies.bodies] for bodies in (before, after)]
    return looks[0] == looks[1]
