"""`ros2 run topic_tools relay`, `twist_stamper`, `image_transport republish`: topics of topics."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CompressedImage, Image

from arjuna_core.ros import qos
from arjuna_core.ros.context import class_of
from bringup.ros2.client import Client
from bringup.ros2.errors import Ros2Error
from bringup.ros2.qos import matched
from bringup.ros2.verbs.forward import ros_arguments

_DEPTH = 10
Passes = Callable[[float], bool]
"""Returns whether a message is handed on that comes at a time [s]."""


class Relayed(NamedTuple):
    """A topic, its other name, and which of its messages are handed on."""

    source: str
    target: str
    passes: Passes


def relayed(name: str, words: list[str]) -> Relayed:
    """Return what the words of `relay`, `throttle` or `drop` ask for, or their parameters.

    Raises:
        Ros2Error: They lack something.
    """
    numbers, made = _KINDS[name]
    given = ros_arguments(words)
    named = given.values
    keys = ("input_topic", *numbers, "output_topic")
    own = given.own or [named.get(key, "") for key in keys]
    own = own[1:] if own[0] == "messages" else own
    try:
        values = [float(word) for word in own[1 : len(numbers) + 1]]
    except ValueError as error:
        raise Ros2Error(f"{name}: {error}") from error
    if not own or not own[0] or len(values) < len(numbers) or 0.0 in values[-1:]:
        raise Ros2Error(f"{name} lacks something; valid: {' '.join(('IN', *numbers))} [OUT]")
    target = "".join(own[len(numbers) + 1 :][:1]) or f"{own[0]}_{name}"
    return Relayed(own[0], target, made(*values))


def _throttle(rate: float) -> Passes:
    last = [-math.inf]

    def passes(now: float) -> bool:
        is_due = now - last[0] >= 1.0 / rate or now < last[0]
        last[0] = now if is_due else last[0]
        return is_due

    return passes


def _drop(dropped: float, of: float) -> Passes:
    count = itertools.count()
    return lambda now: next(count) % int(of) >= dropped


_KINDS: dict[str, tuple[tuple[str, ...], Callable[..., Passes]]] = {
    "drop": (("X", "Y"), _drop),
    "relay": ((), lambda: lambda now: True),
    "throttle": (("msgs_per_sec",), _throttle),
}
"""The numbers of each, and what it makes of them."""


def _hand_on(words: list[str], name: str) -> None:
    asked = relayed(name, words)
    with Client(name=name) as client:
        node = client.node
        source, target = map(node.resolve_topic_name, asked[:2])
        client.run_until(lambda: node.count_publishers(source) > 0)
        offers = node.get_publishers_info_by_topic(source)
        profile = matched(QoSProfile(depth=_DEPTH), offers)
        kind = class_of(offers[0].topic_type)
        publisher = node.create_publisher(kind, target, profile)

        def handed_on(message: bytes) -> None:
            if kind is Clock and node.count_publishers(target) > 1:
                return  # the simulator's: a time that comes later by another way goes back
            if asked.passes(node.get_clock().now().nanoseconds * 1e-9):
                publisher.publish(message)

        node.create_subscription(kind, source, handed_on, profile, raw=True)
        print(f"{source} is {target} too ({offers[0].topic_type})", flush=True)
        client.pause()


relay = partial(_hand_on, name="relay")
throttle = partial(_hand_on, name="throttle")
drop = partial(_hand_on, name="drop")


def stamp(words: list[str]) -> None:
    """Hand the velocities of `cmd_vel_in` on as `cmd_vel_out`, with a time and a `frame_id`."""
    frame = ros_arguments(words).values.get("frame_id", "")

    def stamped(twist: Any, now: Any) -> Any:
        message = TwistStamped(twist=twist)
        message.header.stamp, message.header.frame_id = now, frame
        return message

    _turn("twist_stamper", Twist, TwistStamped, stamped)


def unstamp(words: list[str]) -> None:
    """Hand the velocities of `cmd_vel_in` on as `cmd_vel_out`, without time and frame."""
    _turn("twist_unstamper", TwistStamped, Twist, lambda stamped, now: stamped.twist)


def _turn(
    name: str,
    kind: Any,
    into: Any,
    turned: Callable[[Any, Any], Any],
    topics: tuple[str, str] = ("cmd_vel_in", "cmd_vel_out"),
) -> None:
    with Client(name=name) as client:
        node = client.node
        publisher = node.create_publisher(into, topics[1], _DEPTH)

        def received(message: Any) -> None:
            publisher.publish(turned(message, node.get_clock().now().to_msg()))

        profile = qos.SENSOR_SUBSCRIPTION if kind in (Image, CompressedImage) else _DEPTH
        node.create_subscription(kind, topics[0], received, profile)
        client.pause()


def republish(words: list[str]) -> None:
    """Hand pictures on, compressed or not: `republish raw compressed`.

    Raises:
        Ros2Error: A transport is neither raw nor compressed.
    """
    given = ros_arguments(words)
    usual = [given.values.get(f"{side}_transport", "raw") for side in ("in", "out")]
    source, target = [*given.own, *usual[len(given.own) :]][:2]
    if {source, target} - set(_PICTURES):
        raise Ros2Error(f"republish {source} {target}: valid: {', '.join(_PICTURES)}")
    from cv_bridge import CvBridge

    bridge = CvBridge()

    def turned(message: Any, now: Any) -> Any:
        picture = (
            bridge.imgmsg_to_cv2(message, "bgr8")
            if source == "raw"
            else bridge.compressed_imgmsg_to_cv2(message, "bgr8")
        )
        made = (
            bridge.cv2_to_imgmsg(picture, "bgr8")
            if target == "raw"
            else bridge.cv2_to_compressed_imgmsg(picture)
        )
        made.header = message.header
        return made

    kinds = _PICTURES[source][0], _PICTURES[target][0]
    topics = f"in{_PICTURES[source][1]}", f"out{_PICTURES[target][1]}"
    _turn("image_republisher", *kinds, turned, topics)


_PICTURES = {"raw": (Image, ""), "compressed": (CompressedImage, "/compressed")}
