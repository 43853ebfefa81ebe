"""Readings at a sensor: ranges, points, forces, motions, and values such as temperatures."""

from __future__ import annotations

import math
from dataclasses import dataclass, make_dataclass
from typing import Any, ClassVar

import numpy as np

from arjuna_core.param import length_param, param, share_param
from bringup.viewing.displays.base import Display, rainbow
from bringup.viewing.drawing.messages import frame_of
from bringup.viewing.drawing.solids import arrow_pose, solids
from bringup.viewing.drawing.values import Axes, Colour, Parts


class Range(Display):
    """A sonar's or infrared sensor's reading as its cone."""

    types = ("sensor_msgs/msg/Range",)
    topic = "range"

    @dataclass(frozen=True)
    class Config:
        color: Colour = param((60, 140, 255), "Colour.")
        alpha: float = share_param(0.5, "Opacity.")

    def take(self, message: Any) -> Parts:
        reach = float(message.range)
        if not math.isfinite(reach) or not message.min_range <= reach <= message.max_range:
            return {}
        width = 2.0 * reach * math.tan(min(message.field_of_view, 3.0) / 2.0)
        row = (  # a cone's tip is at the sensor, so it is turned round
            *((reach / 2.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), (reach, width, width)),
            *(self.config.color, self.config.alpha),
        )
        return {"": solids("cone", [row], frame=frame_of(message))}


class PointStamped(Display):
    """A point as a ball."""

    types = ("geometry_msgs/msg/PointStamped",)
    topic = "clicked_point"

    @dataclass(frozen=True)
    class Config:
        color: Colour = param((204, 41, 204), "Colour.")
        alpha: float = share_param(1.0, "Opacity.")
        radius: float = length_param(0.2, "Radius.", minimum=0.001, maximum=10.0)

    def take(self, message: Any) -> Parts:
        at = message.point
        if not all(map(math.isfinite, (at.x, at.y, at.z))):
            raise ValueError("its position is not finite")
        size = 3 * (2.0 * self.config.radius,)
        row = ((at.x, at.y, at.z), (1.0, 0.0, 0.0, 0.0), size, self.config.color, self.config.alpha)
        return {"": solids("sphere", [row], frame=frame_of(message))}


class _TwoVectors(Display):
    """A pair of vectors as arrows; `parts` names the message's field of them, and theirs."""

    parts: ClassVar[tuple[str, ...]]

    def take(self, message: Any) -> Parts:
        config, (field, *names) = self.config, self.parts
        rows: list[Any] = []
        for name in names:
            scale = getattr(config, f"{name}_arrow_scale")
            colour = getattr(config, f"{name}_color")
            vector = getattr(getattr(message, field), name)
            rows.append(_arrow(vector, scale, config.arrow_width, colour))
        return {"": solids("arrow", [row for row in rows if row], frame=frame_of(message))}


class Wrench(_TwoVectors):
    """A force and a torque as arrows."""

    types = ("geometry_msgs/msg/WrenchStamped",)
    topic = "wrench"
    parts = "wrench", "force", "torque"

    @dataclass(frozen=True)
    class Config:
        force_color: Colour = param((204, 51, 51), "Colour of the force.")
        torque_color: Colour = param((204, 204, 51), "Colour of the torque.")
        force_arrow_scale: float = length_param(2.0, "Length for 1 N.")
        torque_arrow_scale: float = length_param(2.0, "Length for 1 N m.")
        arrow_width: float = length_param(0.1, "Width.", minimum=0.001, maximum=10.0)


class TwistStamped(_TwoVectors):
    """A velocity and a rate of turning as arrows."""

    types = ("geometry_msgs/msg/TwistStamped",)
    topic = "twist"
    parts = "twist", "linear", "angular"

    @dataclass(frozen=True)
    class Config:
        linear_color: Colour = param((204, 51, 51), "Colour of what moves along.")
        angular_color: Colour = param((204, 204, 51), "Colour of what turns.")
        linear_arrow_scale: float = length_param(2.0, "Length for 1 in SI units.")
        angular_arrow_scale: float = length_param(2.0, "Length for 1 in SI units.")
        arrow_width: float = length_param(0.1, "Width.", minimum=0.001, maximum=10.0)


class AccelStamped(_TwoVectors):
    """An acceleration and one of turning as arrows."""

    types = ("geometry_msgs/msg/AccelStamped",)
    topic = "accel"
    parts = "accel", "linear", "angular"
    Config = TwistStamped.Config


class _Measured(Display):
    """A value as a ball where the sensor is, from red for the least to magenta."""

    value: ClassVar[str]

    def take(self, message: Any) -> Parts:
        config, value = self.config, float(getattr(message, self.value))
        if not math.isfinite(value):
            return {}
        (colour,) = rainbow([value], config.min_intensity, config.max_intensity)
        row = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), 3 * (config.size_m,), colour, config.alpha)
        return {"": solids("sphere", [row], frame=frame_of(message))}


def _scale(low: float, high: float) -> type[Any]:
    """Return the settings of a measured value, whose usual least and greatest these are."""
    rows: tuple[tuple[str, float, str, dict[str, Any]], ...] = (
        ("min_intensity", low, "Least value.", {}),
        ("max_intensity", high, "Greatest value.", {}),
        ("alpha", 1.0, "Opacity.", {"minimum": 0.0, "maximum": 1.0}),
        ("size_m", 0.1, "Size.", {"unit": "m", "minimum": 0.001, "maximum": 10.0}),
    )
    fields = [(name, float, param(value, what, **more)) for name, value, what, more in rows]
    return make_dataclass("Config", fields, frozen=True)


class Temperature(_Measured):
    """A temperature [deg C]."""

    types, topic, value = ("sensor_msgs/msg/Temperature",), "temperature", "temperature"
    Config = _scale(0.0, 100.0)


class RelativeHumidity(_Measured):
    """A humidity, 0 to 1."""

    types, topic = ("sensor_msgs/msg/RelativeHumidity",), "humidity"
    value, Config = "relative_humidity", _scale(0.0, 1.0)


class Illuminance(_Measured):
    """A light [lx]."""

    types, topic, value = ("sensor_msgs/msg/Illuminance",), "illuminance", "illuminance"
    Config = _scale(0.0, 1000.0)


class FluidPressure(_Measured):
    """A pressure [Pa]."""

    types, topic, value = ("sensor_msgs/msg/FluidPressure",), "pressure", "fluid_pressure"
    Config = _scale(98000.0, 105000.0)


class Imu(Display):
    """An IMU's orientation as axes, and its acceleration as an arrow."""

    types = ("sensor_msgs/msg/Imu",)
    topic = "imu/data"

    @dataclass(frozen=True)
    class Config:
        axes_scale: float = length_param(0.5, "Length of its axes.", minimum=0.01, maximum=10.0)
        acceleration_scale: float = length_param(0.05, "Length for 1 m/s2.")
        acceleration_color: Colour = param((255, 160, 0), "Colour of the acceleration.")

    def take(self, message: Any) -> Parts:
        turn, frame, config = message.orientation, frame_of(message), self.config
        arrow = _arrow(
            *(message.linear_acceleration, config.acceleration_scale, 0.05),
            config.acceleration_color,
        )
        wxyz = np.array([[turn.w, turn.x, turn.y, turn.z]], np.float32)
        if not np.isfinite(wxyz).all() or np.linalg.norm(wxyz) < 0.5:
            wxyz = np.array([[1.0, 0.0, 0.0, 0.0]], np.float32)  # an IMU that knows none
        origin = np.zeros((1, 3), np.float32)
        axes = Axes(frame=frame, positions=origin, wxyzs=wxyz, length=config.axes_scale)
        return {
            "axes": axes,
            "acceleration": solids("arrow", [arrow] if arrow else [], frame=frame),
        }


def _arrow(vector: Any, scale: float, width: float, colour: Colour) -> Any:
    """Return the row of an arrow from the origin; None where it is too short to be seen."""
    tip = scale * np.array([vector.x, vector.y, vector.z])
    if not np.isfinite(tip).all():
        raise ValueError("a vector is not finite")
    pose = arrow_pose(np.zeros(3), tip)
    return pose and (*pose[:2], (pose[2], width, width), colour, 1.0)
