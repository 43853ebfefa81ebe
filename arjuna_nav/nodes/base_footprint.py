"""Node base_footprint_publisher: the pose of a robot in space, on the ground."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tf2_msgs.msg import TFMessage

from arjuna_core.config import fixed
from arjuna_core.ros import qos
from arjuna_core.ros.convert import se2_from_transform, seconds, transform_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import transforms_msg


@dataclass(frozen=True)
class BaseFootprintPublisherConfig:
    """Parameters of base_footprint_publisher, by Nav2's names."""

    base_link_frame: str = fixed("base_link", "Frame of the robot in space.")
    base_footprint_frame: str = fixed("base_footprint", "Frame on the ground.")


class BaseFootprintPublisherNode(ManagedNode):
    """Publishes each transform of the robot again, without height, roll and pitch.

    Source: nav2_util, BaseFootprintPublisher.
    """

    Config = BaseFootprintPublisherConfig
    DEFAULT_NAME = "base_footprint_publisher"

    def configure(self) -> None:
        self._publisher = self.publisher(TFMessage, "/tf", qos.TF)
        self.subscribe(TFMessage, "/tf", self._on_transforms, qos.TF)

    def _on_transforms(self, message: Any) -> None:
        config = self.config
        for item in message.transforms:
            if item.child_frame_id.lstrip("/") == config.base_link_frame:
                parent, stamp = item.header.frame_id.lstrip("/"), seconds(item.header.stamp)
                pose = se2_from_transform(item.transform)
                level = transform_msg(pose, parent, config.base_footprint_frame, stamp)
                self._publisher.publish(transforms_msg(level))
