"""The pointer on the ground while a tool is in hand, and the pose that it draws."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import viser
from PIL import Image

from arjuna_core.se2 import SE2
from bringup.viewing.drawing.textures import rectangle_glb

Point3 = tuple[float, float, float]
Point2 = tuple[float, float]


class Pointer:
    """Takes hold of the ground while a tool is in hand; else a drag turns the view.

    Args:
        pointed: Takes start and end of a click or drag [m]; must not block.
        half: Ground to each side [m].
        below: Height at which it hides nothing [m].
    """

    def __init__(
        self,
        server: viser.ViserServer,
        pointed: Callable[[Point2, Point2], None],
        half: float = 500.0,
        below: float = -0.02,
    ) -> None:
        self._pointed = pointed
        picture = Image.new("RGB", (1, 1), (225, 228, 230))
        glb = rectangle_glb(picture, 2.0 * half, 2.0 * half)
        self._ground = server.scene.add_glb("/ground", glb, position=(-half, -half, below))
        self._held = False

    def hold(self, wanted: bool) -> None:
        """Take hold of the ground, or release it."""
        if wanted and not self._held:
            self._ground.on_drag("left")(self.on_drag)
            self._ground.on_click(self.on_click)
        elif self._held and not wanted:
            self._ground.remove_drag_callback()
            self._ground.remove_click_callback()
        self._held = wanted

    async def on_drag(self, event: Any) -> None:
        """Report where a drag began and ended; viser's end lies in the view's plane."""
        if event.phase != "end":
            return
        x, y, z = (float(value) for value in event.client.camera.position)
        end = on_ground((x, y, z), event.end_position)
        if end is not None:
            self._pointed((event.start_position[0], event.start_position[1]), end)

    async def on_click(self, event: Any) -> None:
        """Report where a click was."""
        eye, ray = event.ray_origin, event.ray_direction
        point = on_ground(eye, (eye[0] + ray[0], eye[1] + ray[1], eye[2] + ray[2]))
        if point is not None:
            self._pointed(point, point)


def on_ground(eye: Point3, through: Point3) -> Point2 | None:
    """Return where a line of sight meets the ground, z = 0 [m]; None where it goes up or level."""
    down = eye[2] - through[2]
    if eye[2] <= 0.0 or down <= 1e-9:
        return None
    share = eye[2] / down
    return eye[0] + share * (through[0] - eye[0]), eye[1] + share * (through[1] - eye[1])


def dragged_pose(start: Point2, end: Point2, robot: SE2 | None, shortest: float = 0.1) -> SE2:
    """Return the pose that a drag draws: at its start, heading for its end.

    Args:
        robot: The robot, from which a mere click heads away; None where it is not known.
        shortest: A shorter drag is a click, as in RViz [m].
    """
    dx, dy = end[0] - start[0], end[1] - start[1]
    if math.hypot(dx, dy) < shortest:
        dx, dy = (1.0, 0.0) if robot is None else (start[0] - robot.x, start[1] - robot.y)
    return SE2(*start, math.atan2(dy, dx))
