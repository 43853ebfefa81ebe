"""A world frame on the earth, by a fix, a heading and a pose."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.geodesy import GeoPoint, TangentPlane
from arjuna_core.pose3 import Pose3
from arjuna_sim.fusion.earth import EarthFrame

FIX = GeoPoint(48.1, 11.5, 520.0)


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.0])
def test_the_receiver_and_what_lies_around_it_are_where_they_should(yaw: float) -> None:
    pose = Pose3.from_rpy((4.0, -1.0, 0.5), (0.0, 0.0, 0.3))
    earth = EarthFrame.of_start(FIX, yaw, pose, (0.2, 0.1, 0.4))
    receiver = pose.apply(np.array([[0.2, 0.1, 0.4]]))[0]
    assert earth.to_world(FIX) == pytest.approx(receiver)
    # what lies ahead of the robot, which faces `yaw` from east, lies at 0.3 rad in the world
    ahead = TangentPlane(FIX).geodetic(10.0 * np.array((math.cos(yaw), math.sin(yaw), 0.0)))
    expected = receiver + 10.0 * np.array((math.cos(0.3), math.sin(0.3), 0.0))
    assert earth.to_world(ahead) == pytest.approx(expected, abs=1e-6)
    back = earth.to_earth(expected)
    assert back.latitude_deg == pytest.approx(ahead.latitude_deg, abs=1e-9)
    assert back.longitude_deg == pytest.approx(ahead.longitude_deg, abs=1e-9)
