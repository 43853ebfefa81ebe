"""Messages that are numbers or words over time: curves, states, logs."""

from __future__ import annotations

import math
from typing import Any

import rerun as rr

from bringup.viewing.drawing.frames import Frames
from bringup.viewing.drawing.messages import pose3
from bringup.viewing.rerun.stream import Stream

SPEED, TURN, ERROR, GOAL = "curves/speed", "curves/turn_rate", "curves/error", "curves/goal"
# of action_msgs/GoalStatus and rcl_interfaces/Log
_STATES = ("unknown", "accepted", "executing", "canceling", "succeeded", "canceled", "aborted")
_LEVELS = {10: "DEBUG", 20: "INFO", 30: "WARN", 40: "ERROR", 50: "CRITICAL"}


def twist(stream: Stream, topic: str, message: Any) -> None:
    """Draw speed [m/s] and turn rate [rad/s]."""
    stream.scalar(f"{SPEED}{topic}", message.linear.x)
    stream.scalar(f"{TURN}{topic}", message.angular.z)


def quality(stream: Stream, topic: str, message: Any) -> None:
    """Draw the quality of AMCL's estimate (0..1)."""
    stream.scalar(f"{ERROR}{topic}", message.quality)


def feedback(stream: Stream, topic: str, message: Any) -> None:
    """Draw the distance to the goal [m] and the number of recoveries."""
    stream.scalar(f"{GOAL}/distance_remaining", message.feedback.distance_remaining)
    stream.scalar(f"{GOAL}/recoveries", message.feedback.number_of_recoveries)


def errors(stream: Stream, frames: Frames, truth: Any) -> None:
    """Draw the error of the robot's belief [m] and [rad].

    Args:
        frames: Its belief, where there is a map.
        truth: The simulator's odometry without errors, in the world's frame.
    """
    believed = frames.pose(truth.child_frame_id) if frames.fixed == "map" else None
    if believed is None:
        return
    true = pose3(truth.pose.pose)
    stream.scalar(f"{ERROR}/position", math.dist(believed.position[:2], true.position[:2]))
    turned = believed.rpy()[2] - true.rpy()[2]
    stream.scalar(f"{ERROR}/heading", abs(math.remainder(turned, 2.0 * math.pi)))


def goal_status(stream: Stream, topic: str, message: Any) -> None:
    """Show the state of an action's newest goal as a lane of the state timeline."""
    if message.status_list:
        stamps = [status.goal_info.stamp for status in message.status_list]
        newest = max(range(len(stamps)), key=lambda i: (stamps[i].sec, stamps[i].nanosec))
        code = message.status_list[newest].status
        state = _STATES[code] if 0 <= code < len(_STATES) else str(code)
        action = topic.removesuffix("/_action/status")
        stream.log(f"states{action}", rr.StateChange(state=state))


def log(stream: Stream, topic: str, message: Any) -> None:
    """Show a line of a node's log."""
    level = _LEVELS.get(message.level, "INFO")
    stream.log(f"logs/{message.name or 'unnamed'}", rr.TextLog(message.msg, level=level))


def text(stream: Stream, topic: str, message: Any) -> None:
    """Show a text, such as the explorer's status."""
    if len(message.data) < 1000:  # no description of a robot under another name
        stream.log(f"logs{topic}", rr.TextLog(message.data, level="INFO"))
