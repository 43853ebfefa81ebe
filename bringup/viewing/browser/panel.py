"""The panel beside the picture: tools, views, driving, displays, navigation and nodes."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from enum import Enum
from functools import partial
from typing import Any

import numpy as np
import viser

from bringup.viewing.browser.display_list import DisplayList
from bringup.viewing.drawing.values import Drawing, Picture, Values, Words
from bringup.viewing.robot.managed import COMMANDS, ManagedNodes
from bringup.viewing.robot.robot_side import RobotSide


class Tool(Enum):
    """The use of a click on the ground."""

    LOOK = "look around"
    GOAL = "2D goal"
    WAYPOINT = "add a waypoint"
    POSE = "2D pose estimate"
    POINT = "publish point"
    MEASURE = "measure"


HINTS = {
    Tool.LOOK: "Drag to turn the view, right button to shift it, wheel to come closer.",
    Tool.GOAL: "Press where the robot shall go, drag to where it shall look, release.",
    Tool.WAYPOINT: "As a goal, one after the other; then choose below how to drive them.",
    Tool.POSE: "Press where the robot is, drag to where it looks, release.",
    Tool.POINT: "Click on the ground.",
    Tool.MEASURE: "Press at one end, drag to the other, release.",
}
ROUTES = {"through": "navigate_through_poses", "stop at each": "follow_waypoints", "clear": ""}
"""Ways to drive waypoints, and their actions."""
VIEWS = {"whole map": (0.0, -0.5, 0.75), "from above": (0.0, -1e-3, 1.0)}
"""Directions from which the middle of the map is seen, in parts of the map's extent."""
_KEYS = {  # label: forward and turning speed, in parts of the sliders' values
    "▲ forward": (1.0, 0.0),
    "◀ turn left": (0.0, 1.0),
    "▶ turn right": (0.0, -1.0),
    "▼ back": (-1.0, 0.0),
}
_CHOSEN = "● "


class Panel:
    """Builds the panel; each use of it queues a call.

    Args:
        queue: Queues a function and its arguments, for viser calls back on its own threads.
        look: Takes a view's name and whether the robot stays in the middle.
        drive_route: Takes an action that drives the waypoints; "" removes them.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        robot: RobotSide,
        queue: Callable[..., None],
        take_tool: Callable[[Tool], None],
        look: Callable[[str, bool], None],
        drive_route: Callable[[str], None],
    ) -> None:
        self._gui, self._queue = server.gui, queue
        self._gui.configure_theme(show_logo=False, show_share_button=False)
        self._gui.main_panel.dock_right()
        self._gui.set_panel_label("Arjuna")
        with self._gui.add_folder("Navigation"):
            self._navigation = self._gui.add_markdown("")
        stop = self._gui.add_button("Stop", color="red", icon=viser.Icon.HAND_STOP)
        stop.on_click(self._call(robot.stop))
        with self._gui.add_folder("Tools"):
            self._tools = self._gui.add_button_group("", self._tool_labels(Tool.LOOK))
            label = lambda: Tool(self._tools.value.removeprefix(_CHOSEN))  # noqa: E731
            self._tools.on_click(self._call(take_tool, label))
            self._hint = self._gui.add_markdown(HINTS[Tool.LOOK])
            route: Any = self._gui.add_button_group("Waypoints", tuple(ROUTES), visible=False)
            route.on_click(self._call(drive_route, lambda: ROUTES[route.value]))
            self._route = route
        with self._gui.add_folder("View"):
            views = self._gui.add_button_group("", tuple(VIEWS))
            follow: Any = self._gui.add_checkbox("Follow the robot", False)
            self.follow = follow
            views.on_click(self._call(look, lambda: views.value, lambda: follow.value))
            follow.on_update(self._call(look, lambda: "", lambda: follow.value))
        self._beside = self._gui.add_folder("Pictures and plots", visible=False)
        self._shown_beside: dict[str, tuple[Any, deque[Any]]] = {}
        self.displays = DisplayList(self._gui, self._call)
        with self._gui.add_folder("Drive by hand", expand_by_default=False):
            self._add_driving(robot)
        self._put_joints = robot.joints.put
        self._joints: Any = None
        self._shown_joints: Mapping[str, tuple[float, float]] = {}
        with self._gui.add_folder("Nodes", expand_by_default=False):
            self._add_nodes(robot.managed)
            self._nodes = self._gui.add_markdown("")

    def _call(self, function: Callable[..., None], *values: Callable[[], Any]) -> Any:
        """Return a callback for viser that queues a call with the values of that moment."""

        async def callback(event: Any) -> None:
            self._queue(function, *(value() for value in values))

        return callback

    @staticmethod
    def _tool_labels(chosen: Tool) -> tuple[str, ...]:
        return tuple(f"{_CHOSEN if tool is chosen else ''}{tool.value}" for tool in Tool)

    def _add_driving(self, robot: RobotSide) -> None:
        buttons = [self._gui.add_button(k, color="gray", hint="hold it down") for k in _KEYS]
        speed = self._gui.add_slider("Speed [m/s]", 0.05, 1.0, 0.05, 0.3)
        turning = self._gui.add_slider("Turning [rad/s]", 0.1, 2.0, 0.1, 0.8)

        def drive(ahead: float, left: float) -> None:
            robot.drive(ahead * speed.value, left * turning.value)

        for button, parts in zip(buttons, _KEYS.values(), strict=True):
            button.on_hold(callback_hz=10.0)(self._call(partial(drive, *parts)))

    def _add_nodes(self, managed: ManagedNodes) -> None:
        managers = self._gui.add_button_group("Managers", tuple(COMMANDS))
        managers.on_click(self._call(managed.command, lambda: managers.value))
        clear = self._gui.add_button("Clear costmaps", color="gray")
        clear.on_click(self._call(managed.clear_costmaps))
        name = self._gui.add_text("Name of the map", "map")
        save = self._gui.add_button_group("Save", ("map", "graph"))
        save.on_click(self._call(managed.save_map, lambda: save.value, lambda: name.value))

    def show_joints(self, joints: Mapping[str, tuple[float, float]]) -> None:
        """Show a slider a joint, by its limits [rad or m]; none hides them."""
        if joints == self._shown_joints:
            return
        self._shown_joints = dict(joints)
        if self._joints is not None:
            self._joints.remove()
            self._joints = None
        if not joints:
            return
        self._joints = self._gui.add_folder("Joints")
        with self._joints:
            sliders: dict[str, Any] = {
                name: self._gui.add_slider(
                    name, low, high, (high - low) / 200.0 or 0.01, min(max(0.0, low), high)
                )
                for name, (low, high) in joints.items()
            }
            middle = self._gui.add_button("Centre", color="gray")

        def centre() -> None:
            for name, (low, high) in joints.items():
                sliders[name].value = (low + high) / 2.0

        positions = lambda: {name: slider.value for name, slider in sliders.items()}  # noqa: E731
        for slider in sliders.values():
            slider.on_update(self._call(self._put_joints, positions))
        middle.on_click(self._call(centre))

    def show_state(self, navigation: str, nodes: str) -> None:
        """Show the state of navigation and of the nodes, as Markdown."""
        for handle, text in ((self._navigation, navigation), (self._nodes, nodes)):
            if handle.content != text:
                handle.content = text

    def show_tool(self, tool: Tool, note: str = "", waypoints: int = 0) -> None:
        """Mark the tool in hand and explain it; after a note on the last click, if there is one."""
        self._route.visible = waypoints > 0
        self._tools.options = self._tool_labels(tool)
        self._hint.content = "\n\n".join(filter(None, (note, f"**{tool.value}**: {HINTS[tool]}")))

    def show_beside(self, key: str, label: str, drawing: Drawing, now: float) -> None:
        """Show a display's picture, curves or words in place of its last ones.

        Args:
            now: Time [s, monotonic].
        """
        handle, past = self._shown_beside.get(key, (None, deque[Any](maxlen=600)))
        with self._beside:
            if isinstance(drawing, Picture):
                if handle is None:
                    handle = self._gui.add_image(drawing.pixels, label=label, format="jpeg")
                handle.image = drawing.pixels
            elif isinstance(drawing, Words):
                handle = handle or self._gui.add_markdown("")
                handle.content = f"**{label}**\n\n{drawing.text}"
            elif isinstance(drawing, Values):
                past.append((now, *drawing.values.values()))
                handle = self._plotted(handle, label, list(drawing.values), past)
        self._shown_beside[key] = handle, past
        self._beside.visible = True

    def _plotted(self, handle: Any, label: str, names: list[str], past: deque[Any]) -> Any:
        """Draw curves of the last minute, twice a second."""
        if handle is not None and len(past) % 5 and len(past) < (past.maxlen or 0):
            return handle
        columns = np.array(past, dtype=np.float64).T
        columns[0] -= columns[0, -1]  # seconds ago
        if handle is None:
            colours = ("#1e6ef0", "#dc2828", "#14a03c")
            series = ({"label": "s"}, *({"label": n, "stroke": colours[i % 3], "width": 2}
                                        for i, n in enumerate(names)))  # fmt: skip
            return self._gui.add_uplot(
                tuple(columns), series, title=label, height=150,  # type: ignore[arg-type]
                scales={"x": {"time": False}},
            )  # fmt: skip
        handle.data = tuple(columns)
        return handle

    def hide_beside(self, key: str) -> None:
        """Remove what a display showed."""
        handle, _ = self._shown_beside.pop(key, (None, None))
        if handle is not None:
            handle.remove()
        self._beside.visible = bool(self._shown_beside)
