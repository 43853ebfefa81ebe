"""`ros2 run tf2_ros static_transform_publisher`: a fixed transform on /tf_static."""

from __future__ import annotations

import argparse
import os

from tf2_msgs.msg import TFMessage

from arjuna_core.pose3 import Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import transform3_msg
from arjuna_core.ros.tf import transforms_msg
from bringup.ros2.client import Client

_NUMBERS = ("x", "y", "z", "qx", "qy", "qz", "qw", "roll", "pitch", "yaw")
_OLD_FORMS = {  # what stands before frame and child, by the number of words
    8: ("x", "y", "z", "yaw", "pitch", "roll"),
    9: ("x", "y", "z", "qx", "qy", "qz", "qw"),
}


def parse(words: list[str]) -> tuple[str, str, Pose3]:
    """Return the frame, the child frame and the transform that the words ask for.

    The old form stands without flags: `x y z yaw pitch roll` or `x y z qx qy qz qw`, frame, child.
    """
    parser = argparse.ArgumentParser(
        prog="ros2 run tf2_ros static_transform_publisher", description=__doc__
    )
    for name in _NUMBERS:
        parser.add_argument(f"--{name}", type=float, help="[m]" if name in "xyz" else "rotation")
    parser.add_argument("--frame-id", help="the parent")
    parser.add_argument("--child-frame-id", help="the child")
    given, rest = parser.parse_known_args(words)
    if rest == words and len(words) in _OLD_FORMS:
        try:
            numbers = [float(word) for word in words[:-2]]
        except ValueError as error:
            parser.error(str(error))
        vars(given).update(zip(_OLD_FORMS[len(words)], numbers, strict=True))
        given.frame_id, given.child_frame_id = words[-2:]
    elif rest:
        parser.error(f"unknown arguments: {' '.join(rest)}")
    if not given.frame_id or not given.child_frame_id:
        parser.error("--frame-id and --child-frame-id are needed")
    return given.frame_id, given.child_frame_id, _pose(given, parser)


def _pose(given: argparse.Namespace, parser: argparse.ArgumentParser) -> Pose3:
    position = (given.x or 0.0, given.y or 0.0, given.z or 0.0)
    angles = (given.roll, given.pitch, given.yaw)
    quaternion = (given.qw, given.qx, given.qy, given.qz)
    if quaternion == (None,) * 4:
        return Pose3.from_rpy(position, tuple(angle or 0.0 for angle in angles))
    if angles != (None,) * 3:
        parser.error("cannot specify both quaternion and Euler rotations")
    w, x, y, z = quaternion
    return Pose3(position, (1.0 if w is None else w, x or 0.0, y or 0.0, z or 0.0))


def main(words: list[str]) -> None:
    """Publish a static transform until interrupted."""
    frame, child, pose = parse(words)
    name = f"static_transform_publisher_{os.getpid()}"  # so that many can run
    with Client(name=name) as client:
        message = transform3_msg(pose, frame, child, 0.0)
        message.header.stamp = client.node.get_clock().now().to_msg()
        publisher = client.node.create_publisher(TFMessage, "/tf_static", qos.LATCHED)
        publisher.publish(transforms_msg(message))
        client.node.get_logger().info(
            f"Spinning until stopped - publishing transform\ntranslation: {_text(pose.position)}\n"
            f"rotation: {_text((*pose.quaternion[1:], pose.quaternion[0]))}\n"
            f"from '{frame}' to '{child}'"
        )
        client.pause()


def _text(values: tuple[float, ...]) -> str:
    return f"({', '.join(repr(f'{value:f}') for value in values)})"
