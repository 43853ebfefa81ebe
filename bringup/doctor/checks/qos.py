"""Publishers and subscriptions of one topic that never meet: quality of service and types."""

from __future__ import annotations

from bringup.client.endpoint import Endpoint
from bringup.doctor.finding import Finding
from bringup.doctor.snapshot import Snapshot

_OTHER_CHECK = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")


def check(snapshot: Snapshot) -> list[Finding]:
    """Return who does not hear whom."""
    found = []
    for end in snapshot.endpoints:
        if not end.publishes:
            for source in snapshot.publishers(end.topic):
                found += _mismatch(source, end)
    return found


def _mismatch(source: Endpoint, end: Endpoint) -> list[Finding]:
    pair = f"{end.node} hears nothing of {source.node} on {end.topic}"
    if source.type != end.type:
        if {source.type, end.type} == set(_OTHER_CHECK):
            return []
        return [Finding(f"{pair}: {source.type} is no {end.type}", "let both use one type")]
    found = []
    if end.reliable and not source.reliable:
        cure = "let the subscription ask for best effort (qos_profile_sensor_data)"
        found.append(Finding(f"{pair}: it asks for reliable, best effort is offered", cure))
    if end.latched and not source.latched:
        cure = "let the subscription ask for volatile, or the publisher offer transient local"
        found.append(Finding(f"{pair}: it asks for transient local, volatile is offered", cure))
    return found
