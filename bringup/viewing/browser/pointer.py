"""The tool in hand: clicks and drags on the ground become wishes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import viser

from bringup.viewing.drawing.ground import on_ground
from bringup.viewing.drawing.wishes import Pointed, Tool, Wish

_HALF = 500.0  # [m] of ground to each side
_BELOW = -0.02  # so that it hides nothing


class Pointer:
    """Takes hold of the ground while a tool is in hand; else a drag turns the view.

    Args:
        server: viser's server.
        wish: Takes a wish; must not block.
    """

    def __init__(self, server: viser.ViserServer, wish: Callable[[Wish], None]) -> None:
        self._wish = wish
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32) * _HALF
        corners[:, 2] = _BELOW
        self._ground = server.scene.add_mesh_simple(
            "/ground",
            corners,
            np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
            color=(225, 228, 230),
            cast_shadow=False,
            receive_shadow=False,
        )
        self._held = False

    def take(self, tool: Tool) -> None:
        """Take up a tool, or lay it down."""
        wanted = tool is not Tool.LOOK
        if wanted and not self._held:
            self._ground.on_drag("left")(self.on_drag)
            self._ground.on_click(self.on_click)
        elif self._held and not wanted:
            self._ground.remove_drag_callback()
            self._ground.remove_click_callback()
        self._held = wanted

    async def on_drag(self, event: Any) -> None:
        """Hand over where a drag began and ended; viser's end lies in the view's plane."""
        if event.phase != "end":
            return
        eye = tuple(float(value) for value in event.client.camera.position)
        end = on_ground((eye[0], eye[1], eye[2]), event.end_position)
        if end is not None:
            self._wish(Pointed((event.start_position[0], event.start_position[1]), end))

    async def on_click(self, event: Any) -> None:
        """Hand over where a click was."""
        eye, way = event.ray_origin, event.ray_direction
        place = on_ground(eye, (eye[0] + way[0], eye[1] + way[1], eye[2] + way[2]))
        if place is not None:
            self._wish(Pointed(place, place))
