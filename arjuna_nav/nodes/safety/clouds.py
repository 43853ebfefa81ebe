"""Points of a cloud between two heights."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.pose3 import Pose3
from arjuna_core.ros.convert import cloud_from_msg

_MOST = 1_000_000  # points of a cloud; of more every second, third, ... is taken
_SCALARS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}


def cloud_points(message: Any, mount: Pose3, config: Any) -> NDArray[np.float64] | None:
    """Return a cloud's points between two heights, `(N, 2) float64` in the base frame [m].

    None where it lacks the field that is to say their height.

    Args:
        message: A PointCloud2.
        mount: Pose of its frame in the base.
        config: Heights, least range, and whether the field `height` counts, a `PointCloudConfig`.
    """
    cloud = cloud_from_msg(message, mount, _MOST)
    heights = cloud.points[:, 2]
    if config.use_global_height:
        own = _field(message, "height")
        if own is None:
            return None
        heights = own
    far = np.linalg.norm(cloud.points - np.array(mount.position), axis=1) >= config.min_range
    kept = far & (heights >= config.min_height) & (heights <= config.max_height)
    points: NDArray[np.float64] = cloud.points[kept, :2]
    return points


def _field(message: Any, name: str) -> NDArray[np.float64] | None:
    """Return a field of those of a cloud's points that are finite, None where it has none."""
    order = ">" if message.is_bigendian else "<"
    fields = {each.name: each for each in message.fields}
    if name not in fields:
        return None
    named = [fields[key] for key in ("x", "y", "z", name)]
    kind = np.dtype(
        {
            "names": [each.name for each in named],
            "formats": [order + _SCALARS[each.datatype] for each in named],
            "offsets": [each.offset for each in named],
            "itemsize": message.point_step,
        }
    )
    shape, strides = (message.height, message.width), (message.row_step, message.point_step)
    packed: NDArray[Any] = np.ndarray(shape, kind, np.asarray(message.data), strides=strides)
    rows = packed.ravel()
    finite = np.isfinite(rows["x"]) & np.isfinite(rows["y"]) & np.isfinite(rows["z"])
    values: NDArray[np.float64] = rows[name][finite].astype(np.float64)
    return values
