"""Points as PointCloud2 messages."""

from __future__ import annotations

import array
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import PointCloud2, PointField

from arjuna_core.ros.convert import header

_TYPES = {"<f4": PointField.FLOAT32, "<u2": PointField.UINT16}


def cloud_msg(
    points: NDArray[Any],
    frame: str,
    now: float,
    channels: Mapping[str, NDArray[Any]] = MappingProxyType({}),
) -> PointCloud2:
    """Return points `(N, 3)` [m] at a time [s], and values `(N,)` of theirs by name."""
    others = [(name, values.dtype) for name, values in channels.items()]
    kind = np.dtype([*((axis, np.dtype("<f4")) for axis in "xyz"), *others])
    packed = np.zeros(len(points), kind)
    for name, values in (*zip("xyz", points.T, strict=True), *channels.items()):
        packed[name] = values
    data = array.array("B", packed.tobytes())
    layout = {"height": 1, "width": len(points), "point_step": kind.itemsize, "row_step": len(data)}
    stamped = header(frame, now)
    return PointCloud2(header=stamped, fields=_fields(kind), data=data, is_dense=True, **layout)


@cache
def _fields(kind: np.dtype[Any]) -> list[PointField]:
    assert kind.fields is not None
    return [
        PointField(name=name, offset=offset, datatype=_TYPES[each.str], count=1)
        for name, (each, offset, *_) in kind.fields.items()
    ]
