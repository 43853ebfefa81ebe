"""Clouds of points as messages: their layouts, and what is refused."""

from __future__ import annotations

import array
from typing import Any

import numpy as np
import pytest
from sensor_msgs.msg import PointCloud2, PointField

from arjuna_core.pose3 import Pose3
from arjuna_core.ros.convert import cloud_from_msg
from arjuna_core.ros.health.rules import cloud_problem

POINTS = np.array([[1.0, 2.0, 3.0], [-0.5, 0.25, 4.0], [7.0, 0.0, -1.0], [2.0, 2.0, 2.0]])


def message(reals: str = "<f4", gap: int = 0, rows: int = 1, **changes: Any) -> PointCloud2:
    """Return the points as a message; `gap` bytes stand before x and after each row."""
    kind = np.dtype(reals)
    packed = np.dtype(
        {
            "names": ["z", "x", "y"],
            "formats": [kind] * 3,
            "offsets": [gap + k * kind.itemsize for k in range(3)],
            "itemsize": gap + 3 * kind.itemsize,
        }
    )
    cells = np.zeros(len(POINTS), packed)
    for k, name in enumerate("xyz"):
        cells[name] = POINTS[:, k]
    width = len(POINTS) // rows
    lines = [cells[r * width : (r + 1) * width].tobytes() + bytes(gap) for r in range(rows)]
    sort = PointField.FLOAT32 if kind.itemsize == 4 else PointField.FLOAT64
    fields = [
        PointField(name=name, offset=gap + k * kind.itemsize, datatype=sort, count=1)
        for k, name in enumerate("zxy")
    ]
    values = {
        "height": rows,
        "width": width,
        "fields": fields,
        "is_bigendian": reals[0] == ">",
        "point_step": packed.itemsize,
        "row_step": len(lines[0]),
        "data": array.array("B", b"".join(lines)),
    }
    return PointCloud2(**{**values, **changes})


@pytest.mark.parametrize("reals", ["<f4", ">f4", "<f8", ">f8"])
@pytest.mark.parametrize(("gap", "rows"), [(0, 1), (3, 1), (8, 2), (0, 4)])
def test_every_layout_gives_the_same_points(reals: str, gap: int, rows: int) -> None:
    found = message(reals, gap, rows)
    assert cloud_problem(found) is None
    mount = Pose3.from_rpy((0.5, 0.0, 1.0), (0.0, 0.0, np.pi / 2))
    cloud = cloud_from_msg(found, mount)
    expected = np.column_stack((0.5 - POINTS[:, 1], POINTS[:, 0], POINTS[:, 2] + 1.0))
    assert cloud.points == pytest.approx(expected)
    assert cloud.sensor == pytest.approx([0.5, 0.0, 1.0])


def test_points_that_are_none_are_left_out() -> None:
    found = message("<f8")
    np.frombuffer(found.data, np.float64)[1] = np.nan
    assert len(cloud_from_msg(found, Pose3()).points) == len(POINTS) - 1
    empty = message(width=0, height=0, row_step=0, data=array.array("B"), fields=[])
    assert cloud_problem(empty) is None
    assert cloud_from_msg(empty, Pose3()).points.shape == (0, 3)


def test_of_many_points_some_are_taken_all_over() -> None:
    found = cloud_from_msg(message(rows=2), Pose3(), most=2)
    assert found.points == pytest.approx(POINTS[::2])


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"width": 5}, "12 bytes each, 48 bytes a row"),
        ({"height": 2}, "2 rows of 4 points"),
        ({"row_step": 40}, "40 bytes a row"),
        ({"point_step": 8, "row_step": 32}, "'y' is no field of a point"),
        ({"fields": []}, "'x' is no field"),
        ({"fields": [PointField(name="x", offset=0, datatype=2, count=1)]}, "'x' is no field"),
        ({"fields": [PointField(name="x", offset=2**32 - 1, datatype=7, count=1)]}, "'x' is no"),
    ],
)
def test_what_cannot_be_is_said(changes: dict[str, Any], says: str) -> None:
    assert says in str(cloud_problem(message(**changes)))
