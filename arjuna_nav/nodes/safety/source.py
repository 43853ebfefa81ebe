"""A topic that a collision monitor sees by, and when it is too old."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.ros import qos
from arjuna_core.ros.convert import seconds
from arjuna_core.se2 import SE2
from arjuna_nav.nodes.safety.frames import WatchFrames

_INTERVALS = 5  # between messages of which the shortest is the sensor's period
_UNKNOWN_INTERVAL = 0.4  # [s] before two messages have come
_PERIODS = 2.5  # of the sensor, that a message may be old
_SLOWS = 0.4  # of that time, in which the robot slows down to a stop


class Sight(NamedTuple):
    """What a source sees from where the robot is now.

    Attributes:
        points: `(N, 2) float64` in the base frame [m].
        motions: Their velocities over ground, `(N, 2)` in the base frame [m/s].
        speeds: At which each may turn to the robot, `(N,)` [m/s].
    """

    points: NDArray[np.float64]
    motions: NDArray[np.float64]
    speeds: NDArray[np.float64]

    @staticmethod
    def still(points: NDArray[np.float64]) -> Sight:
        """Return points that do not move."""
        return Sight(points, np.zeros((len(points), 2)), np.zeros(len(points)))


@dataclass(frozen=True)
class SourceConfig:
    """One source, by Nav2's names."""

    topic: str = param("scan", "Its topic; empty: the robot's scan.", read_only=True)
    enabled: bool = param(True, "Whether it counts.")
    source_timeout: float = param(
        -1.0, "How old a message may be; 0: any age; below 0: the node's.", unit="s", minimum=-1.0
    )


class Source:
    """A topic and what its newest message says.

    Args:
        config: Its parameters.
        frames: Where it is read.
        timeout: How old a message may be [s]; 0 for any age.
        brakes: Whether the robot slows down before that time is over, and a slow sensor has longer.

    Attributes:
        config: Its parameters.
        message: The newest; None before the first.
        tracks: Whether what moves is to be told from what stands.
    """

    Config: ClassVar[type[Any]] = SourceConfig
    message_type: ClassVar[Any]

    def __init__(self, config: Any, frames: WatchFrames, timeout: float, brakes: bool) -> None:
        self.config = config
        self.tracks = False
        self._frames, self._timeout, self._brakes = frames, timeout, brakes
        self.reset()

    def subscribe(self, topic: str) -> None:
        """Listen; in the node's `configure`."""
        self._frames.node.subscribe(self.message_type, topic, self.take, qos.SENSOR_SUBSCRIPTION)

    def reset(self) -> None:
        """Forget what was seen."""
        self.message: Any | None = None
        self._intervals: deque[float] = deque(maxlen=_INTERVALS)
        self._heard = 0.0

    def take(self, message: Any) -> None:
        """Take the newest message."""
        stamp, before = seconds(message.header.stamp), -math.inf
        if self.message is not None:
            before = seconds(self.message.header.stamp)
            self._intervals.append(stamp - before)
        if stamp > before:
            self._heard = self._frames.node.now
        self.message = message

    @property
    def timeout(self) -> float:
        """How old a message may be [s]; a sensor that is slow is not taken for dead if it brakes.

        0 for any age.
        """
        own = float(self.config.source_timeout)
        timeout = self._timeout if own < 0.0 else own
        if not self._brakes or timeout == 0.0:
            return timeout
        return max(timeout, _PERIODS * min(self._intervals, default=_UNKNOWN_INTERVAL))

    def age(self) -> float:
        """Return how old the newest message is [s], inf where there is none."""
        if self.message is None:
            return math.inf
        return self._frames.node.now - seconds(self.message.header.stamp)

    def trust(self) -> float:
        """Return which share of its speed the robot may keep: 0 where the source is silent.

        Where it brakes, by when the last new message came, not by its stamp: that is of a scan's
        first ray, a period before the scan is whole.
        """
        timeout = self.timeout
        if timeout == 0.0:
            return 1.0
        if self.age() > timeout:
            return 0.0
        if not self._brakes:
            return 1.0
        silent = self._frames.node.now - self._heard
        return min((timeout - silent) / max(_SLOWS * timeout, 1e-3), 1.0)

    def sight(self) -> Sight | None:
        """Return what it sees, None where its message says nothing valid.

        Raises:
            TransformError: Where the sensor or the robot is, is not known.
        """
        if self.message is None:
            return None
        points = self._points(self.message)
        if points is None:
            return None
        return Sight.still(self._frames.since(seconds(self.message.header.stamp)).apply(points))

    def _points(self, message: Any) -> NDArray[np.float64] | None:
        """Return what a message says, `(N, 2) float64` in the base frame at its stamp [m]."""
        raise NotImplementedError

    def _mount(self, message: Any) -> SE2:
        frames, frame = self._frames, message.header.frame_id.lstrip("/")
        return frames.node.transforms.lookup(frames.base, frame)
