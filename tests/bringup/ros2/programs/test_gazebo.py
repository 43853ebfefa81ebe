"""Gazebo's programs: a world that waits for its robot, and what spawns it there."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from arjuna_core.files.shipped import shipped_file
from bringup.ros2.errors import Ros2Error
from bringup.ros2.programs import gazebo

pytestmark = pytest.mark.ros
BURGER = shipped_file("urdf/burger.urdf")
_BOX = '<sdf version="1.7"><model name="b"><static>true</static><link name="l"/></model></sdf>'
_RUN = [sys.executable, "-m", "bringup.ros2.main", "run"]


@pytest.mark.system
@pytest.mark.timeout(150)
def test_the_spawned_robot_s_simulator_starts(tmp_path: Path) -> None:
    environment = {**os.environ, "ROS_DOMAIN_ID": "93", "HOME": str(tmp_path)}
    words = ["gazebo_ros", "gzserver", "-s", "libgazebo_ros_init.so", "empty.world"]
    log = tmp_path / "log"
    with log.open("wb") as output:
        world = subprocess.Popen(
            [*_RUN, *words], stdout=output, stderr=output, cwd=tmp_path, env=environment
        )
    try:
        spawn = ["gazebo_ros", "spawn_entity.py", "-file", str(BURGER), "-entity", "bot", "-x", "1"]
        done = subprocess.run(
            [*_RUN, *spawn],
            capture_output=True,
            text=True,
            env=environment,
            timeout=70,
            check=False,
        )
        assert done.stdout == "spawned bot\n", done.stderr + log.read_text()
        asked = subprocess.run(
            [sys.executable, "-c", _ASK],
            capture_output=True,
            text=True,
            env=environment,
            timeout=60,
        )
        assert asked.stdout.strip().endswith(".urdf 1.0"), asked.stderr + log.read_text()
    finally:
        world.terminate()
        world.wait(30)


_ASK = """
from contextlib import closing
from rcl_interfaces.srv import GetParameters
from bringup.client.simulator import SimulatorClient
with closing(SimulatorClient(40.0)) as client:
    request = GetParameters.Request(names=["robot", "initial_pose.x"])
    values = client.call(GetParameters, "/sim/get_parameters", request, 40.0)
    print(values.values[0].string_value, values.values[1].double_value)
"""


def test_only_a_robot_is_waited_for(tmp_path: Path) -> None:
    (tmp_path / "box.sdf").write_text(_BOX)
    assert gazebo.unfit(BURGER) == ""
    assert gazebo.unfit(tmp_path / "box.sdf")
    assert "no.urdf" in gazebo.unfit(tmp_path / "no.urdf")


@pytest.mark.parametrize("name", ["empty.world", "turtlebot3_world.world", str(BURGER)])
def test_a_world_is_found_by_path_or_name(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    world = tmp_path / "share" / "turtlebot3_gazebo" / "worlds" / "turtlebot3_world.world"
    world.parent.mkdir(parents=True)
    world.touch()
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    assert gazebo.world_of(name).is_file()


@pytest.mark.parametrize(
    ("words", "world"),
    [
        ("-r -s /tmp/playground.sdf", "/tmp/playground.sdf"),
        ("-r -s -v4 shapes.sdf", "shapes.sdf"),
        ("-s libgazebo_ros_init.so -s libgazebo_ros_factory.so my.world", "my.world"),
        ("--verbose -s libgazebo_ros_init.so", "empty.world"),
        ("house.world --ros-args --params-file gazebo.yaml", "house.world"),
    ],
)
def test_the_world_is_the_word_that_names_one(words: str, world: str) -> None:
    assert gazebo.named_world(words.split()) == world


def test_an_unknown_world_names_the_nearest() -> None:
    with pytest.raises(Ros2Error, match=r"no world 'wearhouse\.world'; did you mean 'warehouse"):
        gazebo.world_of("wearhouse.world")
