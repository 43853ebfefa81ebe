"""Topics that come too rarely, or not at all."""

from __future__ import annotations

from collections.abc import Iterator

from bringup.client.endpoint import Endpoint
from bringup.doctor.snapshot import Finding, Snapshot

RANK = 7
LEAST = {"/scan": 5.0, "/odom": 10.0, "/imu/data": 20.0, "/joint_states": 10.0, "/tf": 10.0}
"""Least rate that mapping and navigation can work with, of the robot's time [Hz]."""
LEAST_OF_TYPE = {"sensor_msgs/msg/LaserScan": LEAST["/scan"]}
"""The same for topics of any name."""


def check(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield the topics that are too slow for the stack."""
    passed = snapshot.duration * snapshot.pace
    for topic, count in snapshot.counts.items() if passed > 0.0 else ():
        senders = snapshot.publishers(topic)
        least = LEAST.get(topic, LEAST_OF_TYPE.get(senders[0].type, 0.0) if senders else 0.0)
        rate = count / passed
        if not senders or rate >= least:
            continue
        what = f"{topic} of {senders[0].node} comes at {rate:.1f} Hz, {least:g} are needed"
        if count == 0:
            who = ", ".join(f"{end.node} ({_quality(end)})" for end in senders)
            what = f"nothing comes on {topic}, which {who} publishes"
        yield Finding(what, "see the sensor's lines and rate; top says who has no time")


def _quality(end: Endpoint) -> str:
    durability = "transient local" if end.latched else "volatile"
    return f"{'reliable' if end.reliable else 'best effort'}, {durability}"
