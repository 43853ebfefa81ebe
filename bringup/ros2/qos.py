"""Quality of service from options, and as the publishers of a topic offer it."""

from __future__ import annotations

import argparse
from typing import Any

from rclpy.duration import Duration
from rclpy.qos import (
    DurabilityPolicy,
    QoSPresetProfiles,
    QoSProfile,
    ReliabilityPolicy,
)

from bringup.recording.qos_overrides import POLICIES

_FALLBACK = (
    "Some, but not all, publishers are offering {offered}. Falling back to {taken}"
    " as it will connect to all publishers"
)


def from_options(arguments: argparse.Namespace) -> QoSProfile:
    """Return the profile that `--qos-*` options ask for."""
    profile = QoSPresetProfiles.get_from_short_key(arguments.qos_profile)
    for name, policy in POLICIES.items():
        key = getattr(arguments, f"qos_{name}")
        if key is not None:
            setattr(profile, name, policy.get_from_short_key(key))
    lease = arguments.qos_liveliness_lease_duration_seconds
    if lease is not None and lease >= 0:
        profile.liveliness_lease_duration = Duration(seconds=lease)
    if arguments.qos_depth is not None:
        profile.depth = arguments.qos_depth
    elif profile.durability == DurabilityPolicy.TRANSIENT_LOCAL and profile.depth == 0:
        profile.depth = 1
    return profile


def for_subscription(node: Any, topic: str, arguments: argparse.Namespace) -> QoSProfile:
    """Return the options' profile, or else one that all publishers of a topic match."""
    if any(getattr(arguments, f"qos_{name}") is not None for name in ("depth", *POLICIES)):
        return from_options(arguments)
    profile = QoSPresetProfiles.get_from_short_key(arguments.qos_profile)
    return matched(profile, node.get_publishers_info_by_topic(topic))


def matched(profile: QoSProfile, publishers: list[Any]) -> QoSProfile:
    """Set a profile's reliability and durability to the most that every publisher offers."""
    if not publishers:
        return profile
    strong = (
        ("reliability", ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT),
        ("durability", DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE),
    )
    for name, most, least in strong:
        offers = [getattr(info.qos_profile, name) == most for info in publishers]
        if any(offers) and not all(offers):
            print(_FALLBACK.format(offered=_title(most), taken=_title(least)))
        setattr(profile, name, most if all(offers) else least)
    return profile


def _title(policy: Any) -> str:
    return f"QoS{type(policy).__name__.removeprefix('QoS')}.{policy.name}"
