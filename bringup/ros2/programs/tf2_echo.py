"""`ros2 run tf2_ros tf2_echo`: one frame in another, again and again."""

from __future__ import annotations

import argparse
import math

from rclpy.time import Time
from tf2_ros import Buffer, TransformListener

from arjuna_core.pose3 import Pose3
from arjuna_core.ros.convert import pose3_from_transform, seconds
from bringup.parameters.options import positive
from bringup.ros2.client import Client


def main(words: list[str]) -> None:
    """Print the pose of the target frame in the source frame until interrupted."""
    parser = argparse.ArgumentParser(prog="ros2 run tf2_ros tf2_echo", description=main.__doc__)
    parser.add_argument("source_frame")
    parser.add_argument("target_frame")
    parser.add_argument("rate", nargs="?", type=positive, default=1.0, help="in Hz (default: 1)")
    parser.add_argument("--once", action="store_true", help="end after the first")
    arguments = parser.parse_args(words)
    source, target = arguments.source_frame, arguments.target_frame
    with Client(arguments, "tf2_echo") as client:
        buffer = Buffer(node=client.node)
        TransformListener(buffer, client.node)
        client.run_until(
            lambda: bool(buffer.can_transform(source, target, Time())), 1.0, required=False
        )
        while True:
            known, why = buffer.can_transform(source, target, Time(), return_debug_tuple=True)
            if not known:
                text = f"Waiting for transform {source} ->  {target}: {why}"
                client.node.get_logger().info(text)
            else:
                found = buffer.lookup_transform(source, target, Time())
                pose = pose3_from_transform(found.transform)
                print("\n".join(lines(seconds(found.header.stamp), pose)))
                if arguments.once:
                    return
            client.pause(1.0 / arguments.rate)


def lines(stamp: float, pose: Pose3) -> list[str]:
    """Return what is printed of a pose at a time [s]."""
    w, x, y, z = pose.quaternion
    angles = pose.rpy()
    rows = zip(pose.rotation(), pose.position, strict=True)
    matrix = [*([*row, offset] for row, offset in rows), (0.0, 0.0, 0.0, 1.0)]
    return [
        f"At time {stamp:.9f}",
        f"- Translation: {_list(pose.position)}",
        f"- Rotation: in Quaternion (xyzw) {_list((x, y, z, w))}",
        f"- Rotation: in RPY (radian) {_list(angles)}",
        f"- Rotation: in RPY (degree) {_list(tuple(math.degrees(a) for a in angles))}",
        "- Matrix:",
        *("".join(f"{value:7.3f}" for value in row) for row in matrix),
    ]


def _list(values: tuple[float, ...]) -> str:
    return f"[{', '.join(f'{value:.3f}' for value in values)}]"
