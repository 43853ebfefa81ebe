"""The topics of the graph, and the classes of their messages."""

from __future__ import annotations

from typing import Any

import rclpy
from rclpy.expand_topic_name import expand_topic_name
from rclpy.qos import QoSPresetProfiles, QoSProfile
from rosidl_runtime_py.utilities import get_message

from bringup.recording.qos_overrides import POLICIES
from bringup.ros2.client import Names, visible_types


def get_topic_names_and_types(*, node: Any, include_hidden_topics: bool = False) -> Names:
    """Return the topics that a node sees, each with its types."""
    return visible_types(node.get_topic_names_and_types(), include_hidden_topics)


def get_topic_names(*, node: Any, include_hidden_topics: bool = False) -> list[str]:
    pairs = get_topic_names_and_types(node=node, include_hidden_topics=include_hidden_topics)
    return [name for name, _ in pairs]


def get_msg_class(
    node: Any, topic: str, blocking: bool = False, include_hidden_topics: bool = False
) -> Any:
    """Return the class of a topic's messages, None where nobody publishes it.

    Args:
        node: Who looks.
        topic: Its name.
        blocking: Whether to wait for a publisher; the node is spun meanwhile.
        include_hidden_topics: Whether hidden topics count.

    Raises:
        RuntimeError: It has several types.
    """
    name = expand_topic_name(topic, node.get_name(), node.get_namespace())
    waits = True
    while waits and rclpy.ok():
        pairs = get_topic_names_and_types(node=node, include_hidden_topics=include_hidden_topics)
        types = dict(pairs).get(name, ())
        if len(types) > 1:
            raise RuntimeError(f"topic '{topic}' has more than one type: {', '.join(types)}")
        if types:
            return get_message(types[0])
        waits = blocking
        if waits:
            rclpy.spin_once(getattr(node, "node", node), timeout_sec=0.1)
    return None


def profile_configure_short_keys(profile: QoSProfile, depth: Any = None, **policies: Any) -> None:
    """Set a profile's depth, and policies by the short keys of the command line."""
    for name, key in policies.items():
        if key is not None:
            setattr(profile, name, POLICIES[name].get_from_short_key(key))
    if depth is not None and depth >= 0:
        profile.depth = depth


def qos_profile_from_short_keys(preset_profile: str, **parts: Any) -> QoSProfile:
    profile = QoSPresetProfiles.get_from_short_key(preset_profile)
    profile_configure_short_keys(profile, **parts)
    return profile
