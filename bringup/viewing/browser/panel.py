"""The panel beside the picture: tools, driving, layers, navigation and nodes."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from bringup.viewing.drawing import wishes
from bringup.viewing.drawing.layers import LAYERS
from bringup.viewing.drawing.wishes import HINTS, Tool, Wish
from bringup.viewing.robot.managed import COMMANDS

_HOLD_RATE = 10.0
_TOOLS = {tool.value: tool for tool in Tool}
_KEYS = {  # label: how fast forward and to the left, in parts of what the sliders say
    "▲ forward": (1.0, 0.0),
    "◀ turn left": (0.0, 1.0),
    "▶ turn right": (0.0, -1.0),
    "▼ back": (-1.0, 0.0),
}


class Panel:
    """Builds the panel; what a person does in it becomes wishes.

    viser calls back on its own threads, so a wish is only handed over.

    Args:
        server: viser's server.
        wish: Takes a wish; must not block.
        shown: The layers that are shown at first.
    """

    def __init__(
        self, server: viser.ViserServer, wish: Callable[[Wish], None], shown: Collection[str]
    ) -> None:
        self._gui = server.gui
        self._wish = wish
        self._gui.configure_theme(show_logo=False, show_share_button=False)
        self._gui.main_panel.dock_right()
        self._navigation = self._text("Navigation")
        self._button("Stop", wishes.Stop(), color="red", icon=viser.Icon.HAND_STOP)
        self._hint = self._add_tools()
        black = np.zeros((60, 80, 3), np.uint8)
        self._camera = self._gui.add_image(black, label="Camera", format="jpeg", visible=False)
        with self._gui.add_folder("Layers", expand_by_default=True):
            for name, layer in LAYERS.items():
                self._add_layer(name, layer.label, name in shown)
        with self._gui.add_folder("Drive by hand", expand_by_default=False):
            self._add_driving()
        with self._gui.add_folder("Nodes", expand_by_default=False):
            self._add_commands()
            self._nodes = self._gui.add_markdown("")

    def _text(self, title: str) -> Any:
        with self._gui.add_folder(title):
            return self._gui.add_markdown("")

    def _button(self, label: str, wish: Wish, **style: Any) -> None:
        button = self._gui.add_button(label, **style)

        @button.on_click
        async def _(event: Any) -> None:
            self._wish(wish)

    def _add_tools(self) -> Any:
        with self._gui.add_folder("Tools"):
            choice = self._gui.add_button_group("", tuple(_TOOLS))
            hint = self._gui.add_markdown(HINTS[Tool.LOOK])

        @choice.on_click
        async def _(event: Any) -> None:
            self._wish(wishes.Take(_TOOLS[choice.value]))

        return hint

    def _add_layer(self, name: str, label: str, shown: bool) -> None:
        box = self._gui.add_checkbox(label, shown)

        @box.on_update
        async def _(event: Any) -> None:
            self._wish(wishes.Show(name, box.value))

    def _add_driving(self) -> None:
        for label, (ahead, left) in _KEYS.items():
            button = self._gui.add_button(label, color="gray", hint="hold it down")

            @button.on_hold(callback_hz=_HOLD_RATE)
            async def _(event: Any, ahead: float = ahead, left: float = left) -> None:
                self._wish(wishes.Drive(ahead * speed.value, left * turning.value))

        speed = self._gui.add_slider("Speed [m/s]", 0.05, 1.0, 0.05, 0.3)
        turning = self._gui.add_slider("Turning [rad/s]", 0.1, 2.0, 0.1, 0.8)

    def _add_commands(self) -> None:
        choice = self._gui.add_button_group("Managers", tuple(COMMANDS))

        @choice.on_click
        async def _(event: Any) -> None:
            self._wish(wishes.Manage(choice.value))

        self._button("Clear costmaps", wishes.ClearCostmaps(), color="gray")

    def say(self, navigation: str, nodes: str) -> None:
        """Show the state of navigation and of the nodes, as Markdown."""
        for handle, text in ((self._navigation, navigation), (self._nodes, nodes)):
            if handle.content != text:
                handle.content = text

    def hint(self, tool: Tool) -> None:
        """Say what the tool in hand does."""
        self._hint.content = f"**{tool.value}**: {HINTS[tool]}"

    def show_camera(self, shown: bool) -> None:
        """Show or hide the camera's picture."""
        self._camera.visible = shown

    def picture(self, pixels: NDArray[np.uint8]) -> None:
        """Show a camera's picture, `(rows, columns, 3) uint8`."""
        self._camera.image = pixels
