"""The viewer: one loop that spins ROS while somebody looks, and rests while nobody does."""

from __future__ import annotations

import queue
import time
from collections.abc import Collection
from typing import Any

import viser

from arjuna_core.se2 import SE2
from bringup.viewing.browser.panel import Panel
from bringup.viewing.browser.pointer import Pointer
from bringup.viewing.browser.robot_scene import RobotScene
from bringup.viewing.browser.scene import Scene
from bringup.viewing.drawing import camera, looks, shapes, wishes
from bringup.viewing.drawing.ground import dragged_pose, heading_to
from bringup.viewing.drawing.layers import LAYERS
from bringup.viewing.drawing.status import nodes_text
from bringup.viewing.drawing.values import Arrows, Drawing
from bringup.viewing.drawing.wishes import Tool, Wish
from bringup.viewing.robot.robot_side import RobotSide
from bringup.viewing.robot.topics import GOAL_COLOUR, GOAL_LENGTH, TOPICS

PERIOD = 0.1
"""Time between two pictures [s]."""
_REST = 0.5  # how long to wait for a viewer before looking whether to stop [s]


class Viewer:
    """Shows a robot to browsers and does what they ask for.

    Args:
        server: viser's server.
        robot: The ROS side.
        find_mesh: Finds the meshes of the robot's description.
        shown: The layers that are shown at first; those of `LAYERS` by default.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        robot: RobotSide,
        find_mesh: looks.FindMesh,
        shown: Collection[str] | None = None,
    ) -> None:
        self._robot = robot
        self._find_mesh = find_mesh
        self.wishes: queue.SimpleQueue[Wish] = queue.SimpleQueue()
        self._scene = Scene(server)
        self._body = RobotScene(server)
        usual = {name for name, layer in LAYERS.items() if layer.shown}
        self._shown = usual if shown is None else set(shown)
        self._panel = Panel(server, self.wishes.put, self._shown)
        self._pointer = Pointer(server, self.wishes.put)
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

    async def _on_viewers(self, client: Any) -> None:
        self.wishes.put(wishes.Viewers(len(self._server.get_clients())))

    def step(self, period: float = PERIOD) -> None:
        """Do one period's work [s], or wait for a viewer or a wish."""
        if self._viewers == 0:
            try:
                self._grant(self.wishes.get(timeout=_REST))
            except queue.Empty:
                return
        now = time.monotonic()
        self._due = max(self._due + period, now)
        self._robot.spin(self._due)
        while not self.wishes.empty():
            self._grant(self.wishes.get())
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
        self._scene.place(self._robot.frames)
        self._body.place(self._robot.frames)
        managed = self._robot.managed
        nodes = "\n\n".join(filter(None, (managed.said, nodes_text(managed.states))))
        self._panel.say(self._robot.navigation.state.text(), nodes)

    def _is_placed(self, item: Any) -> bool:
        """Tell whether the transforms have come to where a drawing's stamp is."""
        frames = self._robot.frames
        stamped = isinstance(item, Drawing) and item.stamp is not None
        return not stamped or frames.pose(item.frame, item.stamp) is not None

    def _show(self, key: str, item: Any) -> None:
        """Draw what came on a topic."""
        if key == "robot":
            self._dress(item.data)
        elif key == "camera":
            picture = (item.encoding, item.height, item.width, item.step, bytes(item.data))
            self._panel.picture(camera.pixels(*picture))
        else:
            self._scene.draw(TOPICS[key].layer, key, item)
            if key == "map":
                self._scene.look_at(item.pose.planar(), item.size)

    def _dress(self, description: str) -> None:
        """Give the robot its looks."""
        logger = self._robot.node.get_logger()
        try:
            found = looks.read(description, self._find_mesh)
        except looks.LooksError as error:
            logger.warning(str(error))
            return
        for note in found.notes:
            logger.warning(note)
        self._base = found.root
        self._body.wear(found.glbs)

    def _grant(self, wish: Wish) -> None:
        """Do what was asked for."""
        if isinstance(wish, wishes.Viewers):
            self._viewers = wish.count
            self._listen()
        elif isinstance(wish, wishes.Show):
            self._toggle(wish)
        elif isinstance(wish, wishes.Take):
            self._take(wish.tool)
        elif isinstance(wish, wishes.Pointed):
            self._point(wish)
        else:
            self._robot.act(wish, time.monotonic())

    def _listen(self) -> None:
        """Hear what is shown, as long as somebody looks; the frames always."""
        self._robot.listen(self._shown | {"axes"} if self._viewers else ())

    def _toggle(self, wish: wishes.Show) -> None:
        (self._shown.add if wish.shown else self._shown.discard)(wish.layer)
        self._scene.show(wish.layer, wish.shown)
        self._body.show(wish.layer, wish.shown)
        if wish.layer == "camera":
            self._panel.show_camera(wish.shown)
        self._listen()

    def _take(self, tool: Tool) -> None:
        self._tool = tool
        self._pointer.take(tool)
        self._panel.hint(tool)

    def _point(self, pointed: wishes.Pointed) -> None:
        """Use the tool in hand where the ground was pointed at, and lay it down."""
        robot = self._robot.frames.pose(self._base)
        heading = heading_to(robot.planar() if robot else None, pointed.start)
        pose = dragged_pose(pointed.start, pointed.end, heading)
        made: dict[Tool, Wish] = {
            Tool.GOAL: wishes.Goal(pose),
            Tool.POSE: wishes.PoseEstimate(pose),
            Tool.POINT: wishes.GroundPoint(pose.x, pose.y),
        }
        if self._tool in made:
            self._robot.act(made[self._tool], time.monotonic())
        if self._tool is Tool.GOAL:
            self._mark(pose)
        self._take(Tool.LOOK)

    def _mark(self, goal: SE2) -> None:
        frame = self._robot.frames.fixed
        if frame is not None:
            segments = shapes.arrow(goal, GOAL_LENGTH, 0.06)
            arrow = Arrows(frame=frame, segments=segments, colour=GOAL_COLOUR)
            self._scene.draw("goals", "goal", arrow)
