"""Explores by itself: drives to frontiers of the map until none is left."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Point
from nav2_msgs.action import BackUp, NavigateToPose, Spin
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from std_msgs.msg import String

from arjuna_core.config import duration_param, fixed, length_param, speed_param
from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_from_msg, pose_stamped
from arjuna_core.ros.goal_client import GoalClient, GoalOutcome
from arjuna_core.ros.node import ManagedNode
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.config import CostmapConfig
from arjuna_nav.costmap.layered import LayeredCostmap
from arjuna_nav.exploration.frontiers import ExplorationConfig, frontiers, next_goal


@dataclass(frozen=True)
class ExplorerConfig:
    """Parameters of the node `explorer`."""

    period: float = duration_param(1.0, "Time between two looks at the map.", minimum=0.1)
    patience: float = duration_param(3.0, "How long no goal must be left to be done.")
    backup_dist: float = length_param(
        0.30, "Distance to back up where the robot is too near to something to look round."
    )
    backup_speed: float = speed_param(0.15, "Speed of that.")
    map_frame: str = fixed("map", "Frame of the map.")
    robot_base_frame: str = fixed("base_footprint", "Frame of the robot.")
    exploration: ExplorationConfig = field(default_factory=ExplorationConfig)
    costmap: CostmapConfig = field(default_factory=CostmapConfig)


class ExplorerNode(ManagedNode):
    """Sends `navigate_to_pose` goals; publishes `exploring: ...`, `done: ...` on explorer/status.

    Attributes:
        done: Whether nothing is left to explore.
    """

    Config: ClassVar[type[Any]] = ExplorerConfig
    DEFAULT_NAME = "explorer"
    map_topic = "map"
    done = False

    def configure(self) -> None:
        self._grid: OccupancyGrid | None = None
        self._goal: SE2 | None = None
        self._tried: list[SE2] = []
        self._idle_since: float | None = None
        self.done = False
        self._costmap = LayeredCostmap(self.config.costmap)
        self._status = self.publisher(String, "explorer/status", qos.LATCHED)
        self.subscribe(
            OccupancyGridMsg, self.map_topic, self._on_map, qos.LATCHED, while_inactive=True
        )
        self._client = self.keep(GoalClient(self, NavigateToPose, "navigate_to_pose"))
        self._spinner = self.keep(GoalClient(self, Spin, "spin"))
        self._backer = self.keep(GoalClient(self, BackUp, "backup"))
        self._turned = self._turning = self._backed_up = False
        self.every(self.config.period, self._look)

    def activate(self) -> None:
        self.done, self._idle_since = False, None

    def on_time_jump(self) -> None:
        self._idle_since = None

    def deactivate(self) -> None:
        if self._goal is not None:
            self._client.cancel()
            self._goal = None
        if self._turning:
            self._spinner.cancel()
            self._backer.cancel()

    @property
    def waits_for(self) -> str:
        """The missing server, map or frame with its remedy; empty where it can explore."""
        config = self.config
        if not self._client.ready:
            return "nobody serves 'navigate_to_pose': is 'python -m bringup nav --slam' running?"
        if self._grid is None:
            return (
                f"no map has come on '{self.map_topic}': is 'python -m bringup nav --slam' running?"
            )
        return self.transforms.missing_base(
            "robot_base_frame", config.robot_base_frame, config.map_frame
        )

    def _on_map(self, message: Any) -> None:
        try:
            self._grid = grid_from_msg(message)
        except ValueError as error:
            self.get_logger().error(f"map ignored: {error}")

    def _look(self) -> None:
        """Continue, turn to a better goal, or be done."""
        T_map_base = self.transforms.try_lookup(self.config.map_frame, self.config.robot_base_frame)
        if not self._client.ready:
            self._goal = None  # its server has gone, and sends no result
            return
        if self.done or self._turning or self._grid is None or T_map_base is None:
            return
        if self._goal is not None and self._is_useful(self._goal):
            return
        self._costmap.set_map(self._grid)
        costmap, footprint = self._costmap.costmap, self._costmap.footprint
        exploration = self.config.exploration
        goal = next_goal(self._grid, costmap, T_map_base, self._tried, exploration, footprint)
        if goal is not None:
            self._goal, self._idle_since = goal, None
            request = NavigateToPose.Goal(pose=pose_stamped(goal, self.config.map_frame, self.now))
            self._client.send(request, self._on_outcome)
            self._publish(f"exploring: to ({goal.x:.1f}, {goal.y:.1f})")
        elif self._goal is None and self._is_in_unknown(T_map_base):
            self._look_round()
        elif self._goal is None:
            self._finish_if_patient()

    def _is_in_unknown(self, T_map_base: SE2) -> bool:
        assert self._grid is not None
        cell = self._grid.frame.to_cell(T_map_base.x, T_map_base.y)
        return not (self._grid.frame.contains(*cell) and self._grid.free()[cell])

    def _look_round(self) -> None:
        """Turn once on the spot, where a server offers that: a lidar may look ahead only."""
        if self._turned or not self._spinner.ready:
            self._finish_if_patient()
            return
        self._turned = self._turning = True
        self._spinner.send(Spin.Goal(target_yaw=2.0 * math.pi), self._on_turned)
        self._publish("exploring: looking round")

    def _on_turned(self, outcome: GoalOutcome) -> None:
        """Back up once where something was in the way, as the recoveries of Nav2's trees do."""
        blocked = outcome.status == GoalStatus.STATUS_ABORTED
        self._turning = blocked and not self._backed_up and self._backer.ready
        if self._turning:
            self._backed_up = True
            target = Point(x=self.config.backup_dist)
            goal = BackUp.Goal(target=target, speed=self.config.backup_speed)
            self._backer.send(goal, self._on_backed_up)
            self._publish("exploring: backing up")

    def _on_backed_up(self, outcome: GoalOutcome) -> None:
        self._turned = self._turning = False

    def _is_useful(self, goal: SE2) -> bool:
        assert self._grid is not None
        config = self.config.exploration
        reach = config.view_distance + config.frontier_shift
        for cells in frontiers(self._grid, config):
            points = self._grid.frame.to_points(cells)
            if (np.hypot(*(points - (goal.x, goal.y)).T) < reach).any():
                return True
        return False

    def _on_outcome(self, outcome: GoalOutcome) -> None:
        """Note the goal, reached or not, so that it is not tried again."""
        if self._goal is not None and outcome.accepted:
            self._tried.append(self._goal)
        self._goal = None

    def _finish_if_patient(self) -> None:
        if self._idle_since is None:
            self._idle_since = self.now
        elif self.now - self._idle_since >= self.config.patience:
            self.done = True
            self._publish(f"done: looked from {len(self._tried)} places")

    def _publish(self, text: str) -> None:
        self._status.publish(String(data=text))
        self.get_logger().info(text)
