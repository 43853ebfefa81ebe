"""The doctor on a live robot in lock-step: well when it is, and what is broken is named."""

from __future__ import annotations

from typing import Any

import pytest
from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from arjuna_core.files.shipped import shipped_file
from arjuna_core.ros import qos
from bringup.doctor.observer import Observer, Watcher, clock_of
from bringup.doctor.report import diagnose
from bringup.doctor.snapshot import Clock
from bringup.lockstep import LockStep
from bringup.stack import LOCALIZATION_GROUP
from tests.helpers.robots import Stack

_MACHINE = {"installation", "graphics", "resources", "discovery"}  # not the robot's


def _robot(stack: Stack, **amcl: Any) -> LockStep:
    parameters = {
        "map_server": {"yaml_filename": str(shipped_file("maps/arjuna_room.yaml"))},
        "amcl": amcl,
    }
    return stack(LOCALIZATION_GROUP, parameters=parameters, transport="dds")


def _findings(robot: LockStep) -> dict[str, str]:
    found = diagnose(Observer(robot).snapshot(2.0))
    return {
        name: "\n".join(map(str, each))
        for name, each in found.items()
        if each and name not in _MACHINE
    }


def test_a_robot_that_is_well_has_no_findings_and_what_breaks_is_named(stack: Stack) -> None:
    robot = _robot(stack)
    watcher = Watcher(robot)
    watcher.rows(0.5)
    _, state, _, _, topic, rate, _ = {row[0]: row for row in watcher.rows(2.0)}["/sim"]
    assert (state, topic) == ("active", "/scan")
    assert float(rate.removesuffix(" Hz")) == pytest.approx(10.0, abs=1.0)
    snapshot = Observer(robot).snapshot(2.0)
    whole = diagnose(snapshot)
    assert {name for name, each in whole.items() if each} <= _MACHINE, whole
    assert snapshot.robot.scan is not None
    assert snapshot.robot.scan.on_walls is not None
    assert snapshot.robot.scan.on_walls > 0.8
    assert snapshot.states["/amcl"] == "active"
    assert snapshot.pace == pytest.approx(1.0, abs=0.05)
    assert set(snapshot.frames) >= {"odom", "base_footprint", "lidar_link"}

    other = Node("meddler", context=robot.process.context)
    robot.process.executor.add_node(other)
    other.create_subscription(LaserScan, "/scan", lambda message: None, qos.LATCHED)
    twin = TransformStamped(child_frame_id="lidar_link")
    twin.header.frame_id = "mast"
    twin.transform.rotation.w = 1.0
    statics = other.create_publisher(TFMessage, "/tf_static", qos.TF_STATIC)
    moved = TransformStamped(child_frame_id="camera_link")
    moved.header.frame_id = "base_link"
    moved.transform.translation.z, moved.transform.rotation.w = 2.0, 1.0
    statics.publish(TFMessage(transforms=[twin, moved]))
    other.get_logger().warning("I am in the way")
    robot.process.remarks = ("no effect yet (SAFETY): zones: they are not kept",)
    robot.nodes["amcl"].trigger_deactivate()
    observer = Observer(robot)
    snapshot = observer.snapshot(2.0)
    found = {name: "\n".join(map(str, each)) for name, each in diagnose(snapshot).items()}
    other.destroy_node()
    assert "/meddler hears nothing of /sim on /scan: it asks for transient local" in found["qos"]
    assert "/sim publishes /clock, and /meddler stamp by the system's clock" in found["clock"]
    assert "frame lidar_link has 2 parents" in found["transforms"]
    assert "no transform map -> odom" in found["transforms"]
    assert "static base_link -> camera_link is published 2 times" in found["transforms"]
    assert "/amcl is inactive, not active" in found["lifecycle"]
    assert ("meddler", "I am in the way") in snapshot.robot.log
    assert "zones: they are not kept" in found["parameters"]


def test_a_robot_put_elsewhere_does_not_fit_the_map(stack: Stack) -> None:
    robot = _robot(
        stack,
        set_initial_pose=True,
        global_localization_at_start="never",
        relocalize=False,
        **{"initial_pose.x": 1.5, "initial_pose.y": 1.0, "initial_pose.yaw": 0.9},
    )
    robot.run(1.0)
    assert "of the scan's hits lie on walls of the map" in _findings(robot)["localization"]


def test_a_clock_that_was_set_back_is_counted() -> None:
    assert clock_of([]) is None
    assert clock_of([1.0, 1.5, 0.2, 0.7]) == Clock(1.0, 1)
