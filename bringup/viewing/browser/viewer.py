"""The viewer: one loop that spins ROS while somebody looks, and rests while nobody does."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Collection
from functools import partial
from typing import Any

import viser

from arjuna_core.pixels import pixels
from bringup.viewing.browser.panel import Panel, Tool
from bringup.viewing.browser.pointer import Point2, Pointer, dragged_pose
from bringup.viewing.browser.scene import RobotScene, Scene
from bringup.viewing.drawing import visual_model
from bringup.viewing.drawing.messages import goal_arrow
from bringup.viewing.drawing.values import LAYERS, Drawing
from bringup.viewing.robot.managed import nodes_text
from bringup.viewing.robot.robot_side import RobotSide
from bringup.viewing.robot.topics import TOPICS


class Viewer:
    """Shows a robot to browsers and does what their users ask for.

    Args:
        shown: The layers that are shown at first; those of `LAYERS` by default.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        robot: RobotSide,
        find_mesh: visual_model.FindMesh,
        shown: Collection[str] | None = None,
    ) -> None:
        self._robot = robot
        self._find_mesh = find_mesh
        self._calls: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._scene = Scene(server)
        self._body = RobotScene(server)
        usual = {name for name, layer in LAYERS.items() if layer.shown}
        self._shown = usual if shown is None else set(shown)
        self._panel = Panel(server, robot, self._queue, self._take, self._toggle, self._shown)
        self._pointer = Pointer(server, partial(self._queue, self._point))
        self._tool = Tool.LOOK
        self._base = ""
        self._waiting: dict[str, Any] = {}
        self._due = 0.0
        self._viewers = 0
        self._server = server
        for name in usual ^ self._shown:
            self._scene.show(name, name in self._shown)
            self._body.show(name, name in self._shown)
        self._panel.show_camera("camera" in self._shown)
        server.on_client_connect(self._on_viewers)
        server.on_client_disconnect(self._on_viewers)

    def _queue(self, function: Callable[..., None], *values: Any) -> None:
        self._calls.put(partial(function, *values))

    async def _on_viewers(self, client: Any) -> None:
        self._queue(self._count_viewers, len(self._server.get_clients()))

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
        self._robot.tick(time.monotonic())
        self._scene.drop_old()
        self._waiting.update(self._robot.take())
        for key in [key for key, item in self._waiting.items() if self._is_placed(item)]:
            self._show(key, self._waiting.pop(key))
        if (bodies := self._robot.entities.take(self._base)) is not None:
            self._scene.draw("people", "people", bodies)
        self._scene.update(self._robot.frames)
        self._body.update(self._robot.frames)
        managed = self._robot.managed
        nodes = "\n\n".join(filter(None, (managed.report, nodes_text(managed.states))))
        self._panel.show_state(self._robot.navigation.state.text(), nodes)

    def _is_placed(self, item: Any) -> bool:
        """Return whether the transforms have come to a drawing's stamp."""
        frames = self._robot.frames
        stamped = isinstance(item, Drawing) and item.stamp is not None
        return not stamped or frames.pose(item.frame, item.stamp) is not None

    def _show(self, key: str, item: Any) -> None:
        if key == "robot":
            self._set_robot(item.data)
        elif key == "camera":
            image = (item.encoding, item.height, item.width, item.step, bytes(item.data))
            self._panel.picture(pixels(*image, widest=320))
        else:
            self._scene.draw(TOPICS[key].layer, key, item)
            if key == "map":
                self._scene.look_at(item.pose.planar(), item.size)

    def _set_robot(self, description: str) -> None:
        logger = self._robot.node.get_logger()
        try:
            model = visual_model.read(description, self._find_mesh)
        except visual_model.VisualError as error:
            logger.warning(str(error))
            return
        for note in model.notes:
            logger.warning(note)
        self._base = model.root
        self._body.set_links(model.glbs)

    def _count_viewers(self, count: int) -> None:
        self._viewers = count
        self._listen()

    def _listen(self) -> None:
        """Subscribe to what is shown, as long as somebody looks; to the frames always."""
        self._robot.listen(self._shown | {"axes"} if self._viewers else ())

    def _toggle(self, layer: str, shown: bool) -> None:
        (self._shown.add if shown else self._shown.discard)(layer)
        self._scene.show(layer, shown)
        self._body.show(layer, shown)
        if layer == "camera":
            self._panel.show_camera(shown)
        self._listen()

    def _take(self, tool: Tool) -> None:
        self._tool = tool
        self._pointer.hold(tool is not Tool.LOOK)
        self._panel.hint(tool)

    def _point(self, start: Point2, end: Point2) -> None:
        """Use the tool in hand where the ground was pointed at, and lay it down."""
        robot = self._robot.frames.pose(self._base)
        pose = dragged_pose(start, end, robot.planar() if robot else None)
        uses = {
            Tool.GOAL: self._robot.send_goal,
            Tool.POSE: self._robot.estimate,
            Tool.POINT: self._robot.publish_point,
        }
        if self._tool in uses:
            uses[self._tool](pose)
        frame = self._robot.frames.fixed
        if self._tool is Tool.GOAL and frame is not None:
            self._scene.draw("goals", "goal", goal_arrow(pose, frame))
        self._take(Tool.LOOK)
