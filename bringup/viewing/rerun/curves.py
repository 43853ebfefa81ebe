"""Messages that are numbers over time, as curves."""

from __future__ import annotations

import math
from typing import Any

from arjuna_core.pose3 import Pose3
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.rerun.stream import Stream

SPEED, TURN, ERROR, GOAL = "curves/speed", "curves/turn_rate", "curves/error", "curves/goal"


def twist(stream: Stream, topic: str, message: Any) -> None:
    """Draw speed [m/s] and turn rate [rad/s]."""
    stream.scalar(f"{SPEED}{topic}", message.linear.x)
    stream.scalar(f"{TURN}{topic}", message.angular.z)


def twist_stamped(stream: Stream, topic: str, message: Any) -> None:
    """Draw speed and turn rate of a stamped command."""
    twist(stream, topic, message.twist)


def odometry(stream: Stream, topic: str, message: Any) -> None:
    """Draw the measured speed and turn rate."""
    twist(stream, topic, message.twist.twist)


def quality(stream: Stream, topic: str, message: Any) -> None:
    """Draw how sure AMCL is (0..1)."""
    stream.scalar(f"{ERROR}{topic}", message.quality)


def feedback(stream: Stream, topic: str, message: Any) -> None:
    """Draw how far it is to the goal [m] and how often the robot had to recover."""
    stream.scalar(f"{GOAL}/distance_remaining", message.feedback.distance_remaining)
    stream.scalar(f"{GOAL}/recoveries", message.feedback.number_of_recoveries)


def errors(stream: Stream, frames: Frames, truth: Any) -> None:
    """Draw how far the robot is from where it believes to be: [m] and [rad].

    Args:
        stream: Where to.
        frames: What it believes, where there is a map.
        truth: The simulator's odometry without errors, in the world's frame.
    """
    if frames.fixed != "map":
        return
    belief = frames.pose(truth.child_frame_id)
    if belief is None:
        return
    place, turn = truth.pose.pose.position, truth.pose.pose.orientation
    true = Pose3((place.x, place.y, place.z), (turn.w, turn.x, turn.y, turn.z))
    apart = math.hypot(belief.position[0] - place.x, belief.position[1] - place.y)
    stream.scalar(f"{ERROR}/position", apart)
    turned = belief.rpy()[2] - true.rpy()[2]
    stream.scalar(f"{ERROR}/heading", abs(math.remainder(turned, 2.0 * math.pi)))
