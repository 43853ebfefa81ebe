"""A sensor's frame is the robot's own where it has one, in all the forms of files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.devices.sensors.camera import CameraSettings
from arjuna_sim.model.optical import T_BODY_OPTICAL, SensorFrame, sensor_frame
from arjuna_sim.model.settings import SensorSettings
from arjuna_sim.model.urdf import Joint, Link, Urdf

ASIDE = Pose3((0.0, 0.02, 0.0), T_BODY_OPTICAL.quaternion)


def robot(**children: Pose3) -> Urdf:
    """Return a robot with a link `camera` and fixed children of it."""
    links = {name: Link(name, None, (), ()) for name in ("camera", *children)}
    joints = {name: Joint(name, "fixed", "camera", name, T) for name, T in children.items()}
    return Urdf(Path("r.urdf"), "r", "", "camera", links, joints)


def camera(frame: str, pose: Pose3 = ORIGIN) -> CameraSettings:
    """Return a camera on the link `camera`."""
    return CameraSettings(
        link="camera",
        frame=frame,
        rate=30.0,
        name="front eye",
        pose=pose,
        width=64,
        height=48,
        horizontal_fov=1.0,
        near=0.1,
        far=10.0,
    )


def added(name: str, parent: str, T: Pose3 = ORIGIN) -> SensorFrame:
    """Return an optical frame that the simulation adds."""
    return SensorFrame(name, parent, T @ T_BODY_OPTICAL)


UP = Pose3((0.1, 0.0, 0.3))


@pytest.mark.parametrize(
    ("urdf", "named", "pose", "expected"),
    [
        (robot(), "camera", ORIGIN, added("camera_optical_frame", "camera")),
        (robot(), "eye_optical", ORIGIN, added("eye_optical", "camera")),
        (robot(), "left_eye", ORIGIN, added("left_eye", "camera")),
        (robot(), "world", ORIGIN, added("camera_optical_frame", "camera")),
        (robot(eye=ASIDE), "eye", ORIGIN, SensorFrame("eye")),
        (robot(eye=ASIDE), "camera", ORIGIN, SensorFrame("eye")),
        (robot(eye=Pose3()), "eye", ORIGIN, added("eye_optical_frame", "eye")),
        (robot(eye=Pose3()), "camera", ORIGIN, added("camera_optical_frame", "camera")),
        (robot(eye=UP @ T_BODY_OPTICAL), "eye", UP, SensorFrame("eye")),
        (robot(eye=ASIDE), "eye", UP, added("camera_front_eye_optical_frame", "camera", UP)),
        (robot(), "eye_optical", UP, added("eye_optical", "camera", UP)),
    ],
)
def test_frame_of_pictures(urdf: Urdf, named: str, pose: Pose3, expected: SensorFrame) -> None:
    assert sensor_frame(urdf, camera(named, pose)) == expected


@pytest.mark.parametrize(
    ("named", "pose", "expected"),
    [
        ("camera", ORIGIN, SensorFrame("camera")),
        ("scanner", ORIGIN, SensorFrame("scanner", "camera")),
        ("map", ORIGIN, SensorFrame("camera")),
        ("up", UP, SensorFrame("up")),
        ("camera", UP, SensorFrame("camera_top_lidar", "camera", UP)),
        ("scanner", UP, SensorFrame("scanner", "camera", UP)),
    ],
)
def test_sensor_off_its_link_has_a_frame_where_it_is(
    named: str, pose: Pose3, expected: SensorFrame
) -> None:
    sensor = SensorSettings(
        link="camera", frame=named, rate=5.0, topic="t", name="top lidar", pose=pose
    )
    assert sensor_frame(robot(up=UP), sensor) == expected


def test_optical_axes_are_right_down_and_ahead() -> None:
    assert T_BODY_OPTICAL.position == (0.0, 0.0, 0.0)
    axes = T_BODY_OPTICAL.rotation()
    np.testing.assert_allclose(axes, [[0, 0, 1], [-1, 0, 0], [0, -1, 0]], atol=1e-12)
    assert T_BODY_OPTICAL.position == (0.0, 0.0, 0.0)
