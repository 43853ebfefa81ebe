"""The viewer: one loop that spins ROS while somebody looks, and rests while nobody does."""

from __future__ import annotations

import math
import queue
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from operator import methodcaller
from pathlib import Path
from typing import Any

import numpy as np
import viser

from arjuna_core.errors import ArjunaError
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from bringup.viewing.browser.panel import VIEWS, Panel, Tool
from bringup.viewing.browser.pointer import Point2, Pointer, dragged_pose
from bringup.viewing.browser.scene import Scene, path_part
from bringup.viewing.displays.base import Display, DisplaySpec, Moment
from bringup.viewing.displays.robot import RobotModel
from bringup.viewing.displays.standard import STANDARD
from bringup.viewing.drawing.messages import arrows
from bringup.viewing.drawing.values import Drawing, Grid, Label, Line, Parts, Picture, Values, Words
from bringup.viewing.robot.managed import nodes_text
from bringup.viewing.robot.robot_side import RobotSide
from bringup.viewing.rviz_file import RvizFile, read_rviz, write_rviz

_MARKS = "marks"


@dataclass
class _Shown:
    """A display in the viewer.

    Attributes:
        waiting: Drawings whose frames are not known yet at their stamps.
        kept: Those that stay for the display's `decay_time`, with when they were drawn [s].
    """

    spec: DisplaySpec
    display: Display
    waiting: deque[Parts] = field(default_factory=lambda: deque(maxlen=20))
    kept: deque[tuple[float, Parts]] = field(default_factory=lambda: deque(maxlen=200))
    error: str = ""
    drawn: int = 0

    def with_older(self, parts: Parts, now: float) -> Parts:
        """Return what is drawn with what was drawn before and stays at a time [s]."""
        stays = getattr(self.display.config, "decay_time", 0.0)
        if stays <= 0.0:
            return parts
        self.kept.append((now, {f"{self.drawn} {name}": part for name, part in parts.items()}))
        while self.kept[0][0] < now - stays:
            self.kept.popleft()
        return {name: part for _, each in self.kept for name, part in each.items()}


class Viewer:
    """Shows a robot to browsers and does what their users ask for.

    Args:
        cpu: Returns the share of a core that each node's process used since its last call, by the
            node's name.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        robot: RobotSide,
        displays: Iterable[DisplaySpec] = STANDARD,
        config: RvizFile | None = None,
        cpu: Callable[[], Mapping[str, float]] = dict,
    ) -> None:
        self._robot, self._server, self._config, self._cpu = robot, server, config, cpu
        self._calls: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._scene = Scene(server)
        self._scene.add(_MARKS, True)
        self._panel = Panel(server, robot, self._queue, self._take, self._look, self._drive_route)
        self._pointer = Pointer(server, partial(self._queue, self._point))
        self._tool, self._following = Tool.LOOK, False
        self._frame = ""  # that the view follows, where it is not the robot's base
        self._shown: dict[str, _Shown] = {}
        self._topics: dict[str, str] = {}
        self._shares: Mapping[str, float] = {}
        self._route: list[SE2] = []
        self._map: Grid | None = None
        self._people: Parts | None = None
        self._root = ""
        self._due = self._slow_due = 0.0
        self._viewers = self._number = 0
        listed = self._panel.displays
        listed.show, listed.change, listed.rename = self._toggle, self._change, self._rename
        listed.remove, listed.choose, listed.add = self._remove, self._choose, self._add_new
        listed.save, listed.load = self._save, self._load
        for spec in displays:
            self.add(spec)
        if config is not None:
            self._work_as(config)
        server.on_client_connect(self._on_viewers)
        server.on_client_connect(self._on_newcomer)
        server.on_client_disconnect(self._on_viewers)

    def _queue(self, function: Callable[..., None], *values: Any) -> None:
        self._calls.put(partial(function, *values))

    async def _on_viewers(self, client: Any) -> None:
        self._queue(self._count_viewers, len(self._server.get_clients()))

    async def _on_newcomer(self, client: Any) -> None:
        self._queue(self._scene.greet, client)
        client.camera.on_update(lambda camera: self._queue(self._scene.confirm, client))

    def step(self, period: float = 0.1, rest: float = 0.5) -> None:
        """Do one period's work [s]; where nobody looks, wait up to a rest [s] for a viewer."""
        if self._viewers == 0:
            try:
                self._calls.get(timeout=rest)()
            except queue.Empty:
                return
        now = time.monotonic()
        self._due = max(self._due + period, now)
        self._robot.spin(self._due)
        while not self._calls.empty():
            self._calls.get()()
        if self._viewers > 0:
            with self._server.atomic():
                self._draw()

    def _draw(self) -> None:
        robot, now = self._robot, time.monotonic()
        robot.tick(now)
        self._scene.drop_old()
        for key, message in robot.feed.take():
            self._do(key, methodcaller("take", message))
        base = self._base
        left, people = robot.navigation.state.distance, robot.entities.take(base)
        moment = Moment(now, robot.frames, left, people)
        for key, each in self._shown.items():
            if each.spec.shown:
                self._do(key, methodcaller("tick", moment))
                self._show_waiting(key, each, now)
        self._scene.update(robot.frames)
        followed = self._frame or base
        pose = robot.frames.pose(followed) if self._following and followed else None
        if pose is not None:
            self._scene.centre(pose.position[:2])
        if now >= self._slow_due:
            self._slow_due = now + 2.0
            self._topics, self._shares = robot.topics(), self._cpu()
            self._panel.displays.offer(self._topics)
            self._panel.show_joints(self._joints() if robot.joints.look() else {})
        managed = robot.managed
        table = nodes_text(managed.states, self._shares)
        nodes = "\n\n".join(filter(None, (managed.report, table)))
        self._panel.show_state(robot.navigation.state.text(), nodes)
        self._panel.displays.show_status(self._status())

    def _do(self, key: str, draw: Callable[[Display], Parts | None]) -> None:
        """Let a display draw; what it finds wrong with a message is said once."""
        each = self._shown[key]
        try:
            parts = draw(each.display)
        except (ValueError, ArjunaError) as error:
            if each.error != str(error):
                each.error = str(error)
                self._robot.node.get_logger().warning(f"{each.spec.name}: {error}")
            return
        if parts is not None:
            each.error = ""
            each.waiting.append(parts)

    def _show_waiting(self, key: str, each: _Shown, now: float) -> None:
        """Draw the newest of a display's drawings whose frames are known at their stamps."""
        frames = self._robot.frames
        for number in reversed(range(len(each.waiting))):
            parts = each.waiting[number]
            stamped = (part for part in parts.values() if part.stamp is not None)
            if all(frames.pose(part.frame, part.stamp) is not None for part in stamped):
                for _ in range(number + 1):
                    each.waiting.popleft()
                self._show(key, each, parts, now)
                return

    def _show(self, key: str, each: _Shown, parts: Parts, now: float) -> None:
        each.drawn += 1
        beside: Any = (Picture, Values, Words)
        for name, part in parts.items():
            if isinstance(part, beside):
                self._panel.show_beside(key, each.spec.name, part, now)
            elif isinstance(part, Grid) and part.opacity is None and name == "":
                self._map = part
                self._scene.frame_map(part)
        drawn = {name: part for name, part in parts.items() if not isinstance(part, beside)}
        self._scene.draw(key, each.with_older(drawn, now))
        if isinstance(each.display, RobotModel):
            self._root = each.display.base
            self._server.gui.set_panel_label(each.display.robot or "Arjuna")
            for note in each.display.notes:
                self._robot.node.get_logger().warning(note)

    def _joints(self) -> Mapping[str, tuple[float, float]]:
        """Return the limits of the joints of the robot that is shown."""
        models = (each.display for each in self._shown.values())
        return next((one.joints for one in models if isinstance(one, RobotModel)), {})

    @property
    def _base(self) -> str:
        """The robot's own frame: its description's root, else a usual name, or ""."""
        names = filter(None, (self._root, "base_footprint", "base_link"))
        return next((name for name in names if self._robot.frames.knows(name)), "")

    def _status(self) -> str:
        """Return how the chosen display fares."""
        each = self._shown.get(self._panel.displays.chosen)
        if each is None:
            return ""
        if each.error:
            return f"⚠ {each.error}"
        if each.waiting:
            part = next(iter(each.waiting[-1].values()))
            return f"⚠ no transform from '{part.frame}' to '{self._robot.frames.fixed}' at its time"
        if not each.spec.shown:
            return "hidden"
        topic = each.display.name
        return "shown" if each.drawn else f"nothing has come on '{topic}' yet" if topic else ""

    def _count_viewers(self, count: int) -> None:
        self._viewers = count
        self._listen()

    def _listen(self) -> None:
        """Subscribe to what is shown, as long as somebody looks; to the frames always."""
        shown = {key: each.display for key, each in self._shown.items() if each.spec.shown}
        self._robot.listen(shown if self._viewers else None)

    def add(self, spec: DisplaySpec) -> str:
        """Add a display and return its key.

        Raises:
            ConfigError: There is no such display.
        """
        display = spec.make()
        self._number += 1
        key = f"{path_part(spec.name).lower().replace(' ', '_')}_{self._number}"
        self._shown[key] = _Shown(spec, display)
        self._scene.add(key, spec.shown)
        self._panel.displays.put(key, spec.name, spec.shown)
        self._listen()
        return key

    def _add_new(self, kind: str, topic: str) -> None:
        key = self.add(DisplaySpec(kind, f"{kind} {topic}".strip(), topic))
        self._panel.displays.select(key)
        self._choose(key)

    def _remove(self, key: str) -> None:
        if key in self._shown:
            del self._shown[key]
            self._scene.remove(key)
            self._panel.hide_beside(key)
            self._panel.displays.drop(key)
            self._listen()
            self._choose(self._panel.displays.chosen)

    def _toggle(self, key: str, shown: bool) -> None:
        each = self._shown[key]
        each.spec = replace(each.spec, shown=shown)
        self._scene.show(key, shown)
        if not shown:
            self._panel.hide_beside(key)
        self._listen()

    def _choose(self, key: str) -> None:
        if key in self._shown:
            self._panel.displays.show_settings(key, self._shown[key].display, self._topics)

    def _change(self, key: str, name: str, value: Any) -> None:
        """Change one of a display's settings; its next message is drawn by it."""
        if key in self._shown:
            settings = self._shown[key].spec.settings
            self._make_again(key, settings={**settings, name: value})

    def _make_again(self, key: str, **changes: Any) -> None:
        if key in self._shown:
            spec = replace(self._shown[key].spec, **changes)
            self._shown[key] = _Shown(spec, spec.make())
            self._robot.feed.forget(key)  # so that what is published once comes again
            self._listen()

    def _rename(self, key: str, topic: str) -> None:
        self._make_again(key, topic=topic, anywhere=False)

    def specs(self) -> list[DisplaySpec]:
        """Return the displays as they are now."""
        return [each.spec for each in self._shown.values()]

    def _save(self, client: Any) -> None:
        frame = self._robot.frames.fixed or "map"
        text = write_rviz(frame, self.specs(), self._config)
        client.send_file_download("view.rviz", text.encode(), save_immediately=True)

    def _load(self, content: bytes) -> None:
        """Show the displays of a file in place of those that are here."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "view.rviz"
            path.write_bytes(content)
            try:
                found = read_rviz(path)
            except ArjunaError as error:
                self._panel.show_tool(self._tool, f"⚠ {error}")
                return
        for key in list(self._shown):
            self._remove(key)
        self._config = found
        self._robot.frames.wanted = found.fixed_frame or "map"
        for spec in found.displays:
            self.add(spec)
        self._work_as(found)
        if found.unsupported:
            self._panel.show_tool(self._tool, f"Not shown here: {', '.join(found.unsupported)}")

    def _work_as(self, config: RvizFile) -> None:
        """Use tools as a file does, and look from where it does, where it says."""
        self._robot.command_on(config.tools)
        if (view := config.view) is not None:
            self._look("", bool(view.frame))
            self._frame = view.frame
            self._panel.follow.value = self._following
            self._scene.place(view.eye, view.focus)

    def _look(self, view: str, follow: bool) -> None:
        """Look from where a view says, and stay at the robot or at the map."""
        if follow != self._following:
            self._frame = ""
            self._following = follow
            if not follow:
                self._scene.centre((0.0, 0.0))
            view = view or "whole map"
        if view:
            self._scene.look(np.array(VIEWS[view]), whole=not follow)

    def _take(self, tool: Tool, note: str = "") -> None:
        self._tool = tool
        self._pointer.hold(tool is not Tool.LOOK)
        self._panel.show_tool(tool, note, len(self._route))

    def _point(self, start: Point2, end: Point2) -> None:
        """Use the tool in hand where the ground was pointed at, and lay it down."""
        dx, dy = self._scene.offset
        start, end = (start[0] + dx, start[1] + dy), (end[0] + dx, end[1] + dy)
        robot, frame = self._robot.frames.pose(self._base), self._robot.frames.fixed
        pose = dragged_pose(start, end, robot.planar() if robot else None)
        if frame is None and self._tool is not Tool.LOOK:
            self._take(Tool.LOOK, "⚠ Not taken: no frame is known yet; is the robot running?")
            return
        note = self._use(pose, start, end, frame or "")
        self._take(self._tool if self._tool is Tool.WAYPOINT else Tool.LOOK, note)

    def _use(self, pose: SE2, start: Point2, end: Point2, frame: str) -> str:
        """Do what the tool in hand is for and draw it at once; return what there is to say."""
        at = f"({pose.x:.2f}, {pose.y:.2f})"
        marks: dict[str, Drawing] = {}
        note = ""
        if self._tool is Tool.GOAL:
            self._robot.send_goal(pose)
            state = self._robot.navigation.state
            near = self._obstacle(pose)
            note = f"⚠ {state.error or near}" if state.error or near else f"goal {at} is sent"
            marks["goal"] = arrows(frame, pose.array()[None], (220, 40, 180), 0.5, 0.06, 0.06)
        elif self._tool is Tool.WAYPOINT:
            self._route.append(pose)
            note = f"waypoint {len(self._route)} {at}"
            poses = np.array([each.array() for each in self._route])
            marks["route"] = arrows(frame, poses, (220, 40, 180), 0.5, 0.06, 0.06)
        elif self._tool is Tool.POSE:
            self._robot.estimate(pose)
            note = f"pose {at} is sent"
            marks["pose"] = arrows(frame, pose.array()[None], (150, 60, 200), 0.5, 0.06, 0.06)
        elif self._tool is Tool.POINT:
            self._robot.publish_point(pose)
            note = f"point {at} is published"
        elif self._tool is Tool.MEASURE:
            length = math.dist(start, end)
            turn = math.degrees(math.atan2(end[1] - start[1], end[0] - start[0]))
            note = f"{length:.3f} m, at {turn:.1f}°"
            ends = np.array([(*start, 0.05), (*end, 0.05)], np.float32)
            marks["measure"] = Line(frame=frame, points=ends, colour=(255, 120, 0), width=4.0)
            middle = SE2((start[0] + end[0]) / 2.0, (start[1] + end[1]) / 2.0, 0.0)
            text = f"{length:.2f} m"
            marks["length"] = Label(frame=frame, pose=Pose3.from_se2(middle), text=text)
        self._scene.draw(_MARKS, marks)
        return note

    def _drive_route(self, action: str) -> None:
        """Drive the waypoints by an action, or only remove them."""
        route, self._route = self._route, []
        note, navigation = f"{len(route)} waypoints are removed", self._robot.navigation
        if action:
            navigation.send(route, self._robot.frames.fixed or "map", action)
            error = navigation.state.error
            note = f"⚠ {error}" if error else f"{len(route)} waypoints are sent"
        else:
            self._scene.draw(_MARKS, {})
        self._take(Tool.LOOK, note)

    def _obstacle(self, goal: SE2, radius: float = 0.2) -> str:
        """Return what on the map is in the way of a goal, for a usual robot's radius [m], or ""."""
        if self._map is None or self._map.frame != self._robot.frames.fixed:
            return ""
        grid = self._map.grid
        angles = np.linspace(0.0, 2.0 * math.pi, 16)
        ring = radius * np.column_stack([np.cos(angles), np.sin(angles)])
        points = np.vstack([np.zeros(2), ring]) + np.array((goal.x, goal.y))
        cells = grid.frame.to_cells(points)
        inside = grid.frame.inside(cells)
        if not inside[0]:
            return "the goal is off the map; planners refuse that or stop short of it"
        values = grid.data[cells[inside, 0], cells[inside, 1]]
        if values[0] < 0:
            return "the goal is where the map knows nothing"
        if values.max() >= 65:
            return "the goal is in or near a wall: the planner takes a free place near by, or fails"
        return ""
