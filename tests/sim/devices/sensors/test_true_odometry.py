"""True motion on topics of the file's: p3d and OdometryPublisher."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.devices.sensors.true_odometry import TrueOdometrySettings
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from tests.sim import drive_cases as cases
from tests.sim.builders import run, simulator, texts
from tests.sim.robot_files.tags import sides

P3D, GZ = "libgazebo_ros_p3d.so", "gz-sim-odometry-publisher-system"


def robot_of(folder: Path, *plugins: str, drive: cases.Robot | None = None) -> Path:
    path = (drive or cases.mecanum()).write(folder)
    path.write_text(path.read_text().replace("</robot>", f"{''.join(plugins)}</robot>"))
    return path


def settings_of(path: Path) -> list[TrueOdometrySettings]:
    robot = load_robot(path, SearchPath())
    assert not [note for note in texts(robot.notes) if "simulated" in note]
    return [s for s in robot.settings.sensors if isinstance(s, TrueOdometrySettings)]


@pytest.mark.parametrize(
    ("file", "inside", "values"),
    [
        (P3D, "", {"topic": "odom", "world_frame": "world", "link": "base", "rate": 50.0}),
        (P3D, "<bodyName>front_left_wheel</bodyName><topicName>state</topicName>"
              "<updateRate>10</updateRate><frameName>map</frameName>",
         {"topic": "state", "world_frame": "map", "link": "front_left_wheel", "rate": 10.0}),
        (P3D, "<body_name>base</body_name><ros><namespace>/demo</namespace>"
              "<remapping>odom:=p3d</remapping></ros><update_rate>20</update_rate>"
              "<gaussian_noise>0.01</gaussian_noise>",
         {"topic": "/demo/p3d", "rate": 20.0, "noise": 0.01, "frame": "base"}),
        (GZ, "<odom_frame>o</odom_frame><robot_base_frame>base</robot_base_frame>"
             "<odom_topic>/here</odom_topic><odom_publish_frequency>5</odom_publish_frequency>",
         {"topic": "/here", "world_frame": "o", "frame": "base", "rate": 5.0, "planar": True,
          "in_world": False}),
        (GZ, "<dimensions>3</dimensions>", {"topic": "odometry", "planar": False}),
    ],
)  # fmt: skip
def test_tags_say_topic_frames_and_rate(
    tmp_path: Path, file: str, inside: str, values: dict[str, Any]
) -> None:
    (found,) = settings_of(robot_of(tmp_path, cases.plugin(file, inside)))
    assert {name: getattr(found, name) for name in values} == values


@pytest.mark.parametrize("system", ["sensors", "imu", "contact", "user-commands"])
def test_one_that_names_wheels_is_no_second_drive(tmp_path: Path, system: str) -> None:
    """A car's file named its wheels there too, and had the world's systems beside its own."""
    own = cases.plugin(GZ, sides("rear")), cases.plugin(f"gz-sim-{system}-system")
    path = robot_of(tmp_path, *own, drive=cases.car("gz"))
    assert len(settings_of(path)) == 1
    drive = load_robot(path, SearchPath()).drive
    assert drive.steering == ("front_left_wheel_steer_joint", "front_right_wheel_steer_joint")


@pytest.mark.parametrize(("file", "in_world"), [(P3D, True), (GZ, False)])
def test_motion_is_the_true_one(tmp_path: Path, file: str, in_world: bool) -> None:
    path = robot_of(tmp_path, cases.plugin(file))
    (settings,) = settings_of(path)
    sim = simulator(robot=path, spawn=SE2(1.0, 0.5, 0.7))
    truth = run(sim, 2.0, Velocity(0.2, y=0.3, yaw_rate=0.4)).truth
    found = sim.robot.sense(settings, sim.time)
    assert found.pose.planar().distance(truth.pose) < 1e-9
    c, s = (np.cos(truth.pose.theta), np.sin(truth.pose.theta)) if in_world else (1.0, 0.0)
    wanted = c * truth.v - s * truth.side, s * truth.v + c * truth.side
    assert found.twist[:2] == pytest.approx(wanted, abs=5e-3)
    assert found.twist[5] == pytest.approx(truth.w, abs=5e-3)
    assert (found.pose.position[2] == 0.0) == settings.planar


def test_noise_is_that_of_the_file(tmp_path: Path) -> None:
    noise = "<gaussian_noise>0.05</gaussian_noise>"
    path = robot_of(tmp_path, cases.plugin(P3D, noise))
    (settings,) = settings_of(path)
    sim = simulator(robot=path)
    seen = [sim.robot.sense(settings, 0.0) for _ in range(200)]
    x = np.array([each.pose.position[0] for each in seen])
    assert x.std() == pytest.approx(0.05, rel=0.2)
    assert np.array([each.twist for each in seen]).std(axis=0) == pytest.approx(0.05, rel=0.3)


def test_base_that_reports_the_truth_itself_does_so_once(tmp_path: Path) -> None:
    """VelocityControl with an OdometryPublisher on the topic of the robot's odometry."""
    topic = "<odom_topic>odom</odom_topic>"
    path = robot_of(tmp_path, cases.plugin(GZ, topic), drive=cases.planar_on())
    assert settings_of(path) == []
    other = cases.plugin(GZ, topic.replace("odom<", "true<"))
    assert len(settings_of(robot_of(tmp_path, other, drive=cases.planar_on()))) == 1


@pytest.mark.parametrize(("own", "frame"), [("odom", "world"), ("other", "odom")])
def test_wheels_whose_topic_a_publisher_has_report_the_truth(
    own: str, frame: str, tmp_path: Path
) -> None:
    """Both published on /odom, and a filter of wheels and gyro too."""
    tags = f"<odom_topic>{own}</odom_topic><odom_frame>world</odom_frame>"
    path = robot_of(tmp_path, cases.plugin(GZ, tags))
    drive = load_robot(path).drive
    assert (drive.from_world, drive.odometry_frame) == (own == "odom", frame)
    assert drive.tells_truth is (own == "odom"), "so that no filter corrects it"
    assert len(settings_of(path)) == (own != "odom")
