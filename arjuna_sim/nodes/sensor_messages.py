"""What a robot's further sensors say, as messages."""

from __future__ import annotations

import array

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import (
    MagneticField,
    NavSatFix,
    NavSatStatus,
    PointCloud2,
    PointField,
    Range,
)

from arjuna_core.ros.convert import header
from arjuna_sim.devices.place_sensors import Fix
from arjuna_sim.model.settings import MagnetometerSettings, NavSatSettings, RangeSettings

_FLOAT, _UINT16 = np.dtype("<f4"), np.dtype("<u2")
_POINT = np.dtype([("x", _FLOAT), ("y", _FLOAT), ("z", _FLOAT), ("ring", _UINT16)])
_FIELDS = [
    PointField(name=name, offset=4 * number, datatype=kind, count=1)
    for number, (name, kind) in enumerate(
        (*((axis, PointField.FLOAT32) for axis in "xyz"), ("ring", PointField.UINT16))
    )
]


def cloud_msg(
    points: NDArray[np.float32], rows: NDArray[np.uint16] | None, frame: str, now: float
) -> PointCloud2:
    """Return points at a time [s] as a PointCloud2 message with the fields x, y, z and ring.

    Args:
        points: `(N, 3) float32` [m].
        rows: Which row of the sensor each is of; None leaves out the field.
        frame: Their frame.
        now: When they were seen [s].
    """
    kind = _POINT if rows is not None else np.dtype(_POINT.descr[:3])
    packed = np.zeros(len(points), kind)
    packed["x"], packed["y"], packed["z"] = points.T
    if rows is not None:
        packed["ring"] = rows
    return PointCloud2(
        header=header(frame, now),
        height=1,
        width=len(points),
        fields=_FIELDS[: 3 + (rows is not None)],
        is_bigendian=False,
        point_step=kind.itemsize,
        row_step=kind.itemsize * len(points),
        data=array.array("B", packed.tobytes()),
        is_dense=True,
    )


def range_msg(sensor: RangeSettings, reading: float, now: float) -> Range:
    """Return the nearest range at a time [s] as a Range message."""
    return Range(
        header=header(sensor.frame, now),
        radiation_type=Range.INFRARED if sensor.infrared else Range.ULTRASOUND,
        field_of_view=sensor.angle_max - sensor.angle_min,
        min_range=sensor.range_min,
        max_range=sensor.range_max,
        range=reading,
    )


def fix_msg(sensor: NavSatSettings, reading: Fix, now: float) -> NavSatFix:
    """Return a place on Earth at a time [s] as a NavSatFix message."""
    return NavSatFix(
        header=header(sensor.frame, now),
        status=NavSatStatus(status=NavSatStatus.STATUS_FIX, service=NavSatStatus.SERVICE_GPS),
        latitude=reading.place.latitude_deg,
        longitude=reading.place.longitude_deg,
        altitude=reading.place.altitude,
        position_covariance=np.diag(reading.variance).ravel(),
        position_covariance_type=NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN,
    )


def field_msg(
    sensor: MagnetometerSettings, reading: NDArray[np.float64], now: float
) -> MagneticField:
    """Return a magnetic field at a time [s] as a MagneticField message."""
    message = MagneticField(header=header(sensor.frame, now))
    field = message.magnetic_field
    field.x, field.y, field.z = (float(value) for value in reading)
    message.magnetic_field_covariance = np.eye(3).ravel() * sensor.noise**2
    return message
