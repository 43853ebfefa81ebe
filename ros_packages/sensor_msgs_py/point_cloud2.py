"""PointCloud2 messages as NumPy arrays, and back."""

from __future__ import annotations

import array
from collections import namedtuple
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.lib.recfunctions import structured_to_unstructured, unstructured_to_structured
from numpy.typing import NDArray
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

_TYPES = ("int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64")
_DATATYPES = {getattr(PointField, name.upper()): np.dtype(name) for name in _TYPES}
DUMMY_FIELD_PREFIX = "unnamed_field"


def dtype_from_fields(fields: Iterable[PointField], point_step: int | None = None) -> np.dtype[Any]:
    """Return the structured type of a point with such fields."""
    names: list[str] = []
    offsets: list[int] = []
    formats: list[np.dtype[Any]] = []
    for number, field in enumerate(fields):
        each = _DATATYPES[field.datatype]
        name = field.name or f"{DUMMY_FIELD_PREFIX}_{number}"
        count = max(1, field.count)
        for part in range(count):
            names.append(name if count == 1 else f"{name}_{part}")
            offsets.append(field.offset + part * each.itemsize)
            formats.append(each)
    layout: Any = {"names": names, "formats": formats, "offsets": offsets}
    if point_step is not None:
        layout["itemsize"] = point_step
    kind: np.dtype[Any] = np.dtype(layout)
    return kind


def read_points(
    cloud: PointCloud2,
    field_names: Sequence[str] | None = None,
    skip_nans: bool = False,
    uvs: Iterable[Any] | None = None,
    reshape_organized_cloud: bool = False,
) -> NDArray[Any]:
    """Return the points as a structured array.

    Args:
        field_names: The fields that are read; all if None.
        skip_nans: Whether points with a NaN in them are left out.
        uvs: Which points, by number or by column and row; all if None.
        reshape_organized_cloud: Whether an organized cloud has rows and columns.
    """
    kind = dtype_from_fields(cloud.fields, cloud.point_step)
    row = cloud.width * cloud.point_step
    data = np.frombuffer(bytes(cloud.data), np.uint8)
    if cloud.row_step != row:  # rows with something behind them
        data = data.reshape(cloud.height, cloud.row_step)[:, :row].ravel()
    points: NDArray[Any] = data.view(kind)
    if (cloud.is_bigendian != 0) != (np.little_endian is False):
        points = points.byteswap()
    if field_names is not None:
        missing = [name for name in field_names if name not in (kind.names or ())]
        assert not missing, "Requests field is not in the fields list!"
        points = points[list(field_names)]
    if skip_nans and not cloud.is_dense:
        valid = np.ones(len(points), bool)
        for name in points.dtype.names or ():
            valid &= ~np.isnan(points[name])
        points = points[valid]
    if uvs is not None:
        chosen = np.array(list(uvs))
        points = points[chosen[:, 1] * cloud.width + chosen[:, 0] if chosen.ndim == 2 else chosen]
    if reshape_organized_cloud and cloud.height > 1:
        points = points.reshape(cloud.width, cloud.height)
    return points


def read_points_numpy(
    cloud: PointCloud2,
    field_names: Sequence[str] | None = None,
    skip_nans: bool = False,
    uvs: Iterable[Any] | None = None,
    reshape_organized_cloud: bool = False,
) -> NDArray[Any]:
    """Return the points as a plain array `(N, fields)`; the fields must be of one type."""
    kinds = {f.datatype for f in cloud.fields if field_names is None or f.name in field_names}
    assert len(kinds) <= 1, "All fields need to have the same datatype. Use `read_points()`."
    points = read_points(cloud, field_names, skip_nans, uvs, reshape_organized_cloud)
    plain: NDArray[Any] = structured_to_unstructured(points)
    return plain


def read_points_list(
    cloud: PointCloud2,
    field_names: Sequence[str] | None = None,
    skip_nans: bool = False,
    uvs: Iterable[Any] | None = None,
) -> list[Any]:
    points = read_points(cloud, field_names, skip_nans, uvs)
    kinds: Any = namedtuple  # whose names are known here alone
    Point = kinds("Point", points.dtype.names or ())
    return [Point._make(point) for point in points.tolist()]


def create_cloud(
    header: Header,
    fields: Sequence[PointField],
    points: Any,
    step: int | None = None,
    point_step: int | None = None,
) -> PointCloud2:
    """Return points, `(N, fields)`, `(H, W, fields)` or structured, as a message."""
    kind = dtype_from_fields(fields, step if step is not None else point_step)
    given = points if isinstance(points, np.ndarray) else None
    if given is None:
        given = np.array([tuple(point) for point in points], kind)
    elif given.dtype.names is None:
        assert given.shape[-1] == len(kind.names or ()), "The fields do not match the points"
        given = unstructured_to_structured(given, kind)
    packed = np.zeros(given.shape, kind)
    for name in kind.names or ():
        packed[name] = given[name]
    height, width = packed.shape if packed.ndim == 2 else (1, len(packed))
    return PointCloud2(
        header=header,
        height=height,
        width=width,
        fields=list(fields),
        is_dense=False,
        is_bigendian=False,
        point_step=kind.itemsize,
        row_step=kind.itemsize * width,
        data=array.array("B", packed.tobytes()),
    )


def create_cloud_xyz32(
    header: Header, points: Any, step: int | None = None, point_step: int | None = None
) -> PointCloud2:
    """Return points of x, y, z as a message of float32."""
    fields = [
        PointField(name=name, offset=4 * number, datatype=PointField.FLOAT32, count=1)
        for number, name in enumerate("xyz")
    ]
    return create_cloud(header, fields, points, step, point_step)
