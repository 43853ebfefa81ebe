"""Puts the map on the earth: by a datum that is given, or by the first fix that comes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sensor_msgs.msg import NavSatFix, NavSatStatus

from arjuna_core.config import fixed, param
from arjuna_core.errors import ArjunaError, ConfigError
from arjuna_core.geodesy import GeoPoint, MapOnEarth
from arjuna_core.ros import qos
from arjuna_core.ros.convert import yaw
from arjuna_core.ros.node import ManagedNode
from arjuna_core.se2 import SE2


class GpsError(ArjunaError):
    """A point on the earth has no pose in the map."""


@dataclass(frozen=True)
class GpsConfig:
    """The map's datum on the earth; `datum` is as robot_localization's navsat_transform has it."""

    datum: tuple[float, ...] = fixed(
        (),
        "Latitude and longitude [degree] of the map's origin, and the direction of its x axis "
        "counter-clockwise from east [rad]; empty: the first fix says where the robot is.",
    )
    heading: float = param(
        0.0, "Direction of the map's x axis from east, where there is no datum.", unit="rad"
    )
    fix_topic: str = fixed("gps/fix", "Topic of the receiver's fixes.")

    def __post_init__(self) -> None:
        if len(self.datum) not in (0, 3):
            raise ConfigError(f"'gps.datum' has {len(self.datum)} numbers; valid: 0 or 3")
        if self.datum:
            try:
                GeoPoint(*self.datum[:2])
            except ValueError as error:
                raise ConfigError(f"'gps.datum': {error}") from error


class GpsAnchor:
    """Pose of a map's frame on the earth, once a node knows it."""

    def __init__(self, node: ManagedNode, config: GpsConfig, frame: str) -> None:
        self._node = node
        self._config = config
        self._frame = frame
        self._map: MapOnEarth | None = None
        if config.datum:
            latitude, longitude, heading = config.datum
            self._map = MapOnEarth(GeoPoint(latitude, longitude), heading=heading)
        else:
            node.subscribe(NavSatFix, config.fix_topic, self._on_fix, qos.SENSOR_SUBSCRIPTION)

    def pose(self, message: Any) -> SE2:
        """Return the pose in the map of a GeoPose.

        Raises:
            GpsError: It is no point on the earth, or where the map lies is not known.
        """
        if self._map is None:
            raise GpsError(
                f"no fix has come on '{self._config.fix_topic}' and no 'gps.datum' is set: "
                f"where '{self._frame}' lies on the earth is not known"
            )
        point = message.position
        try:
            at = GeoPoint(point.latitude, point.longitude)
            return self._map.to_map(at, yaw(message.orientation))
        except ValueError as error:
            raise GpsError(str(error)) from error

    def _on_fix(self, message: Any) -> None:
        """Take the first fix that is one, where the receiver's pose in the map is known."""
        if self._map is not None or message.status.status < NavSatStatus.STATUS_FIX:
            return
        receiver = message.header.frame_id.lstrip("/") or "base_link"
        T_map_receiver = self._node.transforms.try_lookup(self._frame, receiver)
        if T_map_receiver is None:
            return
        try:
            point = GeoPoint(message.latitude, message.longitude)
        except ValueError as error:
            self._node.get_logger().warning(f"{self._config.fix_topic} ignored: {error}")
            return
        x, y = T_map_receiver.x, T_map_receiver.y
        self._map = MapOnEarth(point, x, y, self._config.heading)
        self._node.get_logger().info(
            f"({x:.2f}, {y:.2f}) in '{self._frame}' lies at "
            f"{point.latitude_deg:.7f}, {point.longitude_deg:.7f}"
        )
