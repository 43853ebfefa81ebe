"""navsat_transform_node: fixes as odometry, and the services between map and earth."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from geographic_msgs.msg import GeoPoint as GeoPointMsg
from geometry_msgs.msg import Point
from nav_msgs.msg import Odometry
from robot_localization.srv import FromLL, FromLLArray, SetDatum, ToLL, ToLLArray
from sensor_msgs.msg import Imu, NavSatFix
from tf2_msgs.msg import TFMessage

from arjuna_core.errors import ConfigError
from arjuna_core.geodesy import GeoPoint, TangentPlane, UtmGrid
from arjuna_core.pose3 import Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, pose3_msg, seconds, transform3_msg
from arjuna_sim.nodes.localization.navsat import NavsatTransformNode
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import start

HERE = GeoPoint(48.1, 11.5, 0.0)


def _fix(now: float, east: float = 0.0, north: float = 0.0) -> NavSatFix:
    point = TangentPlane(HERE).geodetic(np.array((east, north, 0.0)))
    message = NavSatFix(header=header("gps_link", now), latitude=point.latitude_deg)
    message.longitude, message.altitude = point.longitude_deg, point.altitude
    message.position_covariance = np.diag((4.0, 1.0, 9.0)).ravel()
    return message


def _say(bench: RosBench, fix: NavSatFix | None, yaw: float = 0.0, x: float = 0.0) -> None:
    bench.advance(0.1)
    now = bench.process.now
    odometry = Odometry(header=header("map", now), child_frame_id="base_link")
    odometry.pose.pose = pose3_msg(Pose3((x, 0.0, 0.0)))
    bench.publish(Odometry, "odometry/filtered", odometry)
    imu = Imu(header=header("base_link", now))
    imu.orientation = pose3_msg(Pose3.from_rpy((0, 0, 0), (0, 0, yaw))).orientation
    bench.publish(Imu, "imu", imu)
    if fix is not None:
        fix.header.stamp = header("", now).stamp
        bench.publish(NavSatFix, "gps/fix", fix)
    bench.advance(0.2)


def test_fixes_become_odometry_of_the_robot(bench: RosBench) -> None:
    values = {"yaw_offset": math.pi / 2, "zero_altitude": True, "publish_filtered_gps": True}
    values |= {"use_local_cartesian": True}
    start(bench, NavsatTransformNode(bench.process, values))
    lever = transform3_msg(Pose3((0.5, 0.0, 0.3)), "base_link", "gps_link", 0.0)
    bench.publish(TFMessage, "/tf_static", TFMessage(transforms=[lever]), qos.TF_STATIC)
    odometry = bench.collect(Odometry, "odometry/gps")
    fixes = bench.collect(NavSatFix, "gps/filtered")
    _say(bench, _fix(0.0))
    first = odometry[-1]
    assert (first.header.frame_id, first.child_frame_id) == ("map", "base_link")
    at = first.pose.pose.position
    assert (at.x, at.y, at.z) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    # the robot faced north, by the offset: north is the map's x
    _say(bench, _fix(0.0, east=1.0, north=3.0), yaw=2.0)
    at = odometry[-1].pose.pose.position
    assert (at.x, at.y) == pytest.approx((3.0, -1.0), abs=1e-4)
    covariance = np.reshape(odometry[-1].pose.covariance, (6, 6))
    assert covariance.diagonal()[:3] == pytest.approx((1.0, 4.0, 9.0))
    _say(bench, None, x=10.0)
    north = TangentPlane(HERE).enu(GeoPoint(fixes[-1].latitude, fixes[-1].longitude))
    assert north[:2] == pytest.approx((0.0, 10.0 - 0.5), abs=1e-3)


def test_nothing_comes_before_fix_heading_and_delay(bench: RosBench) -> None:
    start(bench, NavsatTransformNode(bench.process, {"delay": 1.0}))
    odometry = bench.collect(Odometry, "odometry/gps")
    none = _fix(0.0)
    none.status.status = -1
    _say(bench, none)
    _say(bench, _fix(0.0))
    assert not odometry
    bench.advance(1.0)
    assert odometry


def test_the_odometry_gives_the_heading_where_asked(bench: RosBench) -> None:
    start(bench, NavsatTransformNode(bench.process, {"use_odometry_yaw": True}))
    odometry = bench.collect(Odometry, "odometry/gps")
    _say(bench, _fix(0.0), yaw=1.0)
    _say(bench, _fix(0.0, east=2.0))
    assert odometry[-1].pose.pose.position.x == pytest.approx(2.0, abs=1e-4)


def test_a_datum_and_the_services_between_map_and_earth(bench: RosBench) -> None:
    values: dict[str, Any] = {
        "wait_for_datum": True,
        "datum": [48.1, 11.5, 0.0],
        "broadcast_cartesian_transform": True,
        "use_local_cartesian": True,
    }
    start(bench, NavsatTransformNode(bench.process, values))
    transforms = bench.collect(TFMessage, "/tf_static", qos.TF_STATIC)
    far = _fix(0.0, east=100.0, north=20.0)
    point = GeoPointMsg(latitude=far.latitude, longitude=far.longitude, altitude=far.altitude)
    got = bench.call(FromLL, "/fromLL", FromLL.Request(ll_point=point)).map_point
    assert (got.x, got.y, got.z) == pytest.approx((100.0, 20.0, 0.0), abs=1e-4)
    several = bench.call(FromLLArray, "/fromLLArray", FromLLArray.Request(ll_points=[point] * 2))
    assert [p.x for p in several.map_points] == pytest.approx([100.0] * 2, abs=1e-4)
    back = bench.call(ToLL, "/toLL", ToLL.Request(map_point=got)).ll_point
    assert (back.latitude, back.longitude) == pytest.approx((far.latitude, far.longitude))
    assert len(bench.call(ToLLArray, "/toLLArray", ToLLArray.Request(map_points=[got])).ll_points)
    _say(bench, _fix(0.0))
    T = transforms[-1].transforms[0]
    assert (T.header.frame_id, T.child_frame_id) == ("map", "local_enu")
    request = SetDatum.Request()
    request.geo_pose.position = point
    bench.call(SetDatum, "/datum", request)
    moved = bench.call(FromLL, "/fromLL", FromLL.Request(ll_point=point)).map_point
    assert (moved.x, moved.y) == pytest.approx((0.0, 0.0), abs=1e-4)


@pytest.mark.parametrize("as_parent", [False, True])
def test_grid_of_utm_is_the_default(bench: RosBench, as_parent: bool) -> None:
    values = {"wait_for_datum": True, "datum": [48.1, 11.5, 0.3], "broadcast_utm_transform": True}
    values |= {"broadcast_utm_transform_as_parent_frame": as_parent}
    start(bench, NavsatTransformNode(bench.process, values))
    transforms = bench.collect(TFMessage, "/tf_static", qos.TF_STATIC)
    _say(bench, _fix(0.0))
    found = transforms[-1].transforms[0]
    frames = ("utm", "map") if as_parent else ("map", "utm")
    assert (found.header.frame_id, found.child_frame_id) == frames
    move, turn = found.transform.translation, found.transform.rotation
    T = Pose3((move.x, move.y, move.z), (turn.w, turn.x, turn.y, turn.z))
    T_utm_map, grid = T if as_parent else T.inverse(), UtmGrid(HERE)
    assert T_utm_map.position == pytest.approx(grid.enu(HERE), abs=1e-5)
    assert T_utm_map.rpy()[2] == pytest.approx(0.3 + grid.convergence(HERE))
    ahead = TangentPlane(HERE).geodetic(1000.0 * np.array((math.cos(0.3), math.sin(0.3), 0.0)))
    point = GeoPointMsg(latitude=ahead.latitude_deg, longitude=ahead.longitude_deg)
    got = bench.call(FromLL, "/fromLL", FromLL.Request(ll_point=point)).map_point
    assert (got.x, got.y) == pytest.approx((1000.0, 0.0), abs=0.5)  # its scale is up to 0.04 % off
    assert got.x != pytest.approx(1000.0, abs=0.01)
    back = bench.call(ToLL, "/toLL", ToLL.Request(map_point=got)).ll_point
    assert back.latitude == pytest.approx(ahead.latitude_deg, abs=1e-9)


def test_without_a_datum_points_are_no_numbers(bench: RosBench) -> None:
    start(bench, NavsatTransformNode(bench.process))
    got = bench.call(FromLL, "/fromLL", FromLL.Request())
    assert math.isnan(got.map_point.x)
    assert math.isnan(bench.call(ToLL, "/toLL", ToLL.Request(map_point=Point())).ll_point.latitude)


@pytest.mark.parametrize(
    ("datum", "message"), [([1.0, 2.0], "has 2 values"), ([91.0, 0.0, 0.0], "latitude 91")]
)
def test_an_invalid_datum_is_refused(bench: RosBench, datum: list[float], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        NavsatTransformNode(bench.process, {"datum": datum})


def test_the_stamp_is_the_fix_s(bench: RosBench) -> None:
    start(bench, NavsatTransformNode(bench.process))
    odometry = bench.collect(Odometry, "odometry/gps")
    _say(bench, _fix(0.0))
    assert seconds(odometry[-1].header.stamp) == pytest.approx(0.1)
