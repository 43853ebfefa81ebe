"""Set-ups broken on purpose, as snapshots: each is named, and a healthy one is not."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import pytest

from bringup.client.endpoint import Endpoint
from bringup.doctor.checks import CHECKS
from bringup.doctor.report import ROWS, diagnose
from bringup.doctor.snapshot import Clock, Machine, Robot, ScanFacts, Snapshot
from bringup.viewing.frame_tree import Frame

_TWIST = "geometry_msgs/msg/Twist"
_SCAN = "sensor_msgs/msg/LaserScan"


def _end(node: str, topic: str, publishes: bool, kind: str = _SCAN, **qos: bool) -> Endpoint:
    return Endpoint(node, topic, kind, publishes, **qos)


ENDPOINTS = (
    _end("/sim", "/clock", True, "rosgraph_msgs/msg/Clock"),
    _end("/navigation_host", "/clock", False, "rosgraph_msgs/msg/Clock", reliable=False),
    _end("/sim", "/scan", True),
    _end("/amcl", "/scan", False, reliable=False),
    _end("/sim", "/odom", True, "nav_msgs/msg/Odometry"),
    _end("/sim", "/tf", True, "tf2_msgs/msg/TFMessage"),
    _end("/sim", "/cmd_vel", False, _TWIST),
    _end("/controller_server", "/cmd_vel", True, _TWIST),
    _end("/map_server", "/map", True, "nav_msgs/msg/OccupancyGrid", latched=True),
    _end("/amcl", "/map", False, "nav_msgs/msg/OccupancyGrid", latched=True),
)
FRAMES = {
    "odom": Frame("odom", ("map",), rate=10.0, age=-0.2),
    "base_footprint": Frame("base_footprint", ("odom",), rate=50.0, age=0.02),
    "base_link": Frame("base_link", ("base_footprint",), static=True),
    "lidar_link": Frame("lidar_link", ("base_link",), static=True),
}
SEEN = ScanFacts("lidar_link", returns=0.9, on_walls=0.95)
HEALTHY = Snapshot(
    machine=Machine(domains=(0,)),
    nodes=("/amcl", "/controller_server", "/map_server", "/navigation_host", "/sim"),
    endpoints=ENDPOINTS,
    states={"/amcl": "active", "/sim": "active"},
    counts={"/scan": 30, "/odom": 150, "/tf": 150},
    clock=Clock(3.0),
    frames=FRAMES,
    robot=Robot(scan=SEEN, map_known=0.8, deviation=0.05, height=0.0),
)


def _without(*gone: Endpoint) -> Snapshot:
    return replace(HEALTHY, endpoints=tuple(end for end in ENDPOINTS if end not in gone))


def _with(*more: Endpoint) -> Snapshot:
    return replace(HEALTHY, endpoints=(*ENDPOINTS, *more))


def _with_listener(node: str, *also: Endpoint) -> Snapshot:
    without = _without(ENDPOINTS[6])
    ends = (*without.endpoints, _end(node, "/cmd_vel", False, _TWIST), *also)
    return replace(without, endpoints=ends)


def _machine(**changes: Any) -> Snapshot:
    return replace(HEALTHY, machine=replace(HEALTHY.machine, **changes))


def _environment(name: str, value: str) -> Snapshot:
    return _machine(environment={name: value})


def _frames(**changes: Frame | None) -> Snapshot:
    changed = {**FRAMES, **changes}
    return replace(HEALTHY, frames={name: frame for name, frame in changed.items() if frame})


def _robot(**changes: Any) -> Snapshot:
    return replace(HEALTHY, robot=replace(HEALTHY.robot, **changes))


def _scan(**changes: Any) -> Snapshot:
    return _robot(scan=replace(SEEN, **changes))


BROKEN = {
    "an old Python": (_machine(python=(3, 8)), "installation", "Python 3.8 is none of"),
    "no messages": (_machine(missing=("nav2_msgs",)), "installation", "not installed.*nav2_msgs"),
    "another ROS": (_environment("ROS_DISTRO", "humble"), "installation", "ROS humble is sourced"),
    "a ROS in front": (
        _machine(foreign={"rclpy": "/opt/ros/rclpy"}),
        "installation",
        "rclpy comes from /opt/ros/rclpy",
    ),
    "a wrong GL": (_environment("MUJOCO_GL", "opengl"), "graphics", "MUJOCO_GL=opengl"),
    "no GL": (_machine(gl_error="egl: no device"), "graphics", "egl: no device"),
    "a full disk": (_machine(disk_free=0.2), "resources", "0.2 GiB of disk"),
    "no memory": (_machine(memory_free=0.1), "resources", "0.1 GiB of memory"),
    "no time": (_machine(load=6.0), "resources", "6.0 processes a core"),
    "no discovery": (
        _environment("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"),
        "discovery",
        "no process sees another",
    ),
    "a whole network": (
        _environment("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"),
        "discovery",
        "every robot of the network",
    ),
    "peers": (_environment("ROS_STATIC_PEERS", "192.0.2.9"), "discovery", "other hosts reach"),
    "no range": (_environment("ROS_AUTOMATIC_DISCOVERY_RANGE", "ALL"), "discovery", "none of OFF"),
    "an old switch": (_environment("ROS_LOCALHOST_ONLY", "1"), "discovery", "ROS_LOCALHOST_ONLY"),
    "no domain": (_environment("ROS_DOMAIN_ID", "300"), "discovery", "none of 0 to 101"),
    "another middleware": (
        _environment("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp"),
        "discovery",
        "rmw_cyclonedds_cpp",
    ),
    "another domain": (_machine(domains=(7,)), "discovery", "a robot runs in ROS domain 7"),
    "twins": (
        replace(HEALTHY, nodes=("/amcl", "/amcl", "/sim")),
        "discovery",
        "2 nodes are called /amcl: end one, or start it under another name .*__node:=NAME",
    ),
    "a robot with a namespace": (
        replace(HEALTHY, nodes=("/robot1/sim", "/robot1/sim_host")),
        "discovery",
        "robots run below /robot1, none without",
    ),
    "no clock": (_without(ENDPOINTS[0]), "clock", "nobody publishes /clock, and /navigation_host"),
    "two clocks": (
        _with(_end("/play", "/clock", True, "rosgraph_msgs/msg/Clock")),
        "clock",
        "2 publish /clock",
    ),
    "a paused simulation": (replace(HEALTHY, clock=Clock(0.0)), "clock", "stands still"),
    "a clock set back": (replace(HEALTHY, clock=Clock(3.0, 2)), "clock", "set back 2 times"),
    "a slow simulation": (replace(HEALTHY, clock=Clock(1.5)), "clock", "runs at 0.50 of real"),
    "nodes of another clock": (
        replace(HEALTHY, on_system_time=("/amcl", "/b", "/c", "/d", "/e")),
        "clock",
        "/sim publishes /clock, and /amcl, /b, /c, /d and 1 more stamp by the system's clock: "
        "start them with use_sim_time:=true",
    ),
    "a node asleep": (
        replace(HEALTHY, states={"/amcl": "inactive"}),
        "lifecycle",
        "/amcl is inactive, not active",
    ),
    "a node that is stuck": (replace(HEALTHY, states={"/amcl": ""}), "lifecycle", "does not say"),
    "a reliable listener": (
        _with(_end("/cam", "/i", True, reliable=False), _end("/mine", "/i", False)),
        "qos",
        "/mine hears nothing of /cam on /i: it asks for reliable",
    ),
    "a latched listener": (
        _with(_end("/rviz", "/scan", False, latched=True)),
        "qos",
        "/rviz hears nothing of /sim on /scan: it asks for transient local",
    ),
    "two types": (
        _with(_end("/mine", "/scan", False, "std_msgs/msg/String")),
        "qos",
        "LaserScan is no std_msgs/msg/String",
    ),
    "a rare scan": (
        replace(HEALTHY, counts={"/scan": 6, "/odom": 150}),
        "rates",
        "/scan of /sim comes at 2.0 Hz, 5 are needed",
    ),
    "a dead topic": (
        replace(HEALTHY, counts={"/odom": 0}),
        "rates",
        "nothing comes on /odom, which /sim .reliable, ",
    ),
    "a dead lidar of another name": (
        replace(
            _with(_end("/lidar", "/front/scan", True, reliable=False)),
            counts={**HEALTHY.counts, "/front/scan": 0},
        ),
        "rates",
        "nothing comes on /front/scan, which /lidar .best effort, volatile. publishes",
    ),
    "no localization": (_frames(odom=None), "transforms", "no transform map -> odom"),
    "no odometry": (_frames(base_footprint=None), "transforms", "no transform odom -> base"),
    "a late frame": (
        _frames(odom=Frame("odom", ("map",), age=3.2)),
        "transforms",
        "map -> odom is 3.2 s late",
    ),
    "another clock": (
        _frames(odom=Frame("odom", ("map",), age=-1e9)),
        "transforms",
        "ahead: another clock stamps it: start its publisher with use_sim_time:=true",
    ),
    "a static frame twice": (
        replace(
            _with(
                _end("/robot_state_publisher", "/tf_static", True, "tf2_msgs/msg/TFMessage"),
                _end("/mine", "/tf_static", True, "tf2_msgs/msg/TFMessage"),
            ),
            frames={**FRAMES, "lidar_link": Frame("lidar_link", ("base_link",), True, variants=2)},
        ),
        "transforms",
        "static base_link -> lidar_link is published 2 times.*robot_state_publisher, /mine",
    ),
    "two parents": (
        _frames(odom=Frame("odom", ("world", "map"))),
        "transforms",
        "odom has 2 parents: world, map",
    ),
    "a loop": (
        _frames(odom=Frame("odom", ("base_link",))),
        "transforms",
        "base_footprint, base_link, lidar_link, odom are their own ancestors",
    ),
    "a lost sensor": (_frames(lidar_link=None), "transforms", "lidar_link is not below"),
    "no base": (
        _frames(base_link=None, base_footprint=None, lidar_link=None),
        "transforms",
        "no frame base_footprint or base_link",
    ),
    "no lidar": (_without(ENDPOINTS[2]), "lidar", "nobody publishes /scan, and /amcl"),
    "a scan of another name": (
        _with(_end("/collision_monitor", "/laser/scan", False)),
        "lidar",
        "nobody publishes /laser/scan, and /collision_monitor wait for it: scans come on /scan",
    ),
    "a covered lidar": (_scan(returns=0.01), "lidar", "1% of the lidar's beams hit anything"),
    "a lidar in the body": (_scan(near=0.3), "lidar", "30% of the lidar's beams hit the robot"),
    "left for right": (_scan(upside_down=True), "lidar", "left and right are swapped"),
    "the wrong map": (_scan(on_walls=0.3), "localization", "30% of the scan's hits lie on walls"),
    "no map": (_robot(map_known=None), "localization", "no /map came"),
    "an empty map": (_robot(map_known=0.0), "localization", "0% of the map is known"),
    "a lost robot": (_robot(deviation=2.0), "localization", "AMCL knows its position to 2.0 m"),
    "a stamped driver": (
        _with(_end("/joy", "/cmd_vel", True, "geometry_msgs/msg/TwistStamped")),
        "velocity",
        "/joy sends TwistStamped on /cmd_vel, /sim listens for Twist",
    ),
    "no listener": (_without(ENDPOINTS[6]), "velocity", "/controller_server send /cmd_vel and no"),
    "only a costmap listens": (
        _with_listener("/near", _end("/near", "/near/costmap_raw", True, "nav2_msgs/msg/Costmap")),
        "velocity",
        "/controller_server send /cmd_vel and no robot listens",
    ),
    "a robot in the ground": (_robot(height=-0.2), "body", "sinks into the ground"),
    "an overturned robot": (
        _robot(troubles=(("/bt_navigator", "the robot has overturned"),)),
        "troubles",
        "/bt_navigator: the robot has overturned",
    ),
    "a zone that is not kept": (_robot(remarks=("zones are not kept",)), "parameters", "not kept"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_set_up_broken_on_purpose_is_named_by_its_check(case: str) -> None:
    snapshot, check, words = BROKEN[case]
    found = diagnose(snapshot)
    assert re.search(words, "\n".join(map(str, found[check])))
    assert all(finding.remedy for finding in found[check])
    elsewhere = [name for name, findings in found.items() if findings and name != check]
    assert len(elsewhere) <= 1, f"{case} also shows in {elsewhere}"


@pytest.mark.parametrize("snapshot", [HEALTHY, _with_listener("/wheels_of_costmap")])
def test_a_healthy_robot_has_no_findings(snapshot: Snapshot) -> None:
    assert not [str(one) for one in diagnose(snapshot)["velocity"]]
    assert {name: found for name, found in diagnose(HEALTHY).items() if found} == {}


def test_a_robot_below_a_namespace_is_seen_as_one_without() -> None:
    other = _end("/robot2/sim", "/robot2/scan", True)
    seen = replace(
        HEALTHY,
        nodes=(*(f"/robot1{node}" for node in HEALTHY.nodes), "/robot2/sim", "/robot10/amcl"),
        endpoints=(
            other,
            *(
                replace(end, node=f"/robot1{end.node}", topic=f"/robot1{end.topic}")
                for end in HEALTHY.endpoints
            ),
        ),
        states={f"/robot1{name}": state for name, state in HEALTHY.states.items()},
        counts={f"/robot1{topic}": count for topic, count in HEALTHY.counts.items()},
    )
    assert seen.below("/robot1") == replace(HEALTHY, namespace="/robot1")
    assert HEALTHY.below("/") == HEALTHY


def test_a_map_in_the_making_need_not_fit() -> None:
    mapping = replace(_scan(on_walls=0.3), nodes=("/slam_toolbox", "/sim"))
    assert diagnose(mapping)["localization"] == []


def test_a_machine_without_a_robot_has_no_findings() -> None:
    assert not any(diagnose(Snapshot()).values())


def test_every_check_finds_something_in_some_broken_set_up() -> None:
    assert {check for _, check, _ in BROKEN.values()} == set(CHECKS)


def test_the_guides_rows_name_checks_that_exist() -> None:
    assert {check for check, _ in ROWS.values()} <= {*CHECKS, "", "said lately"}
