"""follow_gps_waypoints: points on the earth become poses, by a datum or the first fix."""

from __future__ import annotations

import math
from typing import Any

import pytest
from geographic_msgs.msg import GeoPoint as GeoPointMsg
from geographic_msgs.msg import GeoPose
from geometry_msgs.msg import Quaternion
from nav2_msgs.action import FollowGPSWaypoints, FollowWaypoints
from sensor_msgs.msg import NavSatFix

from arjuna_core.errors import ConfigError
from arjuna_core.geodesy import GeoPoint, MapOnEarth
from arjuna_core.ros import qos
from arjuna_core.ros.convert import pose_stamped, quaternion
from arjuna_core.se2 import IDENTITY, SE2
from bringup.stack import NAVIGATION_GROUP
from tests.helpers.nav.navigation import SUCCEEDED, Goal, PlayedRobot, assert_failed, started

UNKNOWN = FollowGPSWaypoints.Result.UNKNOWN
HERE = GeoPoint(48.1351, 11.5820)
HEADING = 0.5
STOPS = SE2(0.6, 0.0, 0.0), SE2(0.9, 0.5, 1.0)
DATUM: dict[str, Any] = {"gps.datum": [HERE.latitude_deg, HERE.longitude_deg, HEADING]}


def made(start: SE2 = IDENTITY, **parameters: Any) -> PlayedRobot:
    return started(*NAVIGATION_GROUP.nodes, start=start, waypoint_follower=parameters)


def fix(robot: PlayedRobot, point: GeoPoint, status: int = 0, frame: str = "base_link") -> None:
    message = NavSatFix(latitude=point.latitude_deg, longitude=point.longitude_deg)
    message.status.status = status
    message.header.frame_id = frame
    robot.bench.publish(NavSatFix, "gps/fix", message, qos.SENSOR_PUBLISHER)


def geo_pose(point: GeoPoint, yaw: float) -> GeoPose:
    position = GeoPointMsg(latitude=point.latitude_deg, longitude=point.longitude_deg)
    return GeoPose(position=position, orientation=quaternion(yaw))


def follow(robot: PlayedRobot, *poses: GeoPose, **fields: int) -> Goal:
    request = FollowGPSWaypoints.Goal(gps_poses=list(poses), **fields)
    return robot.send(FollowGPSWaypoints, "follow_gps_waypoints", request)


def on_earth(field: MapOnEarth, heading: float, *stops: SE2) -> list[GeoPose]:
    return [geo_pose(field.to_earth(stop.x, stop.y), stop.theta + heading) for stop in stops]


def test_points_are_driven_to_by_a_datum() -> None:
    robot = made(**DATUM)
    goal = follow(robot, *on_earth(MapOnEarth(HERE, heading=HEADING), HEADING, *STOPS))
    robot.run_until_done(goal, 40.0)
    assert (goal.status, goal.result.error_code, goal.result.error_msg) == (SUCCEEDED, 0, "")
    assert {each.current_waypoint for each in goal.feedback} == {0, 1}
    assert robot.pose.distance(STOPS[-1]) < 0.16
    assert abs(robot.pose.theta - STOPS[-1].theta) < 0.16


def test_the_first_fix_says_where_the_map_lies() -> None:
    robot = made(start=SE2(0.3, 0.2, 1.0))
    fix(robot, GeoPoint(0.0, 0.0), status=-1)  # the receiver has no fix yet
    fix(robot, HERE)
    fix(robot, GeoPoint(-10.0, 3.0))  # later ones change nothing
    robot.succeed(follow(robot, *on_earth(MapOnEarth(HERE, 0.3, 0.2), 0.0, STOPS[0])), 40.0)
    assert robot.pose.distance(STOPS[0]) < 0.16


def test_without_fix_or_datum_it_says_what_is_missing() -> None:
    robot = made()
    fix(robot, HERE, frame="nowhere")  # of a receiver whose point is not known
    assert_failed(follow(robot, geo_pose(HERE, 0.0)), UNKNOWN, "no fix has come on 'gps/fix'")


def test_a_point_that_is_invalid_ends_it() -> None:
    robot = made(**DATUM)
    assert not follow(robot, geo_pose(HERE, 0.0)).done
    for pose, says in (
        (GeoPose(position=GeoPointMsg(latitude=100.0)), "waypoint 1 of 2: latitude 100 is no"),
        (
            GeoPose(position=GeoPointMsg(longitude=math.nan)),
            "gps_poses: item 1: position.longitude: nan is not finite",
        ),
        (GeoPose(orientation=Quaternion(w=0.0)), "gps_poses: item 1: orientation: quaternion"),
    ):
        assert_failed(follow(robot, geo_pose(HERE, 0.0), pose), UNKNOWN, says)


def test_the_newer_list_of_either_kind_counts() -> None:
    robot = made(**DATUM)
    field = MapOnEarth(HERE, heading=HEADING)
    first = follow(robot, *on_earth(field, HEADING, SE2(3.0, 1.0)))
    robot.run(1.0)
    poses = [pose_stamped(SE2(0.5, 0.5), "map", 0.0)]
    second = robot.send(FollowWaypoints, "follow_waypoints", FollowWaypoints.Goal(poses=poses))
    assert_failed(first, UNKNOWN, "replaced by follow_waypoints")
    robot.run(1.0)
    third = follow(robot, *on_earth(field, HEADING, SE2(0.4, 0.0)))
    assert_failed(second, UNKNOWN)
    robot.succeed(third, 30.0)
    assert follow(robot).result.error_msg.startswith("there is no waypoint 0")


@pytest.mark.parametrize(
    ("datum", "says"), [([1.0, 2.0], "has 2 numbers"), ([95.0, 0.0, 0.0], "95")]
)
def test_an_invalid_datum_is_refused(datum: list[float], says: str) -> None:
    with pytest.raises(ConfigError, match=says):
        started(*NAVIGATION_GROUP.nodes, waypoint_follower={"gps.datum": datum})
