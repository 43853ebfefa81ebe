"""Qualities of service as rosbag2_py has them: rclcpp's, whose parts are set by calls in a row.

`QoS(1).reliable().transient_local()` is the offer of a latched topic.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import rclpy.duration
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)

from arjuna_core.bags.topic import parse
from arjuna_core.ros.qos import profile_of


def _policies(kind: str, known: type[IntEnum]) -> Any:
    """Return rmw's enumeration of a policy, whose values are those of rclpy's."""
    values = {f"RMW_QOS_POLICY_{kind.upper()}_{one.name}": one.value for one in known}
    return IntEnum(f"rmw_qos_{kind}_policy_t", values)


rmw_qos_durability_policy_t = _policies("durability", DurabilityPolicy)
rmw_qos_history_policy_t = _policies("history", HistoryPolicy)
rmw_qos_liveliness_policy_t = _policies("liveliness", LivelinessPolicy)
rmw_qos_reliability_policy_t = _policies("reliability", ReliabilityPolicy)


class Duration(rclpy.duration.Duration):
    """A duration by its seconds and nanoseconds."""

    def __init__(self, seconds: int, nanoseconds: int) -> None:
        super().__init__(seconds=seconds, nanoseconds=nanoseconds)


class QoS:
    """A publisher's quality of service; each call sets a part of it and returns it."""

    def __init__(self, history_depth: int) -> None:
        self._profile = QoSProfile(depth=history_depth)

    def _set(self, **parts: object) -> QoS:
        for name, value in parts.items():
            setattr(self._profile, name, value)
        return self

    def __eq__(self, other: object) -> bool:
        return isinstance(other, QoS) and self._profile == other._profile

    def keep_last(self, depth: int) -> QoS:
        return self._set(history=HistoryPolicy.KEEP_LAST, depth=depth)

    def keep_all(self) -> QoS:
        return self._set(history=HistoryPolicy.KEEP_ALL)

    def reliable(self) -> QoS:
        return self._set(reliability=ReliabilityPolicy.RELIABLE)

    def best_effort(self) -> QoS:
        return self._set(reliability=ReliabilityPolicy.BEST_EFFORT)

    def transient_local(self) -> QoS:
        return self._set(durability=DurabilityPolicy.TRANSIENT_LOCAL)

    def durability_volatile(self) -> QoS:
        return self._set(durability=DurabilityPolicy.VOLATILE)

    def history(self, policy: int) -> QoS:
        return self._set(history=HistoryPolicy(policy))

    def reliability(self, policy: int) -> QoS:
        return self._set(reliability=ReliabilityPolicy(policy))

    def durability(self, policy: int) -> QoS:
        return self._set(durability=DurabilityPolicy(policy))

    def liveliness(self, policy: int) -> QoS:
        return self._set(liveliness=LivelinessPolicy(policy))

    def deadline(self, duration: rclpy.duration.Duration) -> QoS:
        return self._set(deadline=duration)

    def lifespan(self, duration: rclpy.duration.Duration) -> QoS:
        return self._set(lifespan=duration)

    def liveliness_lease_duration(self, duration: rclpy.duration.Duration) -> QoS:
        return self._set(liveliness_lease_duration=duration)

    def avoid_ros_namespace_conventions(self, avoid: bool) -> QoS:
        return self._set(avoid_ros_namespace_conventions=avoid)


def convert_rclcpp_qos_to_rclpy_qos(qos: QoS | QoSProfile) -> QoSProfile:
    """Return the profile that rclpy takes."""
    return qos._profile if isinstance(qos, QoS) else qos


def qos_from_profile(profile: QoSProfile) -> QoS:
    """Return what an rclpy profile says."""
    made = QoS(profile.depth or 1)
    made._profile = profile
    return made


def to_rclcpp_qos_vector(serialized: str, version: int = 9) -> list[QoS]:
    """Return the offers in a recording's text, of any version of its metadata."""
    return [qos_from_profile(profile_of(each)) for each in parse(serialized)]
