"""The settings of ROS 1's launch files, as roslaunch reads them."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import is_xml
from bringup.parameters.foreign.launch_file import LaunchFile
from tests.helpers.files import write_all, written

_NAVIGATION = """<?xml version="1.0"?>
<launch>
  <!-- as guides print them -->
  <arg name="particles" default="80"/>
  <arg name="laser" value="robot/$(arg name)"/>
  <node pkg="map_server" type="map_server" name="map_server" args="/home/me/map.yaml"/>
  <node pkg="amcl" type="amcl" name="localizer" args="scan:=/laser">
    <remap from="scan" to="robot/laser/scan"/>
    <param name="max_particles" value="$(arg particles)"/>
    <param name="odom_model_type" value="diff"/>
    <param name="~kld_err" type="double" value="0.01"/>
    <param name="odom_frame_id" type="str" value="0"/>
    <param name="use_map_topic" value="true"/>
    <param name="initial_pose_x" value="$(arg start)"/>
    <param name="robot_description" command="xacro x"/>
  </node>
  <include file="$(dirname)/parts/move_base.launch"><arg name="speed" value="0.3"/></include>
  <include file="$(find nowhere)/other.launch"/>
  <node pkg="rviz" type="rviz" name="rviz"><param name="min_particles" value="1"/></node>
</launch>
"""
_MOVE_BASE = """<launch>
  <arg name="speed" default="0.9"/>
  <group ns="robot1" unless="false">
    <node pkg="move_base" type="move_base" name="move_base">
      <rosparam file="$(find my_robot)/params/common.yaml" command="load" ns="global_costmap"/>
      <rosparam file="$(find my_robot)/params/common.yaml" command="load" ns="local_costmap"/>
      <rosparam file="../params/local.yaml" command="load"/>
      <rosparam subst_value="true">DWAPlannerROS: {max_vel_x: $(arg speed)}</rosparam>
      <rosparam command="delete" param="recovery_behaviors"/>
      <param name="DWAPlannerROS/acc_lim_x" value="1.5"/>
      <param name="controller_frequency" value="5" if="$(arg slow)"/>
      <param name="planner_frequency" value="2" if="0"/>
    </node>
  </group>
</launch>
"""


def _package(folder: Path) -> Path:
    """Write a package with two launch files and their parameters; return the outer one's path."""
    root = folder / "src" / "my_robot"
    files = {
        "package.xml": "<package><name>my_robot</name></package>",
        "launch/navigation.launch": _NAVIGATION,
        "launch/parts/move_base.launch": _MOVE_BASE,
        "params/common.yaml": "{robot_radius: 0.2, obstacle_range: 2.5}",
        "launch/params/local.yaml": "{local_costmap: {robot_radius: 0.3, width: 4}}",
    }
    write_all(root, files)
    return root / "launch" / "navigation.launch"


def test_parameters_of_all_files_come_together(tmp_path: Path) -> None:
    launch = LaunchFile(_package(tmp_path))
    assert launch.document == {
        "amcl": {
            "max_particles": 80,
            "odom_model_type": "diff",
            "kld_err": 0.01,
            "odom_frame_id": "0",
            "use_map_topic": True,
        },
        "move_base": {
            "global_costmap": {"robot_radius": 0.2, "obstacle_range": 2.5},
            "local_costmap": {"robot_radius": 0.3, "obstacle_range": 2.5, "width": 4},
            "DWAPlannerROS": {"max_vel_x": 0.3, "acc_lim_x": 1.5},
        },
    }
    assert launch.topics == {"amcl": {"scan": "robot/laser/scan"}}


def test_what_cannot_be_followed_is_noted(tmp_path: Path) -> None:
    assert LaunchFile(_package(tmp_path)).notes == [
        "navigation.launch: <arg>: the value of $(arg name) is not known",
        "navigation.launch: <param>: the value of $(arg start) is not known",
        "move_base.launch: <param>: the value of $(arg slow) is not known",
        "navigation.launch: <include>: the value of $(find nowhere) is not known",
    ]


def test_the_environment_is_asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = written(
        tmp_path,
        '<launch><node type="slam_gmapping" args="_delta:=0.1 __name:=x scan:=$(env SCAN)">'
        '<remap from="odom" to="wheels"/>'
        '<param name="particles" value="$(optenv COUNT 30)"/></node></launch>',
        "a.launch",
    )
    monkeypatch.setenv("SCAN", "front")
    launch = LaunchFile(path)
    assert launch.document == {"slam_gmapping": {"delta": 0.1, "particles": 30}}
    assert launch.topics == {"slam_gmapping": {"scan": "front", "odom": "wheels"}}


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("<launch>", "is broken XML"),
        ("<robot/>", "is XML of <robot>; valid: <launch>"),
        ('<!DOCTYPE x [<!ENTITY a "b">]><launch/>', "declares a DTD or entities"),
        ('<launch><include file="$(dirname)/a.launch"/></launch>', "is included 10 files deep"),
        ('<launch><node type="amcl"><rosparam>[</rosparam></node></launch>', "that is no YAML"),
        ('<launch><node type="amcl"><rosparam>3</rosparam></node></launch>', "names and values"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused(text: str, problem: str, tmp_path: Path) -> None:
    path = written(tmp_path, text, "a.launch")
    assert is_xml(path)
    with pytest.raises(InputFileError, match=problem):
        LaunchFile(path)


def test_a_hundred_files_are_read_and_no_more(tmp_path: Path) -> None:
    path, include = tmp_path / "a.launch", '<include file="$(dirname)/b.launch"/>'
    (tmp_path / "b.launch").write_text("<launch/>")
    path.write_text(f"<launch>{99 * include}</launch>")
    assert LaunchFile(path).notes == []
    path.write_text(f"<launch>{100 * include}</launch>")
    with pytest.raises(InputFileError, match="is one of more than 100 that are included"):
        LaunchFile(path)


def test_yaml_is_no_launch_file(tmp_path: Path) -> None:
    path = tmp_path / "a.launch"
    assert not is_xml(path)
    path.write_text("amcl: {max_particles: 80}", encoding="utf-8")
    assert not is_xml(path)
