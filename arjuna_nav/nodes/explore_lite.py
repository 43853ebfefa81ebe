"""explore: the explorer with the parameters and topics of explore_lite."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from geometry_msgs.msg import Point
from map_msgs.msg import OccupancyGridUpdate
from nav2_msgs.action import NavigateToPose
from std_msgs.msg import Bool, ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from arjuna_core.config import duration_param, fixed, length_param, load, param
from arjuna_core.grid import replace_cells
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, pose_stamped
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.config import CostmapConfig
from arjuna_nav.exploration.frontiers import ExplorationConfig, frontiers
from arjuna_nav.nodes.explorer import ExplorerNode


@dataclass(frozen=True)
class ExploreLiteConfig:
    """Parameters of `explore_node`."""

    robot_base_frame: str = fixed("base_link", "Frame of the robot.")
    costmap_topic: str = fixed("costmap", "Topic of the map, or of a costmap.")
    costmap_updates_topic: str = fixed("costmap_updates", "Topic of its changes.")
    visualize: bool = fixed(False, "Whether frontiers are published as markers.")
    planner_frequency: float = fixed(
        1.0, "Rate of looks at the map.", unit="Hz", minimum=0.01, maximum=10.0
    )
    progress_timeout: float = duration_param(
        30.0, "Time without progress after which a goal is given up."
    )
    potential_scale: float = param(1e-3, "Cost of a metre of path.", minimum=1e-9)
    orientation_scale: float = param(0.0, "Has no effect, there as here.")
    gain_scale: float = param(1.0, "Gain of a metre of frontier.", minimum=0.0)
    transform_tolerance: float = param(0.3, "Has no effect: the newest is taken.", unit="s")
    min_frontier_size: float = length_param(0.5, "Shortest frontier of interest.")
    return_to_init: bool = param(False, "Whether the robot drives back where it began.")
    robot_radius: float = length_param(
        0.25, "Distance to obstacles at which goals are; explore_lite has none.", minimum=0.01
    )

    map_frame = "map"
    patience = 0.0

    @property
    def period(self) -> float:
        """The time from one look at the map to the next [s]."""
        return 1.0 / self.planner_frequency

    @property
    def costmap(self) -> CostmapConfig:
        """The costmap in which goals are looked for, inflated by the robot's radius."""
        values = {
            "robot_radius": self.robot_radius,
            "track_unknown_space": True,
            "plugins": ["static_layer", "inflation_layer"],
            "inflation_layer.inflation_radius": 2.0 * self.robot_radius,
        }
        return load(CostmapConfig, values)

    @property
    def exploration(self) -> ExplorationConfig:
        """The explorer's own parameters; only the ratio of cost and gain decides."""
        ratio = self.gain_scale / self.potential_scale
        return ExplorationConfig(min_frontier_size=self.min_frontier_size, size_gain=ratio)


class ExploreLiteNode(ExplorerNode):
    """Explores as `explorer` does; explore/resume stops and resumes it.

    Source: m-explore-ros2, `explore::Explore`. Goals are where a frontier can be seen from.
    """

    Config = ExploreLiteConfig
    DEFAULT_NAME = "explore_node"

    def configure(self) -> None:
        config: ExploreLiteConfig = self.config
        self.map_topic = config.costmap_topic
        super().configure()
        self._paused = False
        self._start: SE2 | None = None
        self._nearest, self._progress_at, self._shown = math.inf, 0.0, 0
        self.subscribe(
            OccupancyGridUpdate, config.costmap_updates_topic, self._on_update, qos.DEFAULT
        )
        self.subscribe(Bool, "explore/resume", self._on_resume, qos.DEFAULT)
        self._markers = (
            self.publisher(MarkerArray, "explore/frontiers", qos.DEFAULT)
            if config.visualize
            else None
        )

    def _on_update(self, message: Any) -> None:
        if self._grid is None:
            return
        data = self._grid.data.copy()
        try:
            replace_cells(data, message.x, message.y, message.width, message.height, message.data)
        except ValueError as error:
            self.guard.refused(self, self.config.costmap_updates_topic, str(error))
            return
        self._grid = replace(self._grid, data=data)

    def _on_resume(self, message: Any) -> None:
        self._paused = not message.data
        if self._paused:
            self.deactivate()
        else:
            self.activate()

    def _look(self) -> None:
        pose = self.transforms.try_lookup(self.config.map_frame, self.config.robot_base_frame)
        if self._paused or pose is None:
            return
        self._start = pose if self._start is None else self._start
        if self._goal is not None:
            self._give_up_if_stuck(pose, self._goal)
        before = self._goal, self.done
        super()._look()
        if self._goal is not before[0]:
            self._nearest, self._progress_at = math.inf, self.now
        if self._markers is not None and self._grid is not None:
            self._show()
        if self.done and not before[1] and self.config.return_to_init:
            goal = pose_stamped(self._start, self.config.map_frame, self.now)
            self._client.send(NavigateToPose.Goal(pose=goal), lambda outcome: None)

    def _give_up_if_stuck(self, pose: SE2, goal: SE2) -> None:
        distance = math.hypot(goal.x - pose.x, goal.y - pose.y)
        if distance < self._nearest:
            self._nearest, self._progress_at = distance, self.now
        elif self.now - self._progress_at > self.config.progress_timeout:
            self._tried.append(goal)
            self._client.cancel()
            self._goal = None

    def _show(self) -> None:
        """Publish each frontier as points, and delete those of before."""
        assert self._grid is not None
        assert self._markers is not None
        found = frontiers(self._grid, self.config.exploration)
        markers = []
        for number in range(max(len(found), self._shown)):
            marker = Marker(header=header(self.config.map_frame, self.now), ns="frontiers")
            marker.id, marker.type, marker.action = number, Marker.POINTS, Marker.DELETE
            marker.pose.orientation.w = 1.0
            if number < len(found):
                marker.action = Marker.ADD
                marker.scale.x = marker.scale.y = marker.scale.z = 0.1
                marker.color = ColorRGBA(b=1.0, a=1.0)
                points = self._grid.frame.to_points(found[number])
                marker.points = [Point(x=x, y=y) for x, y in points.tolist()]
            markers.append(marker)
        self._shown = len(found)
        self._markers.publish(MarkerArray(markers=markers))
