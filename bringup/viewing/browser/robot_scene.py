"""The tree of frames in the picture, and the robot that it carries."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import viser

from arjuna_core.pose3 import Pose3
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.drawing.values import LAYERS


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
