"""The picture: drawings and the robot as viser's scene nodes, each in its frame."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import viser

from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from bringup.viewing.drawing import textures
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.drawing.values import (
    LAYERS,
    Arrows,
    Bodies,
    Body,
    Drawing,
    Grid,
    Line,
    Points,
)


class Scene:
    """Draws layers; a drawing replaces the one before under the same key.

    Args:
        decoding: Ticks that a browser takes for a map's picture.
        most_arrows: The most of a drawing; more are lines, which cost less.
    """

    def __init__(
        self, server: viser.ViserServer, decoding: int = 5, most_arrows: int = 100
    ) -> None:
        self._server, self._decoding, self._most_arrows = server, decoding, most_arrows
        self._scene = server.scene
        self._drawn: dict[str, tuple[Drawing, list[Any]]] = {}
        self._unplaced: set[str] = set()
        self._old: list[tuple[int, list[Any]]] = []
        self._maps = 0
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
        if isinstance(drawing, Grid) and drawing.opacity is None:
            # a browser takes a moment to decode it: the old one stays meanwhile
            self._maps += 1
            name += str(self._maps)
            self._old.append((self._decoding, handles))
        elif _renewed(before, handles, drawing):
            self._drawn[key] = (drawing, handles)
        elif isinstance(drawing, Bodies):
            _remove(handles)
        if key not in self._drawn:
            self._drawn[key] = (drawing, self._add(name, drawing))
        self._unplaced.add(key)

    def _add(self, name: str, drawing: Drawing) -> list[Any]:
        if isinstance(drawing, Bodies):
            return [self._add_body(f"{name}/{path_part(b.name)}", b) for b in drawing.bodies]
        return [self._add_one(name, drawing)]

    def _add_one(self, name: str, drawing: Drawing) -> Any:
        scene = self._scene
        if isinstance(drawing, Grid):
            flat: dict[str, Any] = {"visible": False, "cast_shadow": False, "receive_shadow": False}
            if drawing.opacity is None:
                return scene.add_glb(name, textures.map_glb(drawing.grid, *drawing.size), **flat)
            pixels = textures.cost_pixels(drawing.grid, drawing.opacity)
            return scene.add_image(name, pixels, *drawing.size, format="png", **flat)
        if isinstance(drawing, Points):
            return scene.add_point_cloud(
                *(name, drawing.points, drawing.colour),
                point_size=drawing.size, point_shape="circle", precision="float32", visible=False,
            )  # fmt: skip
        if isinstance(drawing, Arrows) and len(drawing.segments) <= self._most_arrows:
            width = drawing.width
            return scene.add_arrows(
                *(name, drawing.segments, drawing.colour), visible=False,
                shaft_radius=width / 2, head_radius=width * 1.6, head_length=width * 4,
            )  # fmt: skip
        assert isinstance(drawing, Line | Arrows)
        return scene.add_line_segments(
            *(name, drawing.segments, drawing.colour), visible=False, thickness_units="screen",
            thickness=drawing.width if isinstance(drawing, Line) else 1.5,
        )  # fmt: skip

    def _add_body(self, name: str, body: Body) -> Any:
        dx, dy, dz = body.size
        if body.person:
            return self._scene.add_cylinder(
                name, max(dx, dy) / 2, dz, body.colour, visible=False, cast_shadow=False
            )
        return self._scene.add_box(
            name, body.colour, body.size, opacity=0.8, visible=False, cast_shadow=False
        )

    def update(self, frames: Frames) -> None:
        """Move every drawing to its frame; one with a stamp stays where it was put."""
        for key, (drawing, handles) in self._drawn.items():
            if key not in self._unplaced and drawing.stamp is not None:
                continue
            pose = frames.pose(drawing.frame, drawing.stamp)
            if pose is None:
                continue
            self._unplaced.discard(key)
            for handle, inside in zip(handles, _poses_inside(drawing), strict=True):
                put(handle, pose @ drawing.pose @ inside)
                handle.visible = True

    def drop_old(self) -> None:
        """Remove maps that newer ones have replaced some ticks ago; called once a tick."""
        for _, handles in (item for item in self._old if item[0] == 0):
            _remove(handles)
        self._old = [(ticks - 1, handles) for ticks, handles in self._old if ticks > 0]

    def look_at(self, corner: SE2, size: tuple[float, float]) -> None:
        """Turn the view, once, to a map: its lower-left corner, its width and height [m]."""
        if self._looked:
            return
        self._looked = True
        x, y = corner.apply(np.array([size]) / 2.0)[0]
        middle = np.array([x, y, 0.0])
        eye = middle + max(*size, 3.0) * np.array((0.0, -0.5, 0.75))
        cameras: list[Any] = [self._server.initial_camera]
        cameras += [client.camera for client in self._server.get_clients().values()]
        for camera in cameras:
            camera.position, camera.look_at = eye, middle


def _poses_inside(drawing: Drawing) -> list[Pose3]:
    """Return the pose of each node of a drawing; an image's origin is its middle."""
    if isinstance(drawing, Bodies):
        return [body.pose for body in drawing.bodies]
    if isinstance(drawing, Grid) and drawing.opacity is not None:
        width, height = drawing.size
        return [Pose3((width / 2.0, height / 2.0, 0.0))]
    return [Pose3()]


def _remove(handles: list[Any]) -> None:
    for handle in handles:
        handle.remove()


def _renewed(before: Drawing | None, handles: list[Any], drawing: Drawing) -> bool:
    """Change what is drawn already, where that is enough; return whether it was."""
    if isinstance(before, Grid) and isinstance(drawing, Grid) and before.size == drawing.size:
        assert drawing.opacity is not None
        handles[0].image = textures.cost_pixels(drawing.grid, drawing.opacity)
        return True
    if isinstance(before, Bodies) and isinstance(drawing, Bodies):
        kinds = [[(b.name, b.size, b.colour) for b in each.bodies] for each in (before, drawing)]
        return kinds[0] == kinds[1]
    return False


class RobotScene:
    """The tree of frames, with the robot's links in it."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene = server.scene
        self._glbs: dict[str, bytes] = {}
        self._parents: dict[str, str] = {}
        self._frames: dict[str, Any] = {}
        self._links: dict[str, Any] = {}
        self._axes = LAYERS["axes"].shown
        self._shown = LAYERS["robot"].shown

    def set_links(self, glbs: Mapping[str, bytes]) -> None:
        """Set the robot's links, each as binary glTF."""
        self._glbs = dict(glbs)
        self._parents = {}  # so that the next `update` builds the tree again

    def show(self, layer: str, shown: bool) -> None:
        """Show or hide the robot or the frames' axes."""
        if layer == "robot":
            self._shown = shown
            for link in self._links.values():
                link.visible = shown
        elif layer == "axes":
            self._axes = shown
            for frame in self._frames.values():
                frame.show_axes = shown

    def update(self, frames: Frames) -> None:
        """Move every frame to its pose in its parent."""
        parents = frames.parents
        if parents != self._parents:
            self._build(frames, parents)
        for name, handle in self._frames.items():
            if name in parents:
                put(handle, frames.local(name))
            elif frames.fixed is not None and (pose := frames.pose(name)) is not None:
                put(handle, pose)

    def _build(self, frames: Frames, parents: dict[str, str]) -> None:
        if "/tf" in self._frames:
            self._frames["/tf"].remove()
        self._parents, self._links, self._frames = dict(parents), {}, {}
        root = self._scene.add_frame("/tf", show_axes=False)
        for name in dict.fromkeys((*parents.values(), *parents)):
            path = "/".join(["/tf", *(path_part(part) for part in reversed(frames.chain(name)))])
            self._frames[name] = self._scene.add_frame(
                path, show_axes=self._axes, axes_length=0.25, axes_radius=0.008
            )
            if name in self._glbs:
                self._links[name] = self._scene.add_glb(
                    f"{path}/visual", self._glbs[name], visible=self._shown
                )
        self._frames["/tf"] = root


def path_part(name: str) -> str:
    """Return a name as one step of a scene node's path."""
    return name.replace("/", "|") or "|"


def put(handle: Any, pose: Pose3) -> None:
    """Move a scene node, if it is elsewhere."""
    if not np.allclose(handle.position, pose.position, rtol=0.0, atol=1e-4):
        handle.position = pose.position
    if not np.allclose(handle.wxyz, pose.quaternion, rtol=0.0, atol=1e-4):
        handle.wxyz = pose.quaternion
