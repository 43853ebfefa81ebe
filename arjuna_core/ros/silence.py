"""Why nothing comes on a topic, in words that name what to do about it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rclpy.qos import QoSCompatibility, QoSProfile, qos_check_compatible

from arjuna_core.ros.node import ManagedNode

_NO_SENSORS = ("/scan_visualization", "/ground_truth/odom")  # of a keyframe; the simulator's


class Silence(NamedTuple):
    """A subscribed topic, and the advice where nothing comes on it.

    Attributes:
        what: One of its messages, as a "scan".
        advice: What to do where such messages come on another topic.
        rare: Whether nothing may come for long: only where others publish on another topic, and
            nobody on this, that is reported.
    """

    kind: Any
    what: str
    profile: QoSProfile
    advice: str
    rare: bool = False

    @property
    def type(self) -> str:
        """The full name of the message's type."""
        return f"{self.kind.__module__.partition('.')[0]}/msg/{self.kind.__name__}"


def why_silent(node: Any, topic: str, of: Silence) -> str:
    """Return why no message comes on a topic, by its full name."""
    own = of.type
    publishers = node.get_publishers_info_by_topic(topic)
    others = sorted({info.topic_type for info in publishers} - {own})
    if not publishers:
        return f"nobody publishes it; {_elsewhere(node, own, of)}"
    if others:
        return f"it is of {', '.join(others)}, not {own}; {_elsewhere(node, own, of)}"
    names = ", ".join(sorted({info.node_name for info in publishers}))
    for info in publishers:
        fit, reason = qos_check_compatible(info.qos_profile, of.profile)
        if fit == QoSCompatibility.ERROR:
            return f"the quality of service of {names} does not fit: {reason}"
    return f"{names} would publish it and is silent; is its sensor running?"


def _elsewhere(node: Any, kind: str, of: Silence) -> str:
    topics = _topics(node, kind)
    if not topics:
        return f"no node publishes {of.what}s: is the robot, or its sensor's driver, running?"
    return f"{of.what}s are on {', '.join(topics)}: {of.advice}"


def _topics(node: Any, kind: str) -> list[str]:
    """Return the topics on which others publish a type, but for those of no sensor."""
    found = [name for name, types in node.get_topic_names_and_types() if kind in types]
    infos = {name: node.get_publishers_info_by_topic(name) for name in found}
    nodes = {
        name: {info.node_name for info in each if info.topic_type == kind} - {node.get_name()}
        for name, each in infos.items()
    }
    return [name for name in found if nodes[name] and not name.endswith(_NO_SENSORS)]


def subscribe_watched(
    node: ManagedNode, topic: str, of: Silence, take: Callable[[Any], None]
) -> None:
    """Subscribe in a node's `configure`, and warn once when nothing comes; see `SilenceWatch`."""
    watch = SilenceWatch(node, topic, of)

    def receive(message: Any) -> None:
        watch.received()
        take(message)

    node.subscribe(of.kind, topic, receive, of.profile)


class SilenceWatch:
    """Warns once when nothing comes, at the start or later on; made while the node configures.

    It looks at the graph after 4 s, and, where there was nothing to say, each 10 s from then on.
    """

    def __init__(self, node: ManagedNode, topic: str, of: Silence) -> None:
        self._node, self._of = node, of
        self._topic = node.full_topic(topic)
        self._silent, self._said = 0, False
        period = 1.0  # [s] between two looks
        node.every(period, self._look)

    def received(self) -> None:
        """Note that a message has come."""
        self._silent, self._said = 0, False

    def _look(self) -> None:
        self._silent += 1
        if self._said or self._silent % 10 != 4:
            return
        if not self._of.rare or self._is_elsewhere():
            self._said = True
            reason = why_silent(self._node, self._topic, self._of)
            log = self._node.get_logger()
            log.warning(f"no {self._of.what} comes on '{self._topic}': {reason}")

    def _is_elsewhere(self) -> bool:
        nobody = not self._node.count_publishers(self._topic)
        return nobody and bool(_topics(self._node, self._of.type))
