"""The services of a costmap: to clear it and to ask for costs."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from nav2_msgs.srv import (
    ClearCostmapAroundPose,
    ClearCostmapAroundRobot,
    ClearCostmapExceptRegion,
    ClearEntireCostmap,
    GetCost,
    GetCostmap,
)

from arjuna_core.errors import ArjunaError, ConfigError
from arjuna_core.ros.node import ManagedNode
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import LayeredCostmap
from arjuna_nav.costmap.collision import footprint_cost
from arjuna_nav.nodes.costmap.messages import costmap_raw_msg
from arjuna_nav.nodes.frames import pose_in


class CostmapServices:
    """Offers Nav2's services, and those that nav2_simple_commander calls by other names.

    Args:
        node: The node that serves; in its `configure`.
        robot_pose: Returns the robot's pose in the costmap's frame.
    """

    def __init__(
        self, node: ManagedNode, layered: LayeredCostmap, robot_pose: Callable[[], SE2]
    ) -> None:
        self._node, self._layered, self._robot_pose = node, layered, robot_pose
        name = node.get_name()
        node.serve(ClearEntireCostmap, f"clear_entirely_{name}", self._on_clear_entirely)
        for alias in (f"clear_except_{name}", "clear_costmap_except_region"):
            node.serve(ClearCostmapExceptRegion, alias, self._on_clear_except)
        for alias in (f"clear_around_{name}", "clear_costmap_around_robot"):
            node.serve(ClearCostmapAroundRobot, alias, self._on_clear_around)
        for alias in (f"clear_around_pose_{name}", "clear_costmap_around_pose"):
            node.serve(ClearCostmapAroundPose, alias, self._on_clear_around_pose)
        node.serve(GetCostmap, "get_costmap", self._on_get_costmap)
        node.serve(GetCost, f"get_cost_{name}", self._on_get_cost)

    def _on_clear_entirely(self, request: Any, response: Any) -> Any:
        self._layered.clear_entirely()
        return response

    def _on_clear_except(self, request: Any, response: Any) -> Any:
        self._clear(self._layered.clear_except, request, self._robot_pose)
        return response

    def _on_clear_around(self, request: Any, response: Any) -> Any:
        self._clear(self._layered.clear_around, request, self._robot_pose)
        return response

    def _on_clear_around_pose(self, request: Any, response: Any) -> Any:
        def pose() -> SE2:
            return pose_in(self._node, self._node.config.global_frame, request.pose)

        self._clear(self._layered.clear_around, request, pose)
        return response

    def _clear(
        self, clear: Callable[[SE2, float], None], request: Any, pose: Callable[[], SE2]
    ) -> None:
        """Clear in or outside a square; the answer has no room for a reason, so the log says it."""
        edge = request.reset_distance
        try:
            if not 0.0 <= edge < math.inf:
                raise ConfigError(f"reset_distance {edge} is no length; valid: 0 and more")
            clear(pose(), edge)
        except ArjunaError as error:
            self._node.get_logger().error(f"nothing cleared: {error}")

    def _on_get_costmap(self, request: Any, response: Any) -> Any:
        costmap, frame_id = self._layered.costmap, self._node.config.global_frame
        response.map = costmap_raw_msg(costmap, frame_id, self._node.now)
        return response

    def _on_get_cost(self, request: Any, response: Any) -> Any:
        """Answer with the cost at a point, or with the worst below the outline there."""
        layered, pose = self._layered, SE2(request.x, request.y, request.theta)
        # Nav2 answers -1 outside the costmap.
        response.cost = -1.0
        if not all(map(math.isfinite, (pose.x, pose.y, pose.theta))):
            return response
        if request.use_footprint:
            response.cost = float(footprint_cost(layered.costmap, layered.footprint, pose))
        elif (cost := layered.costmap.cost_at(pose.x, pose.y)) is not None:
            response.cost = float(cost)
        return response
