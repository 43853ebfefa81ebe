"""The position of a world frame on the earth, from one fix, one heading and one pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.geodesy import GeoPoint, TangentPlane, UtmGrid
from arjuna_core.pose3 import Pose3


@dataclass(frozen=True)
class EarthFrame:
    """A world frame on a plane of the earth.

    Attributes:
        plane: East, north and up: a zone of UTM, or the plane that touches the earth at a datum.
        T_world_enu: That plane in the world frame.
    """

    plane: TangentPlane | UtmGrid
    T_world_enu: Pose3

    @staticmethod
    def of_start(
        fix: GeoPoint,
        yaw: float,
        T_world_base: Pose3,
        lever: tuple[float, float, float],
        local: bool = True,
    ) -> EarthFrame:
        """Return the frame in which a robot has a pose while its receiver has a fix.

        Args:
            yaw: The robot's heading, counter-clockwise from east [rad].
            lever: The receiver in the robot's frame [m].
            local: Whether on the plane that touches the earth there, rather than on UTM's grid.
        """
        plane = TangentPlane(fix) if local else UtmGrid(fix)
        yaw += plane.convergence(fix) if isinstance(plane, UtmGrid) else 0.0
        upright = Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, yaw))
        x, y, z = (plane.enu(fix) - upright.apply(np.array([lever]))[0]).tolist()
        T_enu_base = Pose3((x, y, z), upright.quaternion)
        heading = (0.0, 0.0, T_world_base.rpy()[2])
        T_world_base = Pose3.from_rpy(T_world_base.position, heading)
        return EarthFrame(plane, T_world_base @ T_enu_base.inverse())

    def to_world(self, point: GeoPoint) -> Floats:
        """Return a point of the earth in the world frame, `(3,) float64` [m]."""
        result: Floats = self.T_world_enu.apply(self.plane.enu(point)[None])[0]
        return result

    def to_earth(self, point: Floats) -> GeoPoint:
        """Return a point `(3,)` of the world frame [m] on the earth."""
        return self.plane.geodetic(self.T_world_enu.inverse().apply(np.asarray(point)[None])[0])
