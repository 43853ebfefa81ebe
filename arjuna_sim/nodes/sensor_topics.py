"""Topics of the sensors that a robot has beside its first lidar, camera and IMU.

A kind of sensor registers its message here, by `publishes`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from geometry_msgs.msg import PointStamped
from numpy.typing import NDArray
from sensor_msgs.msg import (
    Imu,
    LaserScan,
    MagneticField,
    NavSatFix,
    NavSatStatus,
    PointCloud2,
    Range,
)
from std_msgs.msg import Bool

from arjuna_core.ros import qos
from arjuna_core.ros.clouds import cloud_msg
from arjuna_core.ros.convert import header, scan_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.timing import Periodic
from arjuna_sim.devices.imu import ImuReading
from arjuna_sim.devices.lidar import Cloud
from arjuna_sim.devices.sensors.altimeter import AltimeterSettings
from arjuna_sim.devices.sensors.bumper import BumperSettings
from arjuna_sim.devices.sensors.imu import ImuSettings
from arjuna_sim.devices.sensors.lidar import CloudSettings, LidarSettings, RangeSettings
from arjuna_sim.devices.sensors.magnetometer import MagnetometerSettings
from arjuna_sim.devices.sensors.navsat import Fix, NavSatSettings
from arjuna_sim.driven_robot import DrivenRobot
from arjuna_sim.model.settings import SensorSettings
from arjuna_sim.nodes.messages import imu_msg

Convert = Callable[[Any, Any, float], Any]
"""Returns the message of a sensor's settings, its reading and the time [s]."""
_messages: dict[type[SensorSettings], tuple[Any, Convert]] = {}


def publishes(kind: type[SensorSettings], message_type: Any) -> Callable[[Convert], Convert]:
    """Register the message of a kind of sensor, and what makes one of a reading."""

    def registered(convert: Convert) -> Convert:
        _messages[kind] = message_type, convert
        return convert

    return registered


@publishes(LidarSettings, LaserScan)
def _scan(sensor: LidarSettings, reading: Any, now: float) -> LaserScan:
    return scan_msg(reading, sensor.frame, 1.0 / sensor.rate)


@publishes(CloudSettings, PointCloud2)
def _cloud(sensor: CloudSettings, reading: Cloud, now: float) -> PointCloud2:
    rows = {} if reading.rows is None else {"ring": reading.rows}
    return cloud_msg(reading.points, sensor.frame, now, rows)


@publishes(RangeSettings, Range)
def _range(sensor: RangeSettings, reading: float, now: float) -> Range:
    return Range(
        header=header(sensor.frame, now),
        radiation_type=Range.INFRARED if sensor.infrared else Range.ULTRASOUND,
        field_of_view=sensor.angle_max - sensor.angle_min,
        min_range=sensor.range_min,
        max_range=sensor.range_max,
        range=reading,
    )


@publishes(ImuSettings, Imu)
def _imu(sensor: ImuSettings, reading: ImuReading, now: float) -> Imu:
    return imu_msg(reading, sensor.frame, now)


@publishes(NavSatSettings, NavSatFix)
def _fix(sensor: NavSatSettings, reading: Fix, now: float) -> NavSatFix:
    return NavSatFix(
        header=header(sensor.frame, now),
        status=NavSatStatus(status=NavSatStatus.STATUS_FIX, service=NavSatStatus.SERVICE_GPS),
        latitude=reading.position.latitude_deg,
        longitude=reading.position.longitude_deg,
        altitude=reading.position.altitude,
        position_covariance=np.diag(reading.variance).ravel(),
        position_covariance_type=NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN,
    )


@publishes(MagnetometerSettings, MagneticField)
def _field(sensor: MagnetometerSettings, reading: NDArray[np.float64], now: float) -> MagneticField:
    message = MagneticField(header=header(sensor.frame, now))
    field = message.magnetic_field
    field.x, field.y, field.z = (float(value) for value in reading)
    message.magnetic_field_covariance = np.eye(3).ravel() * sensor.noise**2
    return message


@publishes(AltimeterSettings, PointStamped)
def _height(sensor: AltimeterSettings, reading: float, now: float) -> PointStamped:
    message = PointStamped(header=header(sensor.frame, now))
    message.point.z = reading
    return message


@publishes(BumperSettings, Bool)
def _bump(sensor: BumperSettings, reading: bool, now: float) -> Bool:
    return Bool(data=reading)


class SensorTopics:
    """Publishes what is due and subscribed to; sensors without subscribers are not read."""

    def __init__(
        self, node: ManagedNode, robot: DrivenRobot, sensors: tuple[SensorSettings, ...]
    ) -> None:
        self._robot = robot
        self._all = [
            (sensor, node.publisher(kind, sensor.topic, qos.SENSOR_PUBLISHER), convert, due)
            for sensor in sensors
            if type(sensor) in _messages
            for kind, convert in (_messages[type(sensor)],)
            for due in (Periodic(1.0 / sensor.rate, phase=1.0 / sensor.rate),)
        ]

    def publish(self, now: float) -> None:
        """Publish what is due at a time [s]."""
        for sensor, out, convert, due in self._all:
            if due.due(now) and out.get_subscription_count() > 0:
                out.publish(convert(sensor, self._robot.sense(sensor, now), now))
