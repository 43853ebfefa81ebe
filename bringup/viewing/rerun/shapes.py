"""Messages as rerun's archetypes: drawings, pictures, the robot's model, curves and words."""

from __future__ import annotations

import io
import math
from typing import Any

import numpy as np
import rerun as rr
from PIL import Image

from arjuna_core.pixels import pixels
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.drawing.messages import flat_points, frame_of, pose3
from bringup.viewing.drawing.values import Arrows, Drawing, Grid, Line, Points
from bringup.viewing.drawing.visual_model import VisualError, read
from bringup.viewing.rerun.stream import Stream

SPEED, TURN, ERROR, GOAL = "curves/speed", "curves/turn_rate", "curves/error", "curves/goal"
# of action_msgs/GoalStatus and rcl_interfaces/Log
_STATES = ("unknown", "accepted", "executing", "canceling", "succeeded", "canceled", "aborted")
_LEVELS = {10: "DEBUG", 20: "INFO", 30: "WARN", 40: "ERROR", 50: "CRITICAL"}


def twist(stream: Stream, topic: str, message: Any) -> None:
    """Draw speed [m/s] and turn rate [rad/s]."""
    stream.scalar(f"{SPEED}{topic}", message.linear.x)
    stream.scalar(f"{TURN}{topic}", message.angular.z)


def quality(stream: Stream, topic: str, message: Any) -> None:
    """Draw the quality of AMCL's estimate (0..1)."""
    stream.scalar(f"{ERROR}{topic}", message.quality)


def feedback(stream: Stream, topic: str, message: Any) -> None:
    """Draw the distance to the goal [m] and the number of recoveries."""
    stream.scalar(f"{GOAL}/distance_remaining", message.feedback.distance_remaining)
    stream.scalar(f"{GOAL}/recoveries", message.feedback.number_of_recoveries)


def errors(stream: Stream, frames: Frames, truth: Any) -> None:
    """Draw the error of the robot's belief [m] and [rad].

    Args:
        frames: Its belief, where there is a map.
        truth: The simulator's odometry without errors, in the world's frame.
    """
    believed = frames.pose(truth.child_frame_id) if frames.fixed == "map" else None
    if believed is None:
        return
    true = pose3(truth.pose.pose)
    stream.scalar(f"{ERROR}/position", math.dist(believed.position[:2], true.position[:2]))
    turned = believed.rpy()[2] - true.rpy()[2]
    stream.scalar(f"{ERROR}/heading", abs(math.remainder(turned, 2.0 * math.pi)))


def goal_status(stream: Stream, topic: str, message: Any) -> None:
    """Show the state of an action's newest goal as a lane of the state timeline."""
    if message.status_list:
        stamps = [status.goal_info.stamp for status in message.status_list]
        newest = max(range(len(stamps)), key=lambda i: (stamps[i].sec, stamps[i].nanosec))
        code = message.status_list[newest].status
        state = _STATES[code] if 0 <= code < len(_STATES) else str(code)
        action = topic.removesuffix("/_action/status")
        stream.log(f"states{action}", rr.StateChange(state=state))


def log(stream: Stream, topic: str, message: Any) -> None:
    """Show a line of a node's log."""
    level = _LEVELS.get(message.level, "INFO")
    stream.log(f"logs/{message.name or 'unnamed'}", rr.TextLog(message.msg, level=level))


def text(stream: Stream, topic: str, message: Any) -> None:
    """Show a text, such as the explorer's status."""
    if len(message.data) < 1000:  # no description of a robot under another name
        stream.log(f"logs{topic}", rr.TextLog(message.data, level="INFO"))


def markers(stream: Stream, topic: str, message: Any) -> None:
    """Draw the points of all markers: of trajectories, of SLAM's graph."""
    if not message.markers:
        raise ValueError("it has no marker")
    points = flat_points(((p.x, p.y) for each in message.markers for p in each.points), 0.04)
    frame = frame_of(message.markers[0])
    draw(stream, topic, Points(frame=frame, points=points, colour=(30, 110, 240), size=0.03))


def transforms(stream: Stream, frames: Frames, message: Any, static: bool) -> bool:
    """Move frames; return whether one is new or has another parent."""
    for each in message.transforms:
        parent, child = frame_of(each), each.child_frame_id.lstrip("/")
        pose = pose3(each.transform)
        w, x, y, z = pose.quaternion
        if static:
            moved = rr.Transform3D(
                translation=pose.position,
                quaternion=rr.Quaternion(xyzw=(x, y, z, w)),
                parent_frame=parent,
                child_frame=child,
            )
            stream.always(f"tf/{child}", moved)
        else:
            stream.transform(parent, child, pose.position, (x, y, z, w))
    return frames.take(message, static, stream.now)


def draw(stream: Stream, topic: str, drawing: Drawing) -> None:
    """Draw something in its frame, in place of the one before of the topic."""
    new = stream.set_frame(topic, drawing.frame)
    if isinstance(drawing, Points):
        if new:
            radii = [drawing.size / 2.0]
            stream.always(topic, rr.Points3D.from_fields(colors=[drawing.colour], radii=radii))
        stream.cloud(topic, drawing.points)
    elif isinstance(drawing, Line):
        strips = [drawing.points] if len(drawing.points) else []
        radius = drawing.width / 200.0  # 2 cm for a path
        stream.log(topic, rr.LineStrips3D(strips, colors=[drawing.colour], radii=[radius]))
    elif isinstance(drawing, Arrows):
        tails, tips = drawing.segments[:, 0], drawing.segments[:, 1]
        colours, radii = [drawing.colour], [drawing.width / 2.0]
        arrows = rr.Arrows3D(origins=tails, vectors=tips - tails, colors=colours, radii=radii)
        stream.log(topic, arrows)
    elif isinstance(drawing, Grid) and drawing.grid.data.size:
        stream.log(topic, _grid_map(drawing))


def _grid_map(drawing: Grid) -> rr.GridMap:
    frame, costs = drawing.grid.frame, drawing.opacity is not None
    w, x, y, z = drawing.pose.quaternion
    maps = rr.components.Colormap
    return rr.GridMap(
        data=np.ascontiguousarray(drawing.grid.data[::-1]).tobytes(),
        format=rr.components.ImageFormat(
            width=frame.width, height=frame.height, color_model="L", channel_datatype="U8"
        ),
        cell_size=frame.resolution,
        translation=drawing.pose.position,
        quaternion=rr.Quaternion(xyzw=(x, y, z, w)),
        opacity=drawing.opacity if costs else 1.0,
        colormap=maps.RvizCostmap if costs else maps.RvizMap,
    )


def image(stream: Stream, topic: str, message: Any) -> None:
    """Show a picture, as a JPEG."""
    size = (message.height, message.width, message.step)
    shown = pixels(message.encoding, *size, bytes(message.data))
    out = io.BytesIO()
    Image.fromarray(shown).save(out, "JPEG", quality=80)
    stream.log(topic, rr.EncodedImage(contents=out.getvalue(), media_type="image/jpeg"))


def compressed_image(stream: Stream, topic: str, message: Any) -> None:
    """Show a JPEG or PNG as it is."""
    kind = "png" if "png" in message.format.lower() else "jpeg"
    data = np.asarray(message.data, dtype=np.uint8).tobytes()
    stream.log(topic, rr.EncodedImage(contents=data, media_type=f"image/{kind}"))


def robot(stream: Stream, description: str) -> tuple[str, ...]:
    """Show each link of a URDF in its frame, so that TF moves it; return notes on the rest."""
    try:
        model = read(description)
    except VisualError as error:
        return (str(error),)
    for link, glb in model.glbs.items():
        stream.set_frame(f"robot/{link}", link)
        stream.always(f"robot/{link}", rr.Asset3D(contents=glb, media_type=rr.MediaType.GLB))
    return model.notes
