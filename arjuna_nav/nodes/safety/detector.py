"""Node collision_detector: says in which zones something is, and leaves velocities alone."""

from __future__ import annotations

from dataclasses import dataclass

from nav2_msgs.msg import CollisionDetectorState

from arjuna_core.config import fixed
from arjuna_core.ros import qos
from arjuna_core.ros.node import ManagedNode
from arjuna_core.twist import STILL
from arjuna_nav.nodes.safety.watch import Watch, WatchConfig
from arjuna_nav.safety.sight import Sight


@dataclass(frozen=True)
class CollisionDetectorConfig(WatchConfig):
    """Parameters of the node `collision_detector`, by Nav2's names."""

    frequency: float = fixed(10.0, "States a second.", unit="Hz", minimum=0.1)


class CollisionDetectorNode(ManagedNode):
    """Publishes which zones hold as many points as count.

    Source: nav2_collision_monitor, CollisionDetector::process. A source that is silent is left out.
    """

    Config = CollisionDetectorConfig
    DEFAULT_NAME = "collision_detector"

    def configure(self) -> None:
        self._watch = Watch(self)
        self._state = self.publisher(CollisionDetectorState, "collision_detector_state", qos.LATEST)
        self.every(1.0 / self.config.frequency, self._publish)

    def activate(self) -> None:
        self._watch.reset()

    def on_time_jump(self) -> None:
        if self.active:
            self.activate()

    def on_config(self, config: CollisionDetectorConfig) -> None:
        self._watch.reconfigure(config)

    def trouble(self) -> str:
        return self._watch.silent() if self.active else ""

    def _publish(self) -> None:
        watch = self._watch
        sight, _ = watch.look(wait_for_all=False) or (Sight.joined([]), 0.0)
        found = watch.monitor.holding(STILL, sight, watch.footprint())
        state = CollisionDetectorState(
            polygons=list(found), detections=[bool(each) for each in found.values()]
        )
        self._state.publish(state)
        watch.publish(STILL)
