"""navsat_transform_node: GPS fixes as odometry in the world frame, and back."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from geographic_msgs.msg import GeoPoint as GeoPointMsg
from geometry_msgs.msg import Point
from nav_msgs.msg import Odometry
from robot_localization.srv import FromLL, FromLLArray, SetDatum, ToLL, ToLLArray
from sensor_msgs.msg import Imu, NavSatFix, NavSatStatus
from tf2_msgs.msg import TFMessage

from arjuna_core.config import duration_param, fixed, param
from arjuna_core.errors import ConfigError
from arjuna_core.geodesy import GeoPoint
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, pose3_msg, seconds, transform3_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError, transforms_msg
from arjuna_sim.fusion.earth import EarthFrame
from arjuna_sim.nodes.localization.filter_node import pose_of, unit

_FRAMES = {True: "local_enu", False: "utm"}  # robot_localization's names of the planes' frames


@dataclass(frozen=True)
class NavsatConfig:
    """Parameters of `navsat_transform_node`."""

    frequency: float = param(10.0, "Rate of the output.", unit="Hz", minimum=0.1, maximum=1000.0)
    delay: float = duration_param(0.0, "Time from the start before the first fix counts.")
    magnetic_declination_radians: float = fixed(
        0.0, "What is added to a compass's heading for true north.", unit="rad"
    )
    yaw_offset: float = fixed(
        0.0, "What is added for an IMU that is not 0 facing east.", unit="rad"
    )
    zero_altitude: bool = param(False, "Whether the odometry's height is 0.")
    publish_filtered_gps: bool = fixed(False, "Whether gps/filtered is published.")
    use_odometry_yaw: bool = fixed(False, "Whether the heading is the odometry's, not the IMU's.")
    wait_for_datum: bool = fixed(
        False, "Whether the origin is `datum` or comes by the service datum."
    )
    datum: tuple[float, ...] = fixed(
        (), "Latitude and longitude [degree], heading [rad] of the world's origin."
    )
    broadcast_cartesian_transform: bool = fixed(
        False, "Whether the transform of 'utm' or 'local_enu' is published."
    )
    broadcast_cartesian_transform_as_parent_frame: bool = fixed(
        False, "Whether that frame is the world frame's parent."
    )
    broadcast_utm_transform: bool = fixed(False, "Older name of broadcast_cartesian_transform.")
    broadcast_utm_transform_as_parent_frame: bool = fixed(
        False, "Older name of broadcast_cartesian_transform_as_parent_frame."
    )
    use_local_cartesian: bool = fixed(
        False,
        "Whether the plane that touches the earth at the datum is used, rather than UTM's grid,"
        " whose distances are up to 0.04 % off.",
    )
    imu_topic: str = fixed("imu", "Topic of the IMU.")
    gps_topic: str = fixed("gps/fix", "Topic of the receiver.")
    odom_topic: str = fixed("odometry/filtered", "Topic of the filter's output.")

    def __post_init__(self) -> None:
        if len(self.datum) not in (0, 3):
            problem = f"'datum' has {len(self.datum)} values"
            raise ConfigError(f"{problem}; valid: latitude, longitude, heading")
        try:
            GeoPoint(*self.datum[:2]) if self.datum else None
        except ValueError as error:
            raise ConfigError(f"'datum': {error}") from error


class NavsatTransformNode(ManagedNode):
    """Lays the world frame of the odometry on the earth, once, by a fix and a heading."""

    Config = NavsatConfig
    DEFAULT_NAME = "navsat_transform_node"

    def configure(self) -> None:
        """Create topics and services."""
        config: NavsatConfig = self.config
        self._earth: EarthFrame | None = None
        self._yaw: float | None = None
        self._fix: Any = None
        self._new_fix = self._new_odom = False
        self._odom: Any = None
        self._started: float | None = None
        self._tf_out = self.publisher(TFMessage, "/tf_static", qos.TF_STATIC)
        self._odom_out = self.publisher(Odometry, "odometry/gps", qos.DEFAULT)
        self._gps_out = (
            self.publisher(NavSatFix, "gps/filtered", qos.DEFAULT)
            if config.publish_filtered_gps
            else None
        )
        self.subscribe(Odometry, config.odom_topic, self._on_odometry, qos.SENSOR_SUBSCRIPTION)
        self.subscribe(NavSatFix, config.gps_topic, self._on_fix, qos.SENSOR_SUBSCRIPTION)
        self.subscribe(Imu, config.imu_topic, self._on_imu, qos.SENSOR_SUBSCRIPTION)
        self.serve(SetDatum, "datum", self._on_datum)
        self.serve(FromLL, "fromLL", self._on_from_ll)
        self.serve(ToLL, "toLL", self._on_to_ll)
        self.serve(FromLLArray, "fromLLArray", self._on_from_lls)
        self.serve(ToLLArray, "toLLArray", self._on_to_lls)
        self.every(1.0 / config.frequency, self._update)
        if config.wait_for_datum and config.datum:
            self._start_at(GeoPoint(*config.datum[:2]), config.datum[2], ORIGIN, (0.0, 0.0, 0.0))

    def _start_at(
        self, fix: GeoPoint, yaw: float, pose: Pose3, lever: tuple[float, float, float]
    ) -> None:
        config = self.config
        yaw += config.magnetic_declination_radians + config.yaw_offset
        self._earth = EarthFrame.of_start(fix, yaw, pose, lever, config.use_local_cartesian)
        where = f"{fix.latitude_deg:.7f}, {fix.longitude_deg:.7f}"
        self.get_logger().info(f"the datum is {where}, the heading there {yaw:.3f} rad")
        self._broadcast()

    def _broadcast(self) -> None:
        """Publish the plane's frame once both it and the world frame's name are known."""
        config = self.config
        wanted = config.broadcast_cartesian_transform or config.broadcast_utm_transform
        if self._earth is None or self._odom is None or not wanted:
            return
        T, parent = self._earth.T_world_enu, self._odom.header.frame_id
        child = _FRAMES[config.use_local_cartesian]
        as_parent = config.broadcast_cartesian_transform_as_parent_frame
        if as_parent or config.broadcast_utm_transform_as_parent_frame:
            T, parent, child = T.inverse(), child, parent
        message = transforms_msg(transform3_msg(T, parent, child, self.now))
        self._tf_out.publish(message)

    def _on_odometry(self, message: Any) -> None:
        first, self._odom, self._new_odom = self._odom is None, message, True
        if first:
            self._broadcast()
        if self.config.use_odometry_yaw:
            self._yaw = pose_of(message.pose.pose).rpy()[2]

    def _on_imu(self, message: Any) -> None:
        """Note the robot's heading until the world lies on the earth."""
        knows = message.orientation_covariance[0] != -1.0
        if self._earth is not None or self.config.use_odometry_yaw or not knows:
            return
        mounted = self._mounted(message.header.frame_id)
        if mounted is not None:
            turn = Pose3(quaternion=unit(message.orientation))
            self._yaw = (turn @ Pose3(quaternion=mounted.quaternion).inverse()).rpy()[2]

    def _on_fix(self, message: Any) -> None:
        numbers = message.latitude, message.longitude, message.altitude
        has_fix = message.status.status != NavSatStatus.STATUS_NO_FIX
        if not has_fix or not all(map(math.isfinite, numbers)):
            return
        self._fix, self._new_fix = message, True

    def _mounted(self, frame: str) -> Pose3 | None:
        """Return a sensor's pose on the robot; None while it, or the robot's frame, is unknown."""
        if self._odom is None:
            return None
        if not frame or frame == self._odom.child_frame_id:
            return ORIGIN
        try:
            return self.transforms.mount(self._odom.child_frame_id, frame.lstrip("/"))
        except TransformError:
            return None

    def _update(self) -> None:
        self._started = self.now if self._started is None else self._started
        if self._fix is None or self._odom is None or self.now < self._started + self.config.delay:
            return
        if self._earth is None and not self.config.wait_for_datum and self._yaw is not None:
            pose = pose_of(self._odom.pose.pose)
            self._start_at(_point(self._fix), self._yaw, pose, self._lever())
        if self._earth is None:
            return
        if self._new_fix:
            self._new_fix = False
            self._publish_odometry(self._earth)
        if self._gps_out is not None and self._new_odom:
            self._new_odom = False
            self._gps_out.publish(self._filtered(self._earth))

    def _lever(self) -> tuple[float, float, float]:
        """Return the receiver's position on the robot, the robot's own where it is unknown."""
        mounted = self._mounted(self._fix.header.frame_id)
        return (mounted or ORIGIN).position

    def _publish_odometry(self, earth: EarthFrame) -> None:
        """Publish where the robot is, which its receiver need not be."""
        turned = Pose3(quaternion=pose_of(self._odom.pose.pose).quaternion)
        lever = turned.apply(np.array([self._lever()]))[0]
        x, y, z = (earth.to_world(_point(self._fix)) - lever).tolist()
        stamp, frame = seconds(self._fix.header.stamp), self._odom.header.frame_id
        message = Odometry(header=header(frame, stamp))
        message.child_frame_id = self._odom.child_frame_id
        message.pose.pose = pose3_msg(Pose3((x, y, 0.0 if self.config.zero_altitude else z)))
        noise, turn = np.zeros((6, 6)), earth.T_world_enu.rotation()
        noise[:3, :3] = turn @ np.reshape(self._fix.position_covariance, (3, 3)) @ turn.T
        message.pose.covariance = noise.ravel()
        self._odom_out.publish(message)

    def _filtered(self, earth: EarthFrame) -> NavSatFix:
        """Return where the filter says that the robot is, as a fix."""
        p, turn = self._odom.pose.pose.position, earth.T_world_enu.inverse().rotation()
        point = earth.to_earth(np.array((p.x, p.y, p.z)))
        message = NavSatFix(header=self._odom.header)
        message.header.frame_id = "gps"
        message.status.status = NavSatStatus.STATUS_GBAS_FIX
        message.latitude, message.longitude = point.latitude_deg, point.longitude_deg
        message.altitude = point.altitude
        noise = np.reshape(self._odom.pose.covariance, (6, 6))[:3, :3]
        message.position_covariance = (turn @ noise @ turn.T).ravel()
        message.position_covariance_type = NavSatFix.COVARIANCE_TYPE_KNOWN
        return message

    def _on_datum(self, request: Any, response: Any) -> Any:
        """Lay the world's origin at a point with a heading."""
        yaw = Pose3(quaternion=unit(request.geo_pose.orientation)).rpy()[2]
        try:
            self._start_at(_point(request.geo_pose.position), yaw, ORIGIN, (0.0, 0.0, 0.0))
        except ValueError as error:
            self.guard.refused(self, "datum", str(error))
        return response

    def _on_from_ll(self, request: Any, response: Any) -> Any:
        response.map_point = self._to_world(request.ll_point)
        return response

    def _on_to_ll(self, request: Any, response: Any) -> Any:
        response.ll_point = self._to_earth(request.map_point)
        return response

    def _on_from_lls(self, request: Any, response: Any) -> Any:
        response.map_points = [self._to_world(point) for point in request.ll_points]
        return response

    def _on_to_lls(self, request: Any, response: Any) -> Any:
        response.ll_points = [self._to_earth(point) for point in request.map_points]
        return response

    def _to_world(self, point: Any) -> Point:
        """Return a point in the world; not a number where there is none: no field says so."""
        x, y, z = (math.nan,) * 3
        try:
            if (earth := self._known_earth("fromLL")) is not None:
                x, y, z = earth.to_world(_point(point)).tolist()
        except ValueError as error:
            self.guard.refused(self, "fromLL", str(error))
        return Point(x=x, y=y, z=0.0 if self.config.zero_altitude else z)

    def _to_earth(self, point: Any) -> GeoPointMsg:
        """Return a point on the earth; not a number before the datum is known."""
        earth = self._known_earth("toLL")
        if earth is None:
            return GeoPointMsg(latitude=math.nan, longitude=math.nan, altitude=math.nan)
        found = earth.to_earth(np.array((point.x, point.y, point.z)))
        return GeoPointMsg(
            latitude=found.latitude_deg, longitude=found.longitude_deg, altitude=found.altitude
        )

    def _known_earth(self, service: str) -> EarthFrame | None:
        """Return where the world lies on the earth; report that a request came before."""
        if self._earth is None:
            reason = "the world frame has no datum yet: it takes a fix, odometry and a heading"
            self.guard.refused(self, service, reason)
        return self._earth


def _point(message: Any) -> GeoPoint:
    """Return the point of a NavSatFix or GeoPoint message.

    Raises:
        ValueError: It is not on the earth.
    """
    return GeoPoint(message.latitude, message.longitude, message.altitude)
