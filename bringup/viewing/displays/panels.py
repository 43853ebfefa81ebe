"""Panels beside the room: pictures, curves and the behavior tree's state."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from PIL import Image as Pillow

from arjuna_core.param import param
from arjuna_core.pixels import pixels
from bringup.viewing.displays.base import Display, Moment
from bringup.viewing.drawing.values import Parts, Picture, Values, Words


class Image(Display):
    """A camera's picture, raw or compressed."""

    types = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
    topic = "camera/image_raw"

    @dataclass(frozen=True)
    class Config:
        widest: int = param(640, "Columns at most.", minimum=16, maximum=4096)

    def take(self, message: Any) -> Parts:
        widest = self.config.widest
        if hasattr(message, "encoding"):
            size = message.height, message.width, message.step
            return {
                "": Picture(pixels=pixels(message.encoding, *size, bytes(message.data), widest))
            }
        data = io.BytesIO(bytes(message.data))
        try:
            with Pillow.open(data, formats=("JPEG", "PNG")) as opened:
                opened.thumbnail((widest, widest))
                shown = np.asarray(opened.convert("RGB"))
        except (OSError, Pillow.DecompressionBombError) as error:
            raise ValueError(f"a picture in '{message.format}' is not read: {error}") from error
        return {"": Picture(pixels=shown)}


class Speed(Display):
    """Odometry's speed over time."""

    types = ("nav_msgs/msg/Odometry",)
    topic = "odom"

    def take(self, message: Any) -> Parts:
        twist = message.twist.twist
        return {
            "": Values(values={"speed [m/s]": twist.linear.x, "turning [rad/s]": twist.angular.z})
        }


class LocalizationQuality(Display):
    """The quality of AMCL's estimate over time."""

    types = ("arjuna_interfaces/msg/LocalizationQuality",)
    topic, latched = "amcl/localization_quality", True
    _quality: float | None = None

    def take(self, message: Any) -> None:
        self._quality = float(message.quality)

    def tick(self, moment: Moment) -> Parts | None:
        return None if self._quality is None else {"": Values(values={"quality": self._quality})}


class DistanceToGoal(Display):
    """The distance that the navigator has left to drive, over time."""

    def tick(self, moment: Moment) -> Parts | None:
        remaining = moment.distance
        return None if remaining is None else {"": Values(values={"distance to go [m]": remaining})}


class BehaviorTree(Display):
    """The nodes of the navigator's tree with their state, the last changed first."""

    types = ("nav2_msgs/msg/BehaviorTreeLog",)
    topic, every = "behavior_tree_log", True
    _MARKS: ClassVar[dict[str, str]] = {"RUNNING": "▶", "SUCCESS": "✔", "FAILURE": "✖", "IDLE": "·"}

    def __init__(self, config: Any, topic: str) -> None:
        super().__init__(config, topic)
        self._states: dict[str, str] = {}

    def take(self, message: Any) -> Parts:
        for event in message.event_log:
            self._states.pop(event.node_name, None)
            self._states[event.node_name] = event.current_status
        running = {name: s for name, s in reversed(self._states.items()) if s == "RUNNING"}
        others = {name: s for name, s in reversed(self._states.items()) if s != "RUNNING"}
        lines = [
            f"{self._MARKS.get(state, '?')} {name}: {state.lower()}"
            for name, state in [*running.items(), *others.items()][:16]
        ]
        return {"": Words(text="\n\n".join(lines))}
