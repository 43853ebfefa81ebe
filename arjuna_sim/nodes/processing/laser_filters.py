"""scan_to_scan_filter_chain: a scan through the filters of laser_filters."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from typing import Any

import numpy as np
from sensor_msgs.msg import LaserScan

from arjuna_core.config import NoParameters, duration_param, fixed, param
from arjuna_core.plugins import with_configs
from arjuna_core.pose3 import Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, seconds
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError
from arjuna_sim.nodes.mounted_frames import MountedFrames
from arjuna_sim.processing.scan_filters import FILTERS
from arjuna_sim.processing.sweep import Sweep

_FILTER = re.compile(r"filter\d+")


@dataclass(frozen=True)
class FilterConfig:
    """Parameters of one filter of a chain; those of its class stand below `params`."""

    name: str = fixed("", "Its name.")
    type: str = fixed("", "Its class.", choices=tuple(FILTERS))


@dataclass(frozen=True)
class ChainConfig:
    """Parameters of `scan_to_scan_filter_chain`; `filter1`, `filter2`, ... are its filters."""

    tf_message_filter_target_frame: str = fixed(
        "", "Frame without whose transform no scan passes; empty for none."
    )
    tf_message_filter_tolerance: float = duration_param(
        0.03, "How long it may come later; the newest is taken."
    )
    lazy_subscription: bool = param(False, "Whether scans are filtered for listeners alone.")

    @classmethod
    def config_for(cls, values: Mapping[str, Any]) -> type[ChainConfig]:
        """Return the class with the filters that values name."""
        names = {key.partition(".")[0] for key in values}
        found = sorted(filter(_FILTER.fullmatch, names), key=lambda name: int(name[6:]))
        parts = [(name, _filter_config(str(values.get(f"{name}.type", "")))) for name in found]
        return with_configs(cls, tuple(parts))

    def filters(self) -> list[Any]:
        """Return the filters in their order."""
        return [getattr(self, f.name).params for f in fields(self) if _FILTER.fullmatch(f.name)]


@cache
def _filter_config(kind: str) -> Any:
    return with_configs(FilterConfig, (("params", FILTERS.get(kind, NoParameters)),))


class ScanFilterChainNode(ManagedNode):
    """Publishes the scans of `scan` on `scan_filtered`."""

    Config = ChainConfig
    DEFAULT_NAME = "scan_to_scan_filter_chain"

    def configure(self) -> None:
        """Create the topics."""
        self._frames = MountedFrames(self)
        self._memories: list[dict[str, Any]] = [{} for _ in self.config.filters()]
        self._out = self.publisher(LaserScan, "scan_filtered", qos.SENSOR_PUBLISHER)
        self.subscribe(LaserScan, "scan", self._on_scan, qos.SENSOR_SUBSCRIPTION)

    def _on_scan(self, message: Any) -> None:
        if self.config.lazy_subscription and not self._out.get_subscription_count():
            return
        frame = message.header.frame_id

        def mounted(target: str) -> Pose3:
            return self._frames.mounted(target, frame)

        sweep = Sweep(
            np.asarray(message.ranges, np.float64),
            np.asarray(message.intensities, np.float64),
            message.angle_min,
            message.angle_increment,
            message.range_min,
            message.range_max,
        )
        try:
            if needed := self.config.tf_message_filter_target_frame:
                mounted(needed)
            for one, memory in zip(self.config.filters(), self._memories, strict=True):
                sweep = one.apply(sweep, mounted, memory)
        except TransformError as error:
            self._frames.warn("", frame, error)
            return
        self._out.publish(_message(message, sweep))


def _message(given: Any, sweep: Sweep) -> LaserScan:
    """Return a sweep as the message that it was, otherwise unchanged."""
    last = sweep.angle_min + sweep.angle_increment * max(0, len(sweep.ranges) - 1)
    found = LaserScan(
        header=header(
            given.header.frame_id, seconds(given.header.stamp) + sweep.first * given.time_increment
        ),
        angle_min=sweep.angle_min,
        angle_max=last if sweep.first or len(sweep.ranges) < len(given.ranges) else given.angle_max,
        angle_increment=given.angle_increment,
        time_increment=given.time_increment,
        scan_time=given.scan_time,
        range_min=given.range_min,
        range_max=given.range_max,
    )
    found.ranges = sweep.ranges.astype(np.float32)
    found.intensities = sweep.intensities.astype(np.float32)
    return found
