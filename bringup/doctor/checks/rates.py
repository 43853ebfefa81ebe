"""Topics that come too rarely, or not at all."""

from __future__ import annotations

from bringup.doctor.finding import Finding
from bringup.doctor.snapshot import Snapshot

LEAST = {"/scan": 5.0, "/odom": 10.0, "/imu/data": 20.0, "/joint_states": 10.0, "/tf": 10.0}
"""Least rate that mapping and navigation can work with, of the robot's time [Hz]."""


def check(snapshot: Snapshot) -> list[Finding]:
    """Return the topics that are too slow for the stack."""
    passed = snapshot.duration * snapshot.pace
    if passed <= 0.0:
        return []
    found = []
    for topic, least in LEAST.items():
        senders = [end.node for end in snapshot.publishers(topic)]
        if not senders or topic not in snapshot.counts:
            continue
        rate = snapshot.counts[topic] / passed
        if rate >= least:
            continue
        what = f"{topic} of {senders[0]} comes at {rate:.1f} Hz, {least:g} are needed"
        if snapshot.counts[topic] == 0:
            what = f"nothing comes on {topic}, which {senders[0]} publishes"
        found.append(Finding(what, "see the sensor's lines and rate; top says who has no time"))
    return found
