"""Claims: what becomes a message is on the wire what it was, whole numbers too."""

from __future__ import annotations

import array
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Pose, TransformStamped
from nav_msgs.msg import Path
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import PointCloud2, PointField

from arjuna_core.pose3 import Pose3
from arjuna_core.ros.convert import (
    cloud_from_msg,
    header,
    path_msg,
    pose_msg,
    pose_stamped,
    se2_from_pose,
    se2_from_transform,
    transform_msg,
)
from arjuna_core.ros.health.rules import cloud_problem
from arjuna_core.se2 import SE2


def sent(message: Any, kind: type) -> Any:
    """Return a message as another process gets it."""
    return deserialize_message(serialize_message(message), kind)


@pytest.mark.parametrize("pose", [SE2(2, -1, 0), SE2(2.5, -1.25, 0.5)])
def test_a_pose_and_a_transform_arrive_as_they_were(pose: SE2) -> None:
    found = se2_from_pose(sent(pose_msg(pose), Pose))
    transform = sent(transform_msg(pose, "map", "odom", 1.0), TransformStamped)
    for one in (found, se2_from_transform(transform.transform)):
        assert one.array() == pytest.approx(pose.array())


@pytest.mark.parametrize("count", [0, 1, 40])
@pytest.mark.parametrize("kind", [float, int])
def test_a_path_is_what_rclpy_makes_of_its_poses(count: int, kind: type) -> None:
    poses: NDArray[Any] = np.random.default_rng(1).uniform(-9.0, 9.0, (count, 3)).astype(kind)
    stamped = [pose_stamped(SE2.from_array(pose), "map", 7.25) for pose in poses]
    plain = Path(header=header("map", 7.25), poses=stamped)
    made = path_msg(poses, "map", 7.25)
    assert made == plain
    assert sent(made, Path) == plain


def test_each_pose_of_a_path_is_its_own() -> None:
    made = path_msg(np.zeros((2, 3)), "map", 1.0)
    made.poses[0].header.stamp.sec = 5
    made.poses[0].header.frame_id = "odom"
    made.poses[0].pose.position.x = 3.0
    assert made.poses[1] == pose_stamped(SE2(), "map", 1.0)
    assert made.header == header("map", 1.0)


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


def test_points_that_are_not_finite_are_left_out() -> None:
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
