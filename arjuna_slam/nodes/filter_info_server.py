"""costmap_filter_info_server: says what the values of a costmap filter's mask mean."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from nav2_msgs.msg import CostmapFilterInfo

from arjuna_core.config import param
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.ros.node import ManagedNode


@dataclass(frozen=True)
class FilterInfoServerConfig:
    """Parameters of costmap_filter_info_server, by Nav2's names."""

    filter_info_topic: str = param("costmap_filter_info", "Topic of what it says.", read_only=True)
    type: int = param(
        0,
        "Of the filter: 0 keeps out, 1 limits the speed in per cent, 2 in m/s, 3 switches.",
        minimum=0,
        maximum=255,
        read_only=True,
    )
    mask_topic: str = param("filter_mask", "Topic of the mask.", read_only=True)
    base: float = param(0.0, "Added to a value of the mask times the multiplier.", read_only=True)
    multiplier: float = param(1.0, "Of a value of the mask.", read_only=True)


class FilterInfoServerNode(ManagedNode):
    """Publishes, latched, where a mask is and what it means.

    Source: nav2_map_server, CostmapFilterInfoServer.
    """

    Config: ClassVar[type[Any]] = FilterInfoServerConfig
    DEFAULT_NAME = "costmap_filter_info_server"

    def configure(self) -> None:
        """Create the topic."""
        topic = self.config.filter_info_topic
        self._publisher = self.publisher(CostmapFilterInfo, topic, qos.LATCHED)

    def activate(self) -> None:
        """Say it."""
        config: FilterInfoServerConfig = self.config
        self._publisher.publish(
            CostmapFilterInfo(
                header=header("map", self.now),
                type=config.type,
                filter_mask_topic=self.process.absolute(config.mask_topic),
                base=config.base,
                multiplier=config.multiplier,
            )
        )
