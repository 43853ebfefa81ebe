"""The panel beside the picture: tools, driving, layers, navigation and nodes."""

from __future__ import annotations

from collections.abc import Callable, Collection
from enum import Enum
from functools import partial
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from bringup.viewing.drawing.values import LAYERS
from bringup.viewing.robot.managed import COMMANDS
from bringup.viewing.robot.robot_side import RobotSide


class Tool(Enum):
    """The use of a click on the ground."""

    LOOK = "look around"
    GOAL = "2D goal"
    POSE = "2D pose estimate"
    POINT = "publish point"


HINTS = {
    Tool.LOOK: "Drag to turn the view, right button to shift it, wheel to come closer.",
    Tool.GOAL: "Press where the robot shall go, drag to where it shall look, release.",
    Tool.POSE: "Press where the robot is, drag to where it looks, release.",
    Tool.POINT: "Click on the ground.",
}
_KEYS = {  # label: forward and turning speed, in parts of the sliders' values
    "▲ forward": (1.0, 0.0),
    "◀ turn left": (0.0, 1.0),
    "▶ turn right": (0.0, -1.0),
    "▼ back": (-1.0, 0.0),
}


class Panel:
    """Builds the panel; each use of it queues a call.

    Args:
        queue: Queues a function and its arguments, for viser calls back on its own threads.
        shown: The layers that are shown at first.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        robot: RobotSide,
        queue: Callable[..., None],
        take_tool: Callable[[Tool], None],
        show_layer: Callable[[str, bool], None],
        shown: Collection[str],
    ) -> None:
        self._gui, self._queue = server.gui, queue
        self._gui.configure_theme(show_logo=False, show_share_button=False)
        self._gui.main_panel.dock_right()
        with self._gui.add_folder("Navigation"):
            self._navigation = self._gui.add_markdown("")
        stop = self._gui.add_button("Stop", color="red", icon=viser.Icon.HAND_STOP)
        stop.on_click(self._call(robot.stop))
        with self._gui.add_folder("Tools"):
            tools = self._gui.add_button_group("", tuple(tool.value for tool in Tool))
            tools.on_click(self._call(take_tool, lambda: Tool(tools.value)))
            self._hint = self._gui.add_markdown(HINTS[Tool.LOOK])
        black = np.zeros((60, 80, 3), np.uint8)
        self._camera = self._gui.add_image(black, label="Camera", format="jpeg", visible=False)
        with self._gui.add_folder("Layers", expand_by_default=True):
            for name, layer in LAYERS.items():
                self._add_layer(name, layer.label, name in shown, show_layer)
        with self._gui.add_folder("Drive by hand", expand_by_default=False):
            self._add_driving(robot)
        with self._gui.add_folder("Nodes", expand_by_default=False):
            managers = self._gui.add_button_group("Managers", tuple(COMMANDS))
            managers.on_click(self._call(robot.managed.command, lambda: managers.value))
            clear = self._gui.add_button("Clear costmaps", color="gray")
            clear.on_click(self._call(robot.managed.clear_costmaps))
            self._nodes = self._gui.add_markdown("")

    def _call(self, function: Callable[..., None], *values: Callable[[], Any]) -> Any:
        """Return a callback for viser that queues a call with the values of that moment."""

        async def callback(event: Any) -> None:
            self._queue(function, *(value() for value in values))

        return callback

    def _add_layer(
        self, name: str, label: str, shown: bool, show_layer: Callable[[str, bool], None]
    ) -> None:
        box = self._gui.add_checkbox(label, shown)
        box.on_update(self._call(show_layer, lambda: name, lambda: box.value))

    def _add_driving(self, robot: RobotSide) -> None:
        buttons = [self._gui.add_button(k, color="gray", hint="hold it down") for k in _KEYS]
        speed = self._gui.add_slider("Speed [m/s]", 0.05, 1.0, 0.05, 0.3)
        turning = self._gui.add_slider("Turning [rad/s]", 0.1, 2.0, 0.1, 0.8)

        def drive(ahead: float, left: float) -> None:
            robot.drive(ahead * speed.value, left * turning.value)

        for button, parts in zip(buttons, _KEYS.values(), strict=True):
            button.on_hold(callback_hz=10.0)(self._call(partial(drive, *parts)))

    def show_state(self, navigation: str, nodes: str) -> None:
        """Show the state of navigation and of the nodes, as Markdown."""
        for handle, text in ((self._navigation, navigation), (self._nodes, nodes)):
            if handle.content != text:
                handle.content = text

    def hint(self, tool: Tool) -> None:
        """Explain the tool in hand."""
        self._hint.content = f"**{tool.value}**: {HINTS[tool]}"

    def show_camera(self, shown: bool) -> None:
        """Show or hide the camera's picture."""
        self._camera.visible = shown

    def picture(self, pixels: NDArray[np.uint8]) -> None:
        """Show a camera's picture, `(rows, columns, 3) uint8`."""
        self._camera.image = pixels
