"""Messages that have a place in space, or are pictures, as rerun's shapes."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray
from PIL import Image

from arjuna_core.pose3 import Pose3
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.rerun.stream import Stream

_SCAN, _BELIEF, _GOAL = (255, 60, 40), (60, 120, 255), (255, 140, 0)
_PATHS = {"local": (255, 220, 0), "": (0, 200, 90)}
_HEIGHT = {"map": -0.02, "costmap": -0.01, "path": 0.03}  # so that what lies flat is seen [m]
_ARROW = 0.4  # [m]
_CHANNELS = {"rgb8": ("RGB", 3, 1), "bgr8": ("RGB", 3, -1), "mono8": ("L", 1, 1)}
_SIGMAS = 2.0  # radius of a belief's ellipse


def transforms(stream: Stream, frames: Frames, message: Any, static: bool) -> bool:
    """Move frames; return whether one is new or hangs elsewhere."""
    changed = False
    for each in message.transforms:
        parent, child = each.header.frame_id.lstrip("/"), each.child_frame_id.lstrip("/")
        shift, turn = each.transform.translation, each.transform.rotation
        place, rotation = (shift.x, shift.y, shift.z), (turn.x, turn.y, turn.z, turn.w)
        changed |= frames.parents.get(child) != parent
        pose = Pose3(place, (turn.w, turn.x, turn.y, turn.z))
        frames.insert(parent, child, stream.now, pose, static)
        if static:
            moved = rr.Transform3D(
                translation=place,
                quaternion=rr.Quaternion(xyzw=rotation),
                parent_frame=parent,
                child_frame=child,
            )
            stream.always(f"tf/{child}", moved)
        else:
            stream.transform(parent, child, place, rotation)
    return changed


def scan(stream: Stream, topic: str, message: Any) -> None:
    """Show a scan's points in the scanner's frame."""
    ranges = np.asarray(message.ranges, dtype=np.float32)
    angles = message.angle_min + message.angle_increment * np.arange(len(ranges))
    good = (ranges >= message.range_min) & (ranges <= message.range_max)
    flat = ranges[good], angles[good]
    points = np.stack([flat[0] * np.cos(flat[1]), flat[0] * np.sin(flat[1]), 0.0 * flat[0]], 1)
    if stream.place(topic, message.header.frame_id):
        stream.always(topic, rr.Points3D.from_fields(colors=[_SCAN], radii=[0.02]))
    stream.cloud(topic, points.astype(np.float32))


def grid(stream: Stream, topic: str, message: Any) -> None:
    """Show a map or a costmap."""
    info = message.info
    data = np.asarray(message.data, dtype=np.int8)
    if data.size != info.width * info.height:
        raise ValueError(f"{data.size} cells for a grid of {info.width} x {info.height}")
    if not data.size:
        return
    costs = "costmap" in topic
    place, turn = info.origin.position, info.origin.orientation
    stream.place(topic, message.header.frame_id)
    stream.log(
        topic,
        rr.GridMap(
            data=np.ascontiguousarray(data.reshape(info.height, info.width)[::-1]).tobytes(),
            format=rr.components.ImageFormat(
                width=info.width, height=info.height, color_model="L", channel_datatype="U8"
            ),
            cell_size=info.resolution,
            translation=(place.x, place.y, place.z + _HEIGHT["costmap" if costs else "map"]),
            quaternion=rr.Quaternion(xyzw=(turn.x, turn.y, turn.z, turn.w)),
            opacity=0.4 if costs else 1.0,
            colormap=(
                rr.components.Colormap.RvizCostmap if costs else rr.components.Colormap.RvizMap
            ),
        ),
    )


def path(stream: Stream, topic: str, message: Any) -> None:
    """Show a path as a line."""
    rows = [
        (each.pose.position.x, each.pose.position.y, each.pose.position.z + _HEIGHT["path"])
        for each in message.poses
    ]
    colour = next(colour for name, colour in _PATHS.items() if name in topic)
    stream.place(topic, message.header.frame_id)
    stream.log(topic, rr.LineStrips3D([rows] if rows else [], colors=[colour], radii=[0.02]))


def polygon(stream: Stream, topic: str, message: Any) -> None:
    """Show a polygon, such as the robot's footprint, as a closed line."""
    rows = [(each.x, each.y, each.z + _HEIGHT["path"]) for each in message.polygon.points]
    stream.place(topic, message.header.frame_id)
    stream.log(topic, rr.LineStrips3D([[*rows, rows[0]]] if rows else [], radii=[0.01]))


def particles(stream: Stream, topic: str, message: Any) -> None:
    """Show AMCL's particles."""
    _arrows(stream, topic, message, [each.pose for each in message.particles], 0.1, _BELIEF)


def poses(stream: Stream, topic: str, message: Any) -> None:
    """Show poses as arrows."""
    _arrows(stream, topic, message, message.poses, 0.2, _BELIEF)


def pose(stream: Stream, topic: str, message: Any) -> None:
    """Show a pose, such as a goal, as an arrow."""
    _arrows(stream, topic, message, [message.pose], _ARROW, _GOAL)


def belief(stream: Stream, topic: str, message: Any) -> None:
    """Show a pose as an arrow in its ellipse of two standard deviations."""
    where = message.pose.pose
    _arrows(stream, topic, message, [where], _ARROW, _BELIEF)
    covariance = np.asarray(message.pose.covariance, dtype=np.float64).reshape(6, 6)[:2, :2]
    if not np.isfinite(covariance).all():
        return
    variances, axes = np.linalg.eigh((covariance + covariance.T) / 2.0)
    half = _SIGMAS * np.sqrt(np.clip(variances, 0.0, None))
    circle = np.linspace(0.0, 2.0 * np.pi, 49)
    flat = np.stack([half[0] * np.cos(circle), half[1] * np.sin(circle)])
    x, y = axes @ flat
    ring = np.stack([x + where.position.x, y + where.position.y, 0.0 * x + _HEIGHT["path"]], 1)
    stream.place(f"{topic}/covariance", message.header.frame_id)
    stream.log(f"{topic}/covariance", rr.LineStrips3D([ring], colors=[_BELIEF], radii=[0.01]))


def _arrows(
    stream: Stream, topic: str, message: Any, found: Any, length: float, colour: Any
) -> None:
    origins = [(each.position.x, each.position.y, _HEIGHT["path"]) for each in found]
    vectors = [length * _forward(each.orientation) for each in found]
    stream.place(topic, message.header.frame_id)
    stream.log(
        topic,
        rr.Arrows3D(origins=origins, vectors=vectors, colors=[colour], radii=[length / 16.0]),
    )


def _forward(turn: Any) -> NDArray[np.float64]:
    return Pose3((0.0, 0.0, 0.0), (turn.w, turn.x, turn.y, turn.z)).rotation()[:, 0]


def image(stream: Stream, topic: str, message: Any) -> None:
    """Show a colour or grey picture, as a JPEG; others are passed over."""
    if message.encoding not in _CHANNELS:
        return
    mode, count, order = _CHANNELS[message.encoding]
    rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
    pixels = rows[:, : message.width * count].reshape(message.height, message.width, count)
    picture = Image.fromarray(np.ascontiguousarray(pixels[:, :, ::order]).squeeze(), mode)
    out = io.BytesIO()
    picture.save(out, "JPEG", quality=80)
    stream.log(topic, rr.EncodedImage(contents=out.getvalue(), media_type="image/jpeg"))


def compressed_image(stream: Stream, topic: str, message: Any) -> None:
    """Show a JPEG or PNG as it is."""
    kind = "png" if "png" in message.format.lower() else "jpeg"
    data = np.asarray(message.data, dtype=np.uint8).tobytes()
    stream.log(topic, rr.EncodedImage(contents=data, media_type=f"image/{kind}"))
