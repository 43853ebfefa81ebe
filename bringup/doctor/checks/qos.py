"""Publishers and subscriptions of one topic that never meet: quality of service and types."""

from __future__ import annotations

from collections.abc import Iterator

from bringup.client.endpoint import Endpoint
from bringup.doctor.snapshot import Finding, Snapshot

RANK = 6
_OTHER_CHECK = {"geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"}


def check(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield the pairs that do not hear each other."""
    for end in snapshot.endpoints:
        for source in [] if end.publishes else snapshot.publishers(end.topic):
            yield from _mismatch(source, end)


def _mismatch(source: Endpoint, end: Endpoint) -> Iterator[Finding]:
    pair = f"{end.node} hears nothing of {source.node} on {end.topic}"
    if source.type != end.type:
        if {source.type, end.type} != _OTHER_CHECK:
            yield Finding(f"{pair}: {source.type} is no {end.type}", "let both use one type")
        return
    if end.reliable and not source.reliable:
        remedy = "let the subscription ask for best effort (qos_profile_sensor_data)"
        yield Finding(f"{pair}: it asks for reliable, best effort is offered", remedy)
    if end.latched and not source.latched:
        remedy = "let the subscription ask for volatile, or the publisher offer transient local"
        yield Finding(f"{pair}: it asks for transient local, volatile is offered", remedy)
