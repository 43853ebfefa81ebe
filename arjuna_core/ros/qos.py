"""Quality of service of every kind of topic, as Nav2's and RViz's clients expect it."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from arjuna_core.bags.topic import TopicQos

DEFAULT = QoSProfile(depth=10)
LATEST = QoSProfile(depth=1)
SENSOR_SUBSCRIPTION = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
SENSOR_PUBLISHER = QoSProfile(depth=5)  # reliable: matches reliable and best-effort clients alike
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
TF = QoSProfile(depth=100)
TF_STATIC = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
TF_STATIC_SUBSCRIPTION = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
CLOCK = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
SERVICES = QoSProfile(depth=1000)  # of more than rclpy's 10 at once the rest would be lost


def qos_of(profile: QoSProfile) -> TopicQos:
    """Return the QoS of an rclpy profile."""
    return TopicQos(
        profile.reliability != ReliabilityPolicy.BEST_EFFORT,
        profile.durability == DurabilityPolicy.TRANSIENT_LOCAL,
        profile.depth,
    )


def profile_of(wanted: TopicQos) -> QoSProfile:
    """Return the rclpy profile of a recording's QoS."""
    reliability, durability = ReliabilityPolicy, DurabilityPolicy
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST if wanted.depth else HistoryPolicy.SYSTEM_DEFAULT,
        depth=wanted.depth,
        reliability=reliability.RELIABLE if wanted.reliable else reliability.BEST_EFFORT,
        durability=durability.TRANSIENT_LOCAL if wanted.latched else durability.VOLATILE,
    )
