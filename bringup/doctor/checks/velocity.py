"""Velocity commands that do not reach the wheels."""

from __future__ import annotations

from collections.abc import Iterator

from arjuna_core.ros.health.rules import is_drive
from bringup.doctor.snapshot import Finding, Snapshot

RANK = 11
_TWIST, _STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"


def check(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield faults that keep the robot from moving."""
    for topic in sorted({end.topic for end in snapshot.endpoints if "cmd_vel" in end.topic}):
        found = snapshot.subscribers(topic)
        listeners = [end for end in found if is_drive(snapshot.published(end.node))]
        wanted = {end.type for end in listeners}
        for end in snapshot.publishers(topic):
            if wanted and end.type not in wanted and {end.type, *wanted} <= {_TWIST, _STAMPED}:
                what = (
                    f"{end.node} sends {_short(end.type)} on {topic}, "
                    f"{listeners[0].node} listens for {_short(listeners[0].type)}"
                )
                stamped = str(_STAMPED in wanted).lower()
                remedy = f"set enable_stamped_cmd_vel: {stamped} there (teleop: stamped)"
                yield Finding(what, remedy)
        if topic == "/cmd_vel" and not listeners:
            senders = ", ".join(end.node for end in snapshot.publishers(topic))
            what = f"{senders} send /cmd_vel and no robot listens"
            yield Finding(what, "python -m bringup sim, or remap to the robot's topic")


def _short(message_type: str) -> str:
    return message_type.rpartition("/")[2]
