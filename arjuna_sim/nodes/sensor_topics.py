"""Topics of the sensors that a robot has beside its first lidar, camera and IMU."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import PointStamped
from sensor_msgs.msg import Imu, LaserScan, MagneticField, NavSatFix, PointCloud2, Range
from std_msgs.msg import Bool

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, scan_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.timing import Periodic
from arjuna_sim.driven_robot import DrivenRobot
from arjuna_sim.model.settings import (
    AltimeterSettings,
    BumperSettings,
    CloudSettings,
    ImuSettings,
    LidarSettings,
    MagnetometerSettings,
    NavSatSettings,
    RangeSettings,
    SensorSettings,
)
from arjuna_sim.nodes.messages import imu_msg
from arjuna_sim.nodes.sensor_messages import cloud_msg, field_msg, fix_msg, range_msg

_Convert = Callable[[Any, Any, float], Any]


def _scan(sensor: LidarSettings, reading: Any, now: float) -> LaserScan:
    return scan_msg(reading, sensor.frame, 1.0 / sensor.rate)


def _cloud(sensor: CloudSettings, reading: Any, now: float) -> PointCloud2:
    return cloud_msg(reading.points, reading.rows, sensor.frame, now)


def _imu(sensor: ImuSettings, reading: Any, now: float) -> Imu:
    return imu_msg(reading, sensor.frame, now)


def _height(sensor: AltimeterSettings, reading: float, now: float) -> PointStamped:
    message = PointStamped(header=header(sensor.frame, now))
    message.point.z = reading
    return message


def _bump(sensor: BumperSettings, reading: bool, now: float) -> Bool:
    return Bool(data=reading)


_TYPES: dict[type[SensorSettings], tuple[Any, _Convert]] = {
    LidarSettings: (LaserScan, _scan),
    CloudSettings: (PointCloud2, _cloud),
    RangeSettings: (Range, range_msg),
    ImuSettings: (Imu, _imu),
    NavSatSettings: (NavSatFix, fix_msg),
    MagnetometerSettings: (MagneticField, field_msg),
    AltimeterSettings: (PointStamped, _height),
    BumperSettings: (Bool, _bump),
}
"""By kind of sensor, the message's type and what makes one of a reading."""


class SensorTopics:
    """Publishes what is due and subscribed to; what nobody listens to is not read.

    Args:
        node: The node, being configured.
        robot: Has the sensors.
        sensors: The sensors, with their topics and frames; cameras have topics of their own.
    """

    def __init__(
        self, node: ManagedNode, robot: DrivenRobot, sensors: tuple[SensorSettings, ...]
    ) -> None:
        self._robot = robot
        self._all = [
            (sensor, node.publisher(kind, sensor.topic, qos.SENSOR_PUBLISHER), convert, due)
            for sensor in sensors
            if type(sensor) in _TYPES
            for kind, convert in (_TYPES[type(sensor)],)
            for due in (Periodic(1.0 / sensor.rate, phase=1.0 / sensor.rate),)
        ]

    def publish(self, now: float) -> None:
        """Publish what is due at a time [s]."""
        for sensor, out, convert, due in self._all:
            if due.due(now) and out.get_subscription_count() > 0:
                out.publish(convert(sensor, self._robot.sense(sensor, now), now))
