"""The costmap and footprint that a server works on, by the topics that Nav2's servers take."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from typing import Any

import numpy as np
from geometry_msgs.msg import PolygonStamped
from nav2_msgs.msg import Costmap as CostmapMsg
from nav2_msgs.msg import CostmapUpdate

from arjuna_core.errors import ConfigError
from arjuna_core.grid import GridFrame, replace_cells
from arjuna_core.ros import qos
from arjuna_core.ros.convert import se2_from_pose, seconds
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.nodes.costmap.messages import points_from_polygon
from arjuna_nav.nodes.costmap.node import CostmapNode
from arjuna_nav.nodes.frames import robot_pose

_COSTS, _OUTLINE = "costmap_raw", "published_footprint"  # as every costmap names them


class CostmapReader:
    """Reads a costmap and a footprint, each published by any node.

    What a costmap of the same process publishes is read from it directly, as new as its last
    update and without a copy; anything else comes as messages.

    Args:
        node: The server; in its `configure`.
        costmap_topic: Of nav2_msgs/Costmap; its updates come on the same name with `_updates`.
        footprint_topic: Of the robot's outline, where the robot is at its stamp; empty for none.
        base_frame: The robot's frame; empty: that of a costmap of the process, else base_link.
        tolerance: How old the transforms used may be [s].
    """

    def __init__(
        self,
        node: ManagedNode,
        costmap_topic: str,
        footprint_topic: str,
        base_frame: str,
        tolerance: float,
    ) -> None:
        self._node, self._tolerance = node, tolerance
        near, shape = (
            costmap_in_process(node, topic, own) if topic else None
            for topic, own in ((costmap_topic, _COSTS), (footprint_topic, _OUTLINE))
        )
        self._costs: CostmapNode | _CostsByTopic = near or _CostsByTopic(node, costmap_topic)
        self.base_frame = base_frame or (near.config.robot_base_frame if near else "base_link")
        by_topic = footprint_topic and shape is None
        outline = None if not by_topic else _OutlineByTopic(node, footprint_topic, self.base_frame)
        self._shape, self._outline = shape, outline

    @property
    def active(self) -> bool:
        """True once there are costs."""
        return self._costs.active

    @property
    def frame(self) -> str:
        """The frame of the costs; empty where none have come by topic."""
        costs = self._costs
        return costs.frame_id if isinstance(costs, _CostsByTopic) else costs.config.global_frame

    def why_not_current(self) -> str:
        """Say why there are no costs, or only old ones."""
        return self._costs.why_not_current()

    def current(self, timeout: float, frame: str = "") -> Costmap | None:
        """Return the costs in a frame, their own if empty; None if older than a timeout [s].

        Raises:
            TransformError: Where they lie in the frame is not known, or not lately.
        """
        costmap = self._costs.current(timeout)
        if costmap is None or frame in ("", self.frame):
            return costmap
        lag = self._tolerance
        return costmap.seen_from(robot_pose(self._node, frame, self.frame, lag, any_clock=True))

    def footprint(self) -> Footprint:
        """Return the robot's outline.

        Raises:
            TransformError: None has come, or where the robot was then is not known.
        """
        if self._shape is not None:
            return self._shape.layered.footprint
        assert self._outline is not None
        return self._outline.footprint(self._tolerance)


def costmap_in_process(node: ManagedNode, topic: str, own: str = _COSTS) -> CostmapNode | None:
    """Return the costmap of the node's process that publishes a topic by a name of its own."""
    name = node.full_topic(topic)
    costmaps = (each for each in node.process.nodes if isinstance(each, CostmapNode))
    return next((each for each in costmaps if each.resolve_topic_name(own) == name), None)


class _CostsByTopic:
    """The costs that come by topic.

    A publisher with nothing new sends no costs; its footprint, on the topic beside them as Nav2's
    costmaps have it, shows that it lives. One that has sent both once or twice, latched, is not
    known to repeat anything, and so never silent.
    """

    def __init__(self, node: ManagedNode, topic: str) -> None:
        self._node, self._topic = node, topic
        self._costmap: Costmap | None = None
        self._rhythms = _Rhythm(), _Rhythm()  # of the costs and of the footprint
        self.frame_id = ""
        beside = f"{topic.removesuffix(_COSTS)}{_OUTLINE}"
        for kind, name, take, profile in (
            (CostmapMsg, topic, self._on_costs, qos.LATCHED),
            (CostmapUpdate, f"{topic}_updates", self._on_update, qos.LATCHED),
            (PolygonStamped, beside, self._on_outline, qos.DEFAULT),
        ):
            node.subscribe(kind, name, take, profile, while_inactive=True)

    @property
    def active(self) -> bool:
        return self._costmap is not None

    def current(self, timeout: float) -> Costmap | None:
        """Return the costs unless the publisher is silent for the timeout and 2.5 periods [s]."""
        now = self._node.now
        late = [rhythm.late(now, timeout) for rhythm in self._rhythms if rhythm.known]
        return None if late and all(late) else self._costmap

    def why_not_current(self) -> str:
        if self._costmap is None:
            return f"no costmap has come on '{self._topic}'"
        now = self._node.now
        age = now - max(rhythm.last for rhythm in self._rhythms)
        return f"nothing has come on '{self._topic}' for {age:.2f} s, it is {now:.2f} s"

    def _on_costs(self, message: Any) -> None:
        meta, costs = message.metadata, np.array(message.data, dtype=np.uint8)
        frame = GridFrame(meta.resolution, meta.size_x, meta.size_y, se2_from_pose(meta.origin))
        self.frame_id = message.header.frame_id.lstrip("/")
        self._costmap = Costmap(frame, costs.reshape(frame.shape), seconds(meta.update_time))
        self._rhythms[0].take(self._node.now)

    def _on_update(self, message: Any) -> None:
        costmap, size = self._costmap, (message.size_x, message.size_y)
        if costmap is None or message.header.frame_id.lstrip("/") != self.frame_id:
            return
        try:
            replace_cells(costmap.data, message.x, message.y, *size, message.data)
        except ValueError as error:
            self._node.get_logger().error(f"{self._topic}_updates ignored: {error}")
            return
        self._costmap = replace(costmap, stamp=seconds(message.header.stamp))
        self._rhythms[0].take(self._node.now)

    def _on_outline(self, message: Any) -> None:
        self._rhythms[1].take(self._node.now)


class _Rhythm:
    """The period of a topic: the shortest of the last five intervals, known from the second on."""

    def __init__(self) -> None:
        self.last = -math.inf
        self._intervals: deque[float] = deque(maxlen=5)

    @property
    def known(self) -> bool:
        return len(self._intervals) > 1

    def take(self, now: float) -> None:
        if (past := now - self.last) > 0.0:
            if math.isfinite(past):
                self._intervals.append(past)
            self.last = now

    def late(self, now: float, timeout: float) -> bool:
        """Return whether nothing came for the timeout [s] and 2.5 periods."""
        return now - self.last > max(timeout, 2.5 * min(self._intervals))


class _OutlineByTopic:
    """The outline that comes by topic, in a fixed frame where the robot was at its stamp."""

    def __init__(self, node: ManagedNode, topic: str, base: str) -> None:
        self._node, self._topic, self._base = node, topic, base
        self._message: Any | None = None
        self._read: tuple[Any, Footprint] | None = None
        node.subscribe(PolygonStamped, topic, self._take, qos.DEFAULT, while_inactive=True)

    def _take(self, message: Any) -> None:
        self._message = message

    def footprint(self, tolerance: float) -> Footprint:
        message = self._message
        if message is None:
            raise TransformError(f"no footprint has come on '{self._topic}'")
        if self._read is None or self._read[0] is not message:
            points = points_from_polygon(message.polygon)
            T_frame_base = self._pose(message.header, tolerance)
            try:
                footprint = Footprint.polygon(T_frame_base.inverse().apply(points))
            except ConfigError as error:
                raise TransformError(f"{self._topic}: {error}") from error
            self._read = message, footprint
        return self._read[1]

    def _pose(self, header: Any, tolerance: float) -> SE2:
        """Return where the robot was at a stamp, or lately where that is just to come."""
        stamp, frame = seconds(header.stamp), header.frame_id.lstrip("/")
        then = self._node.transforms.try_lookup(frame, self._base, stamp)
        if then is not None:
            return then
        return robot_pose(self._node, frame, self._base, tolerance, any_clock=True)
