"""Laser scans, point clouds and depth pictures, in one colour or coloured by a field."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.param import duration_param, length_param, param
from arjuna_core.readings import scan_from_msg, seconds
from bringup.viewing.displays.base import Display, Wanted, rainbow
from bringup.viewing.drawing.messages import frame_of
from bringup.viewing.drawing.values import Colour, Colours, Parts, Points

# sensor_msgs/PointField's datatypes
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
_METRES = {"32FC1": ("<f4", 1.0), "16UC1": ("<u2", 0.001), "mono16": ("<u2", 0.001)}
"""The type and the unit [m] of a pixel, by the picture's encoding (REP 118)."""


class PointCloud2(Display):
    """A cloud of points."""

    types = ("sensor_msgs/msg/PointCloud2",)
    topic = "points"

    @dataclass(frozen=True)
    class Config:
        color_transformer: str = param(
            *("Intensity", "What colours the points."),
            choices=("FlatColor", "Intensity", "AxisColor", "RGB8"),
        )
        channel_name: str = param("intensity", "Field that colours them by Intensity.")
        axis: str = param("Z", "Axis that colours them by AxisColor.", choices=("X", "Y", "Z"))
        color: Colour = param((255, 255, 255), "FlatColor's colour.")
        size_m: float = length_param(0.03, "Size of a point.", minimum=0.001, maximum=1.0)
        autocompute_intensity_bounds: bool = param(True, "Colours span the values that come.")
        min_intensity: float = param(0.0, "Value of the first colour.")
        max_intensity: float = param(4096.0, "Value of the last colour.")
        decay_time: float = duration_param(0.0, "How long points stay; 0 until the next ones come.")

    def take(self, message: Any) -> Parts:
        values = self._fields(message)
        if not {"x", "y", "z"} <= values.keys():
            raise ValueError(f"a cloud without x, y and z; its fields: {', '.join(values)}")
        points = np.stack([values[axis] for axis in "xyz"], axis=1).astype(np.float32, copy=False)
        finite = np.isfinite(points).all(axis=1)
        colour = self._colours(points, values)
        if not finite.all():
            points = points[finite]
            colour = colour if isinstance(colour, tuple) else colour[finite]
        stamp = seconds(message.header.stamp)
        return {
            "": Points(
                frame=frame_of(message), stamp=stamp or None,
                points=points, colour=colour, size=self.config.size_m,
            )
        }  # fmt: skip

    def _fields(self, message: Any) -> dict[str, NDArray[Any]]:
        return cloud_fields(message)

    def _colours(self, points: Any, values: dict[str, NDArray[Any]]) -> Colour | Colours:
        config, by = self.config, self.config.color_transformer
        packed = values.get("rgb", values.get("rgba"))
        if packed is not None and (by == "RGB8" or config.channel_name not in values):
            words = np.ascontiguousarray(packed).astype(packed.dtype.newbyteorder("<"))
            return words.view(np.uint8).reshape(-1, 4)[:, 2::-1]
        if by == "AxisColor":
            return self._spread(points[:, "XYZ".index(config.axis)])
        if by == "Intensity" and config.channel_name in values:
            return self._spread(values[config.channel_name])
        flat: Colour = config.color
        return flat

    def _spread(self, values: Any) -> Colours:
        config = self.config
        if config.autocompute_intensity_bounds:
            return rainbow(values)
        return rainbow(values, config.min_intensity, config.max_intensity)


def cloud_fields(message: Any) -> dict[str, NDArray[Any]]:
    """Return the fields of a PointCloud2 message by name, `(N,)` each.

    Raises:
        ValueError: The data are not as long as the message says.
    """
    order, shape = (">" if message.is_bigendian else "<"), (message.height, message.width)
    strides = (message.row_step, message.point_step)
    found = {}
    for each in message.fields:
        if each.datatype in _TYPES and message.width * message.height:
            dtype = np.dtype(order + _TYPES[each.datatype])
            try:
                cells = np.ndarray(shape, dtype, message.data, each.offset, strides)
            except (TypeError, ValueError) as error:
                raise ValueError(f"a cloud of {len(message.data)} bytes is too short") from error
            found[each.name] = cells.reshape(-1)
        elif each.datatype in _TYPES:
            found[each.name] = np.zeros(0, np.float32)
    return found


class PointCloud(PointCloud2):
    """A cloud of points in the older message, whose fields are channels."""

    types = ("sensor_msgs/msg/PointCloud",)

    def _fields(self, message: Any) -> dict[str, NDArray[Any]]:
        points = np.array([(p.x, p.y, p.z) for p in message.points], np.float32).reshape(-1, 3)
        channels = {each.name: np.asarray(each.values, np.float32) for each in message.channels}
        if any(len(values) != len(points) for values in channels.values()):
            raise ValueError(f"a cloud of {len(points)} points has channels of another length")
        return channels | dict(zip("xyz", points.T, strict=True))


class DepthCloud(Display):
    """The points that a depth camera sees, coloured by their distance."""

    types = ("sensor_msgs/msg/Image",)
    topic, property = "camera/depth/image_raw", "Depth Map Topic"
    _camera: Any = None

    @dataclass(frozen=True)
    class Config:
        size_m: float = length_param(0.02, "Size of a point.", minimum=0.001, maximum=1.0)
        columns: int = param(160, "Columns of points at most.", minimum=16, maximum=1024)

    def wanted(self) -> tuple[Wanted, ...]:
        camera = "".join(self.name.rpartition("/")[:2]) + "camera_info"
        return Wanted(self.name, self.types), Wanted(camera, ("sensor_msgs/msg/CameraInfo",))

    def take(self, message: Any) -> Parts | None:
        if not hasattr(message, "encoding"):
            self._camera = message
        if self._camera is None or not hasattr(message, "encoding"):
            return None
        kind, unit = _METRES.get(message.encoding, ("", 0.0))
        (fx, _, cx), (_, fy, cy), _ = np.reshape(self._camera.k, (3, 3))
        if not kind or not fx * fy:
            raise ValueError(f"no depths: encoding '{message.encoding}', focal lengths {fx}, {fy}")
        rows = np.frombuffer(bytes(message.data), np.uint8).reshape(message.height, message.step)
        thin = max(1, -(-message.width // self.config.columns))
        pixels = np.ascontiguousarray(rows[:, : message.width * np.dtype(kind).itemsize])
        z = unit * pixels.view(kind)[::thin, ::thin].astype(np.float32)
        v, u = np.nonzero(np.isfinite(z) & (z > 0.0))
        z = z[v, u]
        points = np.column_stack([(thin * u - cx) * z / fx, (thin * v - cy) * z / fy, z])
        return {
            "": Points(
                frame=frame_of(message), stamp=seconds(message.header.stamp) or None,
                points=points.astype(np.float32), colour=rainbow(z), size=self.config.size_m,
            )
        }  # fmt: skip


class LaserScan(Display):
    """A laser scan."""

    types = ("sensor_msgs/msg/LaserScan",)
    topic = "scan"

    @dataclass(frozen=True)
    class Config:
        color_transformer: str = param(
            "FlatColor", "What colours the points.", choices=("FlatColor", "Intensity")
        )
        color: Colour = param((230, 30, 30), "Colour.")
        size_m: float = length_param(0.05, "Size of a point.", minimum=0.001, maximum=1.0)
        on_floor: bool = param(True, "Draw the points on the floor, not at the lidar's height.")
        decay_time: float = duration_param(0.0, "How long points stay; 0 until the next ones come.")

    def take(self, message: Any) -> Parts:
        config, scan = self.config, scan_from_msg(message)
        colour, valid = config.color, scan.valid
        angles, ranges = scan.angles[valid], scan.ranges[valid]
        if config.color_transformer == "Intensity":
            given = np.asarray(message.intensities, dtype=np.float32)
            colour = rainbow(given[valid] if len(given) == len(valid) else np.zeros(len(ranges)))
        points = np.stack([ranges * np.cos(angles), ranges * np.sin(angles), 0.0 * ranges], axis=1)
        return {
            "": Points(
                frame=frame_of(message), stamp=scan.stamp, points=points.astype(np.float32),
                colour=colour, size=config.size_m, floor=config.on_floor,
            )
        }  # fmt: skip
