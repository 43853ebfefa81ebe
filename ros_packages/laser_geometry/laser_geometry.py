"""LaserProjection: a LaserScan as a PointCloud2."""

from __future__ import annotations

import numpy as np
from sensor_msgs.msg import LaserScan, PointCloud2, PointField
from sensor_msgs_py.point_cloud2 import create_cloud


class LaserProjection:
    """Projects scans into the frame of their laser."""

    LASER_SCAN_INVALID = -1.0
    LASER_SCAN_MIN_RANGE = -2.0
    LASER_SCAN_MAX_RANGE = -3.0

    class ChannelOption:
        """The fields that a cloud has beside x, y, z; they can be added."""

        NONE = 0x00
        INTENSITY = 0x01
        INDEX = 0x02
        DISTANCE = 0x04
        TIMESTAMP = 0x08
        VIEWPOINT = 0x10
        DEFAULT = INTENSITY | INDEX

    def projectLaser(
        self,
        scan_in: LaserScan,
        range_cutoff: float = -1.0,
        channel_options: int = ChannelOption.DEFAULT,
    ) -> PointCloud2:
        """Return the returns from the least range up to a range as a cloud.

        Args:
            range_cutoff: Where returns end [m]; the scan's greatest range if negative.
        """
        count, option = len(scan_in.ranges), self.ChannelOption
        ranges = np.asarray(scan_in.ranges, np.float64)
        angles = scan_in.angle_min + np.arange(count) * scan_in.angle_increment
        columns = {"x": ranges * np.cos(angles), "y": ranges * np.sin(angles), "z": np.zeros(count)}
        if channel_options & option.INTENSITY and len(scan_in.intensities) == count:
            columns["intensity"] = np.asarray(scan_in.intensities, np.float64)
        if channel_options & option.INDEX:
            columns["index"] = np.arange(count, dtype=np.float64)
        if channel_options & option.DISTANCE:
            columns["distances"] = ranges
        if channel_options & option.TIMESTAMP:
            columns["stamps"] = np.arange(count) * scan_in.time_increment
        if channel_options & option.VIEWPOINT:
            columns |= dict.fromkeys(("vp_x", "vp_y", "vp_z"), np.zeros(count))
        farthest = range_cutoff if range_cutoff >= 0.0 else scan_in.range_max
        with np.errstate(invalid="ignore"):
            kept = (ranges < farthest) & (ranges >= scan_in.range_min)
        fields = [
            PointField(
                name=name,
                offset=4 * number,
                datatype=PointField.INT32 if name == "index" else PointField.FLOAT32,
                count=1,
            )
            for number, name in enumerate(columns)
        ]
        return create_cloud(scan_in.header, fields, np.column_stack(list(columns.values()))[kept])
