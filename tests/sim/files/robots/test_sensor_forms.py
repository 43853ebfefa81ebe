"""Sensors of rays are what they are by their form, and SLAM's lidar looks around it."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_sim.devices.sensors.lidar import CloudSettings, LidarSettings, RangeSettings
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.model.optical import sensor_frame
from tests.sim.sensor_cases import SensorRobot, sensor_robots

ROBOTS = list(sensor_robots(60))


@pytest.mark.parametrize("robot", ROBOTS, ids=[str(i) for i in range(len(ROBOTS))])
def test_each_sensor_is_what_its_form_says(tmp_path: Path, robot: SensorRobot) -> None:
    model = load_robot(robot.write(tmp_path), SearchPath())
    sensors = model.settings.sensors
    leading = [case.name for case in robot.cases if case.form.leads]
    lidar = model.settings.first(LidarSettings)
    assert (lidar.name.removesuffix("_level") if lidar else "") == (leading or [""])[0]
    for case in robot.cases:
        found = [s for s in sensors if s.name.removesuffix("_level") == case.name]
        assert sorted(type(s).__name__ for s in found) == sorted(
            kind.__name__ for kind in case.form.outputs
        )
        for sensor in found:
            assert sensor_frame(model.urdf, sensor).name == case.frame
            assert sensor.topic.startswith(f"{case.name}/out")
            if isinstance(sensor, RangeSettings):
                assert sensor.infrared is case.form.infrared
            assert sensor.name == case.name or CloudSettings in case.form.outputs
    assert len({sensor.topic for sensor in sensors}) == len(sensors)
