"""Driving by hand: velocities while a button is held down, and a stop in any case."""

from __future__ import annotations

from rclpy.node import Node

from arjuna_core.ros.velocity import VelocityOutput
from arjuna_core.twist import STILL, Velocity


class HandDrive:
    """Publishes velocities; the topic is advertised when it is first used.

    Args:
        hold: How long one request to drive holds; a button that is held renews it [s, wall].
        stops: Stops that are sent, for a lost one must not leave the robot driving.
    """

    def __init__(self, node: Node, topic: str, hold: float = 0.35, stops: int = 5) -> None:
        self._node = node
        self._topic = topic
        self._hold, self._stops = hold, stops
        self._output: VelocityOutput | None = None
        self._until = 0.0
        self._velocity = STILL
        self._stops_left = 0

    def drive(self, speed: float, turn_rate: float, now: float) -> None:
        """Drive [m/s, rad/s] from a time [s, monotonic] on, for a moment."""
        self._velocity, self._until = Velocity(speed, yaw_rate=turn_rate), now + self._hold
        self._stops_left = self._stops

    def stop(self) -> None:
        """Stand still from now on."""
        self._until, self._stops_left = 0.0, self._stops

    def tick(self, now: float) -> None:
        """Publish what is due at a time [s, monotonic]; called 10 times a second."""
        if now < self._until:
            self._publish(self._velocity)
        elif self._stops_left > 0:
            self._stops_left -= 1
            self._publish(STILL)

    def halt(self) -> None:
        """Publish the stop that is due at once, before nobody ticks any more."""
        if self._stops_left > 0:
            self._stops_left = 0
            self._until = 0.0
            self._publish(STILL)

    def _publish(self, velocity: Velocity) -> None:
        if self._output is None:
            self._output = VelocityOutput(self._node, None, frame="", topic=self._topic)
        self._output.publish(velocity)
