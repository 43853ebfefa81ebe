"""What a costmap's filters say to others, and the services that switch them."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any, Protocol

from nav2_msgs.msg import SpeedLimit
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.ros.node import ManagedNode
from arjuna_nav.costmap import LayeredCostmap
from arjuna_nav.costmap.layers.base import absolute
from arjuna_nav.costmap.layers.filters.base import CostmapFilter
from arjuna_nav.costmap.layers.filters.binary import BinaryFilter
from arjuna_nav.costmap.layers.filters.speed import SpeedFilter


class Served(Protocol):
    """Who has the layers, and builds them again when parameters change."""

    layered: LayeredCostmap


class FilterOutput:
    """Publishes speed limits and states, and serves `<filter>/toggle_filter`.

    Args:
        node: The node of the costmap; in its `configure`.
        served: Who has the layers.
    """

    def __init__(self, node: ManagedNode, served: Served) -> None:
        self._node, self._served = node, served
        self._publishers: dict[str, Any] = {}
        for name, layer in served.layered.layers.items():
            if isinstance(layer, SpeedFilter):
                topic = absolute(layer.config.speed_limit_topic)
                self._publishers[name] = node.publisher(SpeedLimit, topic, qos.DEFAULT)
            elif isinstance(layer, BinaryFilter):
                topic = absolute(layer.config.binary_state_topic)
                self._publishers[name] = node.publisher(Bool, topic, qos.DEFAULT)
            if isinstance(layer, CostmapFilter):
                node.serve(SetBool, f"{name}/toggle_filter", partial(self._on_toggle, name))

    def publish(self, layered: LayeredCostmap) -> None:
        """Publish what has changed since the last time."""
        for name, publisher in self._publishers.items():
            layer = layered.layers[name]
            if isinstance(layer, SpeedFilter) and (limit := layer.take_change()) is not None:
                stamp = header(self._node.config.global_frame, self._node.now)
                publisher.publish(
                    SpeedLimit(header=stamp, percentage=limit.percentage, speed_limit=limit.limit)
                )
            elif isinstance(layer, BinaryFilter) and (state := layer.take_change()) is not None:
                publisher.publish(Bool(data=state))

    def _on_toggle(self, name: str, request: Any, response: Any) -> Any:
        """Switch a filter on or off until its parameters change."""
        layer = self._served.layered.layers[name]
        layer.config = replace(layer.config, enabled=request.data)
        self._served.layered.compose_again()
        response.success, response.message = True, "Enabled" if request.data else "Disabled"
        return response
