"""The first sensors of a robot, and the names and topics of those that share one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from arjuna_sim.devices.sensors.camera import CameraSettings
from arjuna_sim.devices.sensors.imu import ImuSettings
from arjuna_sim.devices.sensors.navsat import NavSatSettings
from arjuna_sim.files.robots.gazebo import with_primary_first
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.settings import GazeboSettings, SensorSettings
from arjuna_sim.model.urdf import Urdf
from tests.sim.builders import urdf_file

IMU = ImuSettings(link="base", frame="base", rate=50.0, name="imu")
GPS = NavSatSettings(link="base", frame="base", rate=5.0, name="gps", topic="gps/fix")
CAMERA = CameraSettings(
    link="eye",
    frame="eye",
    rate=30.0,
    name="cam",
    width=64,
    height=48,
    horizontal_fov=1.0,
    near=0.1,
    far=9.0,
)
DEPTH = replace(CAMERA, name="deep", depth=True)


def settle(xml: XmlFile, sensors: list[SensorSettings]) -> GazeboSettings:
    urdf = Urdf(Path("r.urdf"), "r", "", "base")
    return GazeboSettings(sensors=tuple(with_primary_first(xml, urdf, sensors)))


def named(sensors: tuple[SensorSettings, ...]) -> list[tuple[str, str]]:
    return [(sensor.name, sensor.topic) for sensor in sensors]


def test_sensors_of_one_name_are_numbered_and_of_one_topic_get_their_own() -> None:
    xml = urdf_file()
    found = settle(
        xml, [IMU, replace(IMU), replace(IMU, topic="/imu/data"), replace(IMU, topic="own")]
    )
    assert found.first(ImuSettings) == IMU
    assert named(found.further) == [
        *(("imu_2", "imu_2/data"), ("imu_3", "imu_3/data"), ("imu_4", "own")),
    ]
    assert [note.text for note in xml.notes] == [
        "sensor 'imu_2': publishes on imu_2/data, since imu/data is another's",
        "sensor 'imu_3': publishes on imu_3/data, since /imu/data is another's",
    ]


def test_names_and_topics_of_their_own_are_kept() -> None:
    xml = urdf_file()
    found = settle(xml, [GPS, IMU, replace(GPS, name="other", topic="other/fix")])
    assert (found.first(CameraSettings), found.first(ImuSettings)) == (None, IMU)
    assert named(found.further) == [("gps", "gps/fix"), ("other", "other/fix")]
    assert not xml.notes


@pytest.mark.parametrize(
    ("cameras", "first"),
    [([DEPTH, CAMERA], CAMERA), ([CAMERA, DEPTH], CAMERA), ([DEPTH], DEPTH), ([], None)],
)
def test_the_first_camera_is_one_of_colours_where_there_is_one(
    cameras: list[SensorSettings], first: CameraSettings | None
) -> None:
    found = settle(urdf_file(), [GPS, *cameras])
    assert found.first(CameraSettings) == first
    assert len(found.further) == len(cameras) + 1 - (first is not None)
    assert found.further[0] == GPS
