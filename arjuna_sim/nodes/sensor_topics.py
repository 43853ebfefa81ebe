"""Topics of the sensors that a robot has beside its first lidar, camera and IMU.

A kind of sensor registers its message here, by `publishes`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from gazebo_msgs.msg import ContactsState, ContactState
from geometry_msgs.msg import Vector3, Wrench
from nav_msgs.msg import Odometry
from ros_gz_interfaces.msg import Altimeter, Contact, Contacts, Entity, JointWrench
from sensor_msgs.msg import (
    BatteryState,
    Imu,
    LaserScan,
    MagneticField,
    NavSatFix,
    NavSatStatus,
    PointCloud2,
    Range,
)
from std_msgs.msg import String

from arjuna_core.arrays import Floats
from arjuna_core.ros import qos
from arjuna_core.ros.convert import cloud_msg, header, pose3_msg, scan_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.timing import Periodic
from arjuna_sim.devices.imu import ImuReading
from arjuna_sim.devices.lidar import Cloud
from arjuna_sim.devices.sensors.altimeter import AltimeterSettings, Climb
from arjuna_sim.devices.sensors.battery import BatterySettings, Charge
from arjuna_sim.devices.sensors.bumper import BumperSettings, ContactSettings, Touch
from arjuna_sim.devices.sensors.imu import ImuSettings
from arjuna_sim.devices.sensors.lidar import CloudSettings, LidarSettings, RangeSettings
from arjuna_sim.devices.sensors.magnetometer import MagnetometerSettings
from arjuna_sim.devices.sensors.navsat import Fix, NavSatSettings
from arjuna_sim.devices.sensors.true_odometry import TrueMotion, TrueOdometrySettings
from arjuna_sim.model.settings import SensorSettings
from arjuna_sim.nodes.messages import WORLD, imu_msg, twist_msg
from arjuna_sim.staged_sensors import StagedSensors

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
    dark = np.zeros(len(reading.points), np.float32)  # as of what has no `laser_retro` in Gazebo
    rows = {} if reading.rows is None else {"ring": reading.rows}
    return cloud_msg(reading.points, sensor.frame, now, {"intensity": dark, **rows})


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
def _field(sensor: MagnetometerSettings, reading: Floats, now: float) -> MagneticField:
    message = MagneticField(header=header(sensor.frame, now))
    field = message.magnetic_field
    field.x, field.y, field.z = (float(value) for value in reading)
    message.magnetic_field_covariance = np.eye(3).ravel() * sensor.noise**2
    return message


@publishes(AltimeterSettings, Altimeter)
def _height(sensor: AltimeterSettings, reading: Climb, now: float) -> Altimeter:
    return Altimeter(
        header=header(sensor.frame, now),
        vertical_position=reading.height,
        vertical_velocity=reading.speed,
        vertical_reference=reading.start,
    )


@publishes(BatterySettings, BatteryState)
def _battery(sensor: BatterySettings, reading: Charge, now: float) -> BatteryState:
    return BatteryState(
        header=header(sensor.frame, now),
        voltage=reading.voltage,
        current=-reading.current,  # drawn is negative, and charges positive
        charge=reading.charge,
        capacity=sensor.capacity,
        design_capacity=sensor.capacity,
        percentage=reading.percentage,
        power_supply_status=reading.supply.value,
        present=True,
    )


@publishes(BumperSettings, ContactsState)
def _bump(sensor: BumperSettings, reading: tuple[Touch, ...], now: float) -> ContactsState:
    frame = WORLD if sensor.in_world else sensor.frame
    states = [
        ContactState(
            info=f"{touch.own} touches {touch.other}",
            collision1_name=touch.own,
            collision2_name=touch.other,
            wrenches=[Wrench(force=force) for force in _vectors(touch.forces)],
            total_wrench=Wrench(force=_vectors(touch.forces.sum(axis=0)[None])[0]),
            contact_positions=_vectors(touch.positions),
            contact_normals=_vectors(touch.normals),
            depths=touch.depths.tolist(),
        )
        for touch in reading
    ]
    return ContactsState(header=header(frame, now), states=states)


@publishes(ContactSettings, Contacts)
def _contacts(sensor: ContactSettings, reading: tuple[Touch, ...], now: float) -> Contacts:
    stamp = header(WORLD, now)
    contacts = [
        Contact(
            collision1=Entity(name=touch.own, type=Entity.COLLISION),
            collision2=Entity(name=touch.other, type=Entity.COLLISION),
            positions=_vectors(touch.positions),
            normals=_vectors(touch.normals),
            depths=touch.depths.tolist(),
            wrenches=[_wrench(touch, stamp, force) for force in touch.forces],
        )
        for touch in reading
    ]
    return Contacts(header=stamp, contacts=contacts)


def _wrench(touch: Touch, stamp: Any, force: Floats) -> JointWrench:
    upon, back = _vectors(np.array([force, -force]))
    return JointWrench(
        header=stamp,
        body_1_name=String(data=touch.own),
        body_2_name=String(data=touch.other),
        body_1_wrench=Wrench(force=upon),
        body_2_wrench=Wrench(force=back),
    )


def _vectors(rows: Floats) -> list[Vector3]:
    return [Vector3(x=x, y=y, z=z) for x, y, z in rows.tolist()]


@publishes(TrueOdometrySettings, Odometry)
def _truth(sensor: TrueOdometrySettings, reading: TrueMotion, now: float) -> Odometry:
    message = Odometry(header=header(sensor.world_frame, now), child_frame_id=sensor.frame)
    message.pose.pose = pose3_msg(reading.pose)
    message.twist.twist = twist_msg(reading.twist)
    message.pose.covariance = message.twist.covariance = np.eye(6).ravel() * sensor.noise**2
    return message


class SensorTopics:
    """Publishes what is due and subscribed to; sensors without subscribers are not read."""

    def __init__(
        self,
        node: ManagedNode,
        robot: StagedSensors,
        sensors: tuple[SensorSettings, ...],
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
