"""The packages that other people's launch files refer to, as folders of an ament prefix.

Made once from the tables of programs and launch files: `lib/PACKAGE/EXECUTABLE` starts what
`ros2 run` does, `share/PACKAGE/launch/FILE` what `ros2 launch` does, and worlds, models and
parameters are those that ship with Arjuna.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import tempfile
from pathlib import Path

from arjuna_core.files.array_cache import cache_folder
from arjuna_core.files.shipped import shipped_file
from arjuna_core.ros.context import add_environment_to_ament_index
from bringup.ros2.launches import COMPOSED, DESCRIBED, LAUNCHES
from bringup.ros2.stock import STOCK_FILES
from bringup.ros2.verbs.forward import GENERATED, PROGRAMS

_VARIABLE = "AMENT_PREFIX_PATH"
_LAUNCH = '''"""Starts what this launch file of {package} starts, by a command of Arjuna."""

from bringup.ros2.verbs.launch import description


def generate_launch_description():
    return description("{package}", "{file}")
'''
_PROGRAM = '#!/bin/sh\nexec {python} -m bringup.ros2.main run {package} {name} "$@"\n'
_MANIFEST = """<?xml version="1.0"?>
<package format="3">
  <name>{0}</name>
  <version>0.0.0</version>
  <description>What Arjuna has of {0}.</description>
  <maintainer email="none@example.com">Arjuna</maintainer>
  <license>Apache-2.0</license>
</package>
"""
_SERVER = """<launch>
  <arg name="port" default="{port}"/>
  <arg name="address" default="127.0.0.1"/>
  <node pkg="{package}" exec="{program}" output="screen">
    <param name="port" value="$(var port)"/>
    <param name="address" value="$(var address)"/>
  </node>
</launch>
"""
_SERVERS = {
    "foxglove_bridge": ("foxglove_bridge", 8765),
    "rosbridge_server": ("rosbridge_websocket", 9090),
}
"""The program of each package whose launch file serves clients, and its port."""
_BURGER, _PILLARS = "urdf/burger.urdf", "worlds/pillar_arena.world"
_TURTLEBOTS = ("burger", "waffle", "waffle_pi")
"""Values of `TURTLEBOT3_MODEL`; the Burger stands for all of them."""
_RVIZ = """Visualization Manager:
  Displays:
    - {Class: rviz_default_plugins/RobotModel, Description Topic: {Value: /robot_description}}
    - {Class: rviz_default_plugins/TF, Enabled: true}
    - {Class: rviz_default_plugins/LaserScan, Enabled: true, Topic: {Value: /scan}}
    - {Class: rviz_default_plugins/Map, Enabled: true, Topic: {Value: /map}}
    - {Class: rviz_default_plugins/Path, Enabled: true, Topic: {Value: /plan}}
  Global Options: {Fixed Frame: map}
"""
_VIEWS = (
    "nav2_bringup/rviz/nav2_default_view.rviz",
    "nav2_bringup/rviz/nav2_namespaced_view.rviz",
    "nav2_route/rviz/route_tool.rviz",
    "slam_toolbox/config/slam_toolbox_default.rviz",
    "turtlebot3_bringup/rviz/model.rviz",
    "turtlebot3_navigation2/rviz/tb3_navigation2.rviz",
    "urdf_launch/config/urdf.rviz",
)
_BRIDGED = (
    "nav2_minimal_tb3_sim/configs/turtlebot3_waffle_bridge.yaml",
    "nav2_minimal_tb4_sim/configs/tb4_bridge.yaml",
    *(f"turtlebot3_gazebo/params/turtlebot3_{kind}_bridge.yaml" for kind in _TURTLEBOTS),
)
_BOX = """<sdf version="1.7">
  <model name="cardboard_box">
    <link name="link">
      <inertial><mass>20</mass></inertial>
      <collision name="box"><geometry><box><size>0.5 0.4 0.3</size></box></geometry></collision>
      <visual name="box"><geometry><box><size>0.5 0.4 0.3</size></box></geometry></visual>
    </link>
  </model>
</sdf>
"""
_GAZEBO = {
    **dict.fromkeys(("gz", "ign", "gazebo", "gzserver"), "gzserver"),  # `gz sim -s WORLD`
    "gzclient": "gzclient",
}
_OF_ROS1 = ("turtlebot3_navigation", "turtlebot3_slam", "turtlebot3_teleop")
_WHOLE = """desktop gazebo_plugins gazebo_ros2_control gazebo_ros_pkgs gz_ros2_control
ign_ros2_control navigation2 ros2_control ros2_controllers ros_base ros_gz ros_ign turtlebot3
turtlebot3_simulations turtlebot4_simulator"""
"""Packages that stand for others, or for plug-ins of Gazebo that `arjuna sim` reads itself: launch
files put their folders on paths."""
SHIPPED = {
    **{
        f"nav2_bt_navigator/behavior_trees/{path.name}": f"behavior_trees/{path.name}"
        for path in sorted(shipped_file("behavior_trees").glob("*.xml"))
    },
    "gazebo_ros/worlds/empty.world": "worlds/empty.world",
    "nav2_bringup/maps/depot.yaml": "maps/warehouse.yaml",
    "nav2_bringup/maps/warehouse.png": "maps/warehouse.png",
    "nav2_bringup/maps/warehouse.yaml": "maps/warehouse.yaml",
    "nav2_bringup/maps/tb3_sandbox.yaml": "maps/pillar_arena.yaml",
    "nav2_bringup/maps/pillar_arena.png": "maps/pillar_arena.png",
    "nav2_bringup/maps/turtlebot3_world.yaml": "maps/pillar_arena.yaml",
    "nav2_bringup/params/nav2_params.yaml": "params/arjuna_nav.yaml",
    **{
        f"nav2_minimal_tb3_sim/urdf/{name}": _BURGER
        for name in ("gz_waffle.sdf", "gz_waffle.sdf.xacro", "turtlebot3_waffle.urdf")
    },
    "nav2_minimal_tb3_sim/worlds/pillar_arena.png": "worlds/pillar_arena.png",
    "nav2_minimal_tb3_sim/worlds/tb3_sandbox.sdf.xacro": _PILLARS,
    "nav2_minimal_tb4_description/urdf/standard/turtlebot4.urdf.xacro": _BURGER,
    "nav2_minimal_tb4_sim/worlds/depot.sdf": "worlds/warehouse.world",
    "nav2_minimal_tb4_sim/worlds/warehouse.sdf": "worlds/warehouse.world",
    "ros_gz_sim/worlds/empty.sdf": "worlds/empty.world",
    **{
        f"slam_toolbox/config/mapper_params_{name}.yaml": "params/arjuna_slam.yaml"
        for name in ("lifelong", "localization", "offline", "online_async", "online_sync")
    },
    **{
        name.format(kind): _BURGER
        for kind in _TURTLEBOTS
        for name in (
            "turtlebot3_description/urdf/turtlebot3_{}.urdf",
            "turtlebot3_description/urdf/turtlebot3_{}.urdf.xacro",
            "turtlebot3_gazebo/models/turtlebot3_{}/model.sdf",
            "turtlebot3_gazebo/urdf/turtlebot3_{}.urdf",
        )
    },
    "turtlebot3_gazebo/worlds/empty_world.world": "worlds/empty.world",
    "turtlebot3_gazebo/worlds/pillar_arena.png": "worlds/pillar_arena.png",
    "turtlebot3_gazebo/worlds/turtlebot3_house.world": "worlds/office.world",
    "turtlebot3_gazebo/worlds/turtlebot3_world.world": _PILLARS,
    "turtlebot3_navigation2/map/map.yaml": "maps/pillar_arena.yaml",
    "turtlebot3_navigation2/map/pillar_arena.png": "maps/pillar_arena.png",
    **{
        f"turtlebot3_navigation2/param/{kind}.yaml": "params/arjuna_nav.yaml"
        for kind in _TURTLEBOTS
    },
    "turtlebot4_navigation/config/localization.yaml": "params/arjuna_nav.yaml",
    "turtlebot4_navigation/config/nav2.yaml": "params/arjuna_nav.yaml",
    "turtlebot4_navigation/config/slam.yaml": "params/arjuna_slam.yaml",
    "turtlebot4_navigation/maps/warehouse.png": "maps/warehouse.png",
    "turtlebot4_navigation/maps/warehouse.yaml": "maps/warehouse.yaml",
}
"""Files below `share` that are shipped ones."""


def add_prefix() -> Path:
    """Put the prefix behind those of sourced workspaces, before this Python environment's."""
    folder = prefix_folder()
    given = [one for one in os.environ.get(_VARIABLE, "").split(os.pathsep) if one]
    kept = [one for one in given if one != sys.prefix and not (Path(one) / GENERATED).exists()]
    os.environ[_VARIABLE] = os.pathsep.join([*kept, str(folder)])
    add_environment_to_ament_index()
    return folder


def prefix_folder() -> Path:
    """Return the folder, made where it is not there yet: in the user's cache, or for this run."""
    texts = _texts()
    named = repr((sys.prefix, sorted(texts.items()), sorted(SHIPPED.items()), shipped_file("maps")))
    digest = hashlib.sha256(named.encode()).hexdigest()[:12]
    cache = cache_folder()
    folder = cache / f"ros-{digest}"
    if folder.is_dir():
        return folder
    try:
        cache.mkdir(parents=True, exist_ok=True)
        made = Path(tempfile.mkdtemp(prefix="ros-", dir=cache))
    except OSError:
        made = folder = Path(tempfile.mkdtemp(prefix="arjuna-ros-"))
    _write(made, texts)
    try:
        made.rename(folder)
    except OSError:  # another process was faster
        shutil.rmtree(made)
    return folder


def _texts() -> dict[str, str]:
    """Return the texts of the files that are written, by path."""
    packages = {package for package, _ in (*PROGRAMS, *LAUNCHES, *DESCRIBED)}
    packages |= {*_OF_ROS1, *_WHOLE.split(), *(name.partition("/")[0] for name in SHIPPED)}
    found = {GENERATED: "This folder can be removed: it is made again.\n"}
    for package in packages:
        found[f"share/ament_index/resource_index/packages/{package}"] = ""
        found[f"share/{package}/package.xml"] = _MANIFEST.format(package)
    for package, name in PROGRAMS:
        program = _PROGRAM.format(python=sys.executable, package=package, name=name)
        found[f"lib/{package}/{name}"] = program
    for name, of in _GAZEBO.items():
        found[f"bin/{name}"] = _PROGRAM.format(python=sys.executable, package="gazebo_ros", name=of)
    found |= {f"share/{name}": _RVIZ for name in _VIEWS}
    found |= {f"share/{name}": text for name, text in STOCK_FILES.items()}
    found |= {f"share/{name}": "[]\n" for name in _BRIDGED}
    found["share/nav2_minimal_tb3_sim/urdf/cardboard_box.sdf"] = _BOX
    for package, file in (*LAUNCHES, *COMPOSED, *DESCRIBED):
        found[f"share/{package}/launch/{file}"] = _launch(package, file)
    return found


def _launch(package: str, file: str) -> str:
    """Return the text of a launch file."""
    if package not in _SERVERS:
        return _LAUNCH.format(package=package, file=file)
    program, port = _SERVERS[package]
    return _SERVER.format(package=package, program=program, port=port)


def _write(folder: Path, texts: dict[str, str]) -> None:
    for name, text in texts.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        path.chmod(0o644 if name.startswith("share/") else 0o755)
    for name, source in SHIPPED.items():
        path = folder / "share" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.symlink_to(shipped_file(source))
    for share in (folder / "share").iterdir():  # interfaces of the same package
        for beside in Path(sys.prefix, "share", share.name).glob("*"):
            if share.name != "ament_index" and not (share / beside.name).exists():
                (share / beside.name).symlink_to(beside)
