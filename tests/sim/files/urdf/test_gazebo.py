"""Gazebo tags of a URDF that stand outside a sensor."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_sim.check import check
from arjuna_sim.devices.sensors.lidar import LidarSettings
from arjuna_sim.files.search_path import SearchPath
from tests.sim.builders import texts
from tests.sim.files.test_robots import TWO, _load, _robot

_LIDAR = """<plugin name="lidar" filename="libgazebo_ros_ray_sensor.so">
<ros><remapping>~/out:=scan</remapping></ros><output_type>sensor_msgs/LaserScan</output_type>
<frame_name>{}</frame_name></plugin>"""


@pytest.mark.parametrize(
    ("file", "type_"),
    [
        ("libgazebo_ros_ray_sensor.so", "ray"),
        ("libgazebo_ros_laser.so", "ray"),
        ("libgazebo_ros_gpu_laser.so", "gpu_ray"),
        ("libgazebo_ros_camera.so", "camera"),
        ("libgazebo_ros_openni_kinect.so", "depth"),
        ("libgazebo_ros_imu_sensor.so", "imu"),
    ],
)
@pytest.mark.parametrize(("frame", "link"), [("left_wheel", "left_wheel"), ("laser_link", "LINK")])
def test_a_sensors_plugin_outside_it_says_where_it_goes(
    tmp_path: Path, file: str, type_: str, frame: str, link: str
) -> None:
    plugin = _LIDAR.format(frame).replace("libgazebo_ros_ray_sensor.so", file)
    robot = _load(tmp_path, f"{TWO}<gazebo>{plugin}</gazebo>")
    assert robot.settings.sensors == ()
    (said,) = [note for note in texts(robot.notes) if "plugin 'lidar'" in note]
    assert "stands outside <sensor>" in said
    assert f'<gazebo reference="{link}"><sensor type="{type_}" name="NAME">' in said


def test_a_ray_outside_a_sensor_says_where_it_goes_in_the_check_too(tmp_path: Path) -> None:
    ray = "<ray><scan><horizontal><samples>360</samples></horizontal></scan></ray>"
    inside = f"{TWO}<gazebo reference='ball'>{ray}{_LIDAR.format('ball')}</gazebo>"
    found = check(_robot(tmp_path, inside), SearchPath(), {})
    cure = 'put it into <gazebo reference="ball"><sensor type="ray" name="NAME">'
    assert sum(cure in note for note in texts(found.notes)) == 2


def test_inside_a_sensor_nothing_is_said(tmp_path: Path) -> None:
    sensor = f"<sensor type='ray' name='s'>{_LIDAR.format('ball')}</sensor>"
    robot = _load(tmp_path, f"{TWO}<gazebo reference='ball'>{sensor}</gazebo>")
    assert robot.settings.first(LidarSettings) is not None
    assert not any("outside" in note for note in texts(robot.notes))
