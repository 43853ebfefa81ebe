"""A costmap as the lifecycle node that Nav2's clients know."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import Polygon
from nav2_msgs.srv import (
    ClearCostmapAroundPose,
    ClearCostmapAroundRobot,
    ClearCostmapExceptRegion,
    ClearEntireCostmap,
    GetCost,
    GetCostmap,
)

from arjuna_core.errors import ArjunaError, ConfigError
from arjuna_core.ros import qos
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import Costmap, CostmapConfig, LayeredCostmap
from arjuna_nav.costmap.collision import footprint_cost
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.layers.base import absolute
from arjuna_nav.nodes.costmap.inputs import CostmapInputs
from arjuna_nav.nodes.costmap.messages import costmap_raw_msg, points_from_polygon
from arjuna_nav.nodes.costmap.output import CostmapOutput, FilterOutput
from arjuna_nav.nodes.frames import pose_in, robot_pose

_NOT_DUE = "no update was due yet"


class CostmapServices:
    """Offers Nav2's services, and those that nav2_simple_commander calls by other names.

    They are the node's, in its `configure`; `robot_pose` is in the costmap's frame.
    """

    def __init__(
        self, node: ManagedNode, layered: LayeredCostmap, robot_pose: Callable[[], SE2]
    ) -> None:
        self._node, self._layered, self._robot_pose = node, layered, robot_pose
        name = node.get_name()
        node.serve(ClearEntireCostmap, f"clear_entirely_{name}", self._on_clear_entirely)
        for kind, what, as_client, clear in (
            (ClearCostmapExceptRegion, "except", "except_region", layered.clear_except),
            (ClearCostmapAroundRobot, "around", "around_robot", layered.clear_around),
            (ClearCostmapAroundPose, "around_pose", "around_pose", layered.clear_around),
        ):
            for service in (f"clear_{what}_{name}", f"clear_costmap_{as_client}"):
                node.serve(kind, service, partial(self._on_clear, clear))
        node.serve(GetCostmap, "get_costmap", self._on_get_costmap)
        node.serve(GetCost, f"get_cost_{name}", self._on_get_cost)

    def _on_clear_entirely(self, request: Any, response: Any) -> Any:
        self._layered.clear_entirely()
        return response

    def _on_clear(self, clear: Callable[[SE2, float], None], request: Any, response: Any) -> Any:
        """Clear in or outside a square; the answer has no room for a reason, so the log says it."""
        edge, frame = request.reset_distance, self._node.config.global_frame
        given = hasattr(request, "pose")
        try:
            if not 0.0 <= edge < math.inf:
                raise ConfigError(f"reset_distance {edge} is no length; valid: 0 and more")
            clear(pose_in(self._node, frame, request.pose) if given else self._robot_pose(), edge)
        except ArjunaError as error:
            self._node.get_logger().error(f"nothing cleared: {error}")
        return response

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


class CostmapNode(ManagedNode):
    """Keeps a layered costmap current; the servers of its process read `current`."""

    Config = CostmapConfig
    DEFAULT_NAME = "global_costmap"

    def configure(self) -> None:
        config: CostmapConfig = self.config
        self.layered = LayeredCostmap(config, self.transforms.lookup)
        self._updated_at = -np.inf
        self._problem = "it is not active"
        self._inputs = CostmapInputs(self, self.layered)
        self._output = CostmapOutput(self, self.layered)
        self._filters = FilterOutput(self, self.layered)
        self._warned: set[str] = set()
        self.subscribe(Polygon, "footprint", self._on_footprint, qos.DEFAULT)
        CostmapServices(self, self.layered, self.robot_pose)
        self.every(1.0 / config.update_frequency, self._update)
        if config.publish_frequency > 0.0:
            period = 1.0 / config.publish_frequency
            self.every(period, lambda: self._output.publish(self._updated_at))

    @property
    def scan_topic(self) -> str:
        """The topic of the first of its scans, absolute; empty where it takes none."""
        return next(map(absolute, self.config.scan_topics.values()), "")

    def current(self, timeout: float) -> Costmap | None:
        """Return the costs, or None if they were not updated within a timeout [s].

        A costmap slower than that is current until its next update is overdue, as Nav2's.
        """
        if self._problem == _NOT_DUE:
            timeout = max(timeout, 1.5 / self.config.update_frequency)
        if not self.active or self.now - self._updated_at > timeout:
            return None
        return self.layered.costmap

    def why_not_current(self) -> str:
        """Say since when the costs were not updated, and why."""
        problem = self._problem if self.active else "it is not active"
        age = self.now - self._updated_at if self.active else np.inf
        since = f"was last updated {age:.2f} s ago" if np.isfinite(age) else "was never updated"
        return f"{self.get_name()} {since}, it is {self.now:.2f} s: {problem}"

    def trouble(self) -> str:
        overdue = (
            # Three periods without an update are too many.
            self.active and self.now - self._updated_at > 3.0 / self.config.update_frequency
        )
        return self.why_not_current() if overdue else ""

    def robot_pose(self) -> SE2:
        """Return the robot's pose in the costmap's frame.

        Raises:
            TransformError: It is not known, or older than `transform_tolerance`.
        """
        config = self.config
        return robot_pose(
            self, config.global_frame, config.robot_base_frame, config.transform_tolerance
        )

    def activate(self) -> None:
        self._inputs.clear()
        self.layered.group.start(self.now)
        self._updated_at = -np.inf
        self._output.reset()
        self._problem = _NOT_DUE
        self._pose_due = self.now + (self.config.initial_transform_timeout or np.inf)

    def on_time_jump(self) -> None:
        if self.active:
            self.activate()
            self.layered.clear_entirely()

    def on_config(self, config: CostmapConfig) -> None:
        self.layered.reconfigure(config)
        self._inputs.hand_over_again()

    def _on_footprint(self, message: Any) -> None:
        try:
            padding = self.config.footprint_padding
            corners = points_from_polygon(message)
            footprint = Footprint.polygon(corners, padding).driven_at(self.config.axle)
        except ConfigError as error:
            self.get_logger().error(f"footprint ignored: {error}")
        else:
            self.layered.set_footprint(footprint)

    def _update(self) -> None:
        self._inputs.hand_over()
        problem = self.layered.group.missing()
        try:
            pose = self.robot_pose()
            self._pose_due = np.inf
        except TransformError as error:
            problem = problem or str(error)
            if self.now > self._pose_due:
                self.get_logger().error(f"not active any more, as Nav2: {error}")
                self.trigger_deactivate()
        if problem:
            self._problem = problem
            self.layered.group.start(self.now)  # what has come is lost
            return
        self.layered.update(pose, self.now)
        self._filters.publish()
        warnings = set(self.layered.warnings())
        for warning in sorted(warnings - self._warned):
            self.get_logger().warning(warning)
        self._warned = warnings
        self._problem = self.layered.group.problem(self.now)
        if not self._problem:
            self._updated_at, self._problem = self.now, _NOT_DUE
