"""Launch files of the guides as they stand, and of the shapes of other people's robots.

What each starts is recorded, not run: a program's own words, and what ROS is told of it.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import yaml
from launch import LaunchContext
from launch.events.process import ProcessExited, ProcessStarted
from launch.execute_process import ExecuteProcess
from launch_ros import lifecycle

from bringup.cli import parse
from bringup.ros2.prefix import add_prefix
from bringup.ros2.verbs import launch as verb

pytestmark = pytest.mark.ros
FILES = Path(__file__).parent / "files"
URDF = '<robot name="r"><link name="base_link"/></robot>'
_FILTERS = """
lanes_filter_info_server: {ros__parameters: {filter_info_topic: /lanes, mask_topic: /mask}}
keepout_filter_mask_server: {ros__parameters: {yaml_filename: "", topic_name: /keepout_mask}}
"""
_EMPTY = "{Visualization Manager: {Displays: []}}"


class Started(NamedTuple):
    """The processes of a launch file, and what was said of it.

    Attributes:
        lines: `PACKAGE/EXECUTABLE words` or `arjuna COMMAND words`; folders are left out of paths.
        parameters: Those of each line's files, merged.
    """

    code: int
    lines: list[str]
    parameters: list[dict[str, Any]]
    said: str


def _workspace(prefix: Path) -> None:
    for package in ("my_robot", "my_nav_robot", "first_pkg"):
        share, lib = prefix / "share" / package, prefix / "lib" / package
        texts = {
            share / "urdf" / "robot.urdf": URDF,
            share / "launch" / "rsp.launch.py": (FILES / "rsp.launch.py").read_text(),
            share / "config" / "twist_mux.yaml": "twist_mux: {ros__parameters: {a: 1}}",
            share / "config" / "ekf.yaml": "ekf_filter_node: {ros__parameters: {frequency: 30.0}}",
            share / "config" / "filters.yaml": _FILTERS,
            share / "config" / "slam.yaml": "slam_toolbox: {ros__parameters: {mode: mapping}}",
            share / "config" / "slam_params.yaml": "slam_toolbox: {ros__parameters: {}}",
            share / "config" / "nav2_params.yaml": "bt_navigator: {ros__parameters: {}}",
            share / "config" / "nav2_default.rviz": _EMPTY,
            share / "rviz" / "rviz_config.rviz": _EMPTY,
            share / "maps" / "my_map.yaml": "image: my_map.pgm",
            prefix / "share/ament_index/resource_index/packages" / package: "",
            lib / "talker": "#!/bin/sh\n",
            lib / "controller_node": "#!/bin/sh\n",
            lib / "simple_pose.py": "#!/bin/sh\n",
        }
        for path, text in texts.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
            path.chmod(0o755)


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache")


@pytest.fixture
def started(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Started]:
    _workspace(tmp_path / "install")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:/usr/bin:/bin")
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "log"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    monkeypatch.setenv("HOME", "/home/user")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "urdf").mkdir()
    (tmp_path / "urdf" / "robot.urdf").write_text(URDF)
    made = add_prefix()
    recorded: list[tuple[str, dict[str, Any]]] = []
    monkeypatch.setattr(lifecycle, "_PATIENCE", 0.2)

    def record(action: Any, context: LaunchContext) -> None:
        words = action.words(context)
        recorded.append(_shown(words, (tmp_path / "install", made)))
        details = {"action": action, "name": "x", "cmd": words, "pid": 1}
        context.emit_event_sync(ProcessStarted(**details))
        context.emit_event_sync(ProcessExited(returncode=0, **details))

    monkeypatch.setattr(ExecuteProcess, "execute", record)

    def run(name: str, *words: str) -> Started:
        recorded.clear()
        code = verb.run([str(FILES / name), *words])
        given = capsys.readouterr()
        lines = [line for line, _ in recorded]
        return Started(code, lines, [values for _, values in recorded], given.out + given.err)

    return run


def _shown(words: list[str], prefixes: tuple[Path, ...]) -> tuple[str, dict[str, Any]]:
    if words[:2] == [sys.executable, "-m"]:
        ours = words[3:]
        if words[2] == "bringup":
            parse([word for word in ours if "$(" not in word])  # its options are there
        words = ["arjuna", *ours]
    values: dict[str, Any] = {}
    left: list[str] = []
    rest = iter(words)
    for word in rest:
        if word == "--params-file":
            document = yaml.safe_load(Path(next(rest)).read_text())
            values |= next(iter(document.values()))["ros__parameters"]
        else:
            left.append(word)
    line = " ".join(left)
    for prefix in prefixes:
        line = line.replace(f"{prefix}/lib/", "").replace(f"{prefix}/share/", "")
    line = re.sub(r"/\S*/(?=(urdf|worlds|maps)/)", "", line)
    line = re.sub(r"(?s)<\?xml.*</robot>\n?", "SDF", re.sub(r"/tmp/nav2_\S+", "WORLD", line))
    return re.sub(r"/\S*/arjuna-launch-\S+\.yaml", "TMP", line), values


_TB3_WORLD = "turtlebot3_gazebo/worlds/turtlebot3_world.world"
_BURGER = "turtlebot3_description/urdf/turtlebot3_burger.urdf.xacro"
_REMAPS = "-r /tf:=tf -r /tf_static:=tf_static"
_LEVEL = "--ros-args --log-level info --ros-args"
SEEDS: dict[str, list[str]] = {
    "robot_launch.py": [
        "robot_state_publisher/robot_state_publisher --ros-args -r __node:=robot_state_publisher",
        "my_robot/controller_node --ros-args -r __node:=controller",
    ],
    "sim_launch.py": [
        "arjuna run gazebo_ros gzserver turtlebot3_world.world",
        "robot_state_publisher/robot_state_publisher",
        "gazebo_ros/spawn_entity.py -entity my_robot -topic robot_description"
        " -x 0.0 -y 0.0 -z 0.05",
        "slam_toolbox/async_slam_toolbox_node",
        "arjuna nav --without-localization --params my_nav_robot/config/nav2_params.yaml",
        "rviz2/rviz2 -d my_nav_robot/config/nav2_default.rviz",
    ],
    "simulation2.launch": [
        "arjuna sim --world worlds/empty.world --robot urdf/burger.urdf --at 0.0 0.0",
        "arjuna run first_pkg simple_pose.py",
    ],
    "map_only.launch": [
        f"arjuna sim --world {_TB3_WORLD} --robot {_BURGER} --at -2 0",
        "arjuna run nav2_map_server map_server --ros-args -p"
        " yaml_filename:=first_pkg/maps/my_map.yaml",
        "arjuna nav --without-localization",
        "arjuna view --config first_pkg/rviz/rviz_config.rviz",
    ],
    "amcl.launch": [
        f"arjuna sim --world {_TB3_WORLD} --robot {_BURGER} --at -2 0",
        "arjuna nav --map first_pkg/maps/my_map.yaml --params TMP",
        "arjuna view --config first_pkg/rviz/rviz_config.rviz",
    ],
}
"""What the guides' launch files start."""
SHAPES: dict[str, list[str]] = {
    "articulated_robot.launch.py": [
        "controller_manager/ros2_control_node",
        "controller_manager/spawner diff_cont",
    ],
    "articulated_sim.launch.py": [
        "robot_state_publisher/robot_state_publisher",
        "twist_mux/twist_mux --ros-args -r /cmd_vel_out:=/diff_cont/cmd_vel_unstamped",
        "arjuna run gazebo_ros gzserver",
        "gazebo_ros/spawn_entity.py -topic robot_description -entity my_bot",
        "controller_manager/spawner diff_cont",
        "controller_manager/spawner joint_broad",
    ],
    "demo_launch.xml": [
        "my_robot/talker --rate 5 my_robot/a b --ros-args -r __node:=r1_base -r __ns:=/r1"
        " -r chatter:=/talk",
        "arjuna slam",
        "foxglove_bridge/foxglove_bridge",
        f"echo {FILES}",
    ],
    "demo_launch.yaml": [
        "my_robot/talker --ros-args -r __node:=sim -r __ns:=/turtlesim1"
        " -r /input/pose:=/turtlesim1/turtle1/pose",
        "my_robot/talker --rate 5 my_robot/a b --ros-args -r __node:=r2_base -r __ns:=/r2"
        " -r chatter:=/talk",
        "arjuna slam",
        "foxglove_bridge/foxglove_bridge",
        f"echo {FILES}",
        "echo done",
    ],
    "display.launch.py": [
        "robot_state_publisher/robot_state_publisher",
        "joint_state_publisher_gui/joint_state_publisher_gui",
        "rviz2/rviz2 -d my_robot/rviz/urdf.rviz",
    ],
    "drivers.launch.py": [
        "robot_localization/ekf_node --ros-args -r __node:=ekf_filter_node",
        "my_robot/talker --ros-args -r __node:=rf2o_False",
    ],
    "gz_actions.launch.py": [
        "arjuna run ros_gz_sim gzserver empty.sdf",
        "arjuna run ros_gz_bridge parameter_bridge --ros-args -p"
        " config_file:=my_robot/config/bridge.yaml",
        "arjuna run ros_gz_sim create -topic /robot_description -name sam_bot -z 0.65",
    ],
    "gz_actions_launch.xml": [
        "arjuna run ros_gz_sim gzserver empty.sdf",
        "arjuna run ros_gz_bridge parameter_bridge --ros-args -p"
        " config_file:=/config/bridge.yaml -r __ns:=/r1",
        "arjuna run ros_gz_sim create -file robot.sdf -name r1 -x 1.0",
        "arjuna run ros_gz_bridge parameter_bridge --ros-args -p config_file:=/config/other.yaml",
        "arjuna run ros_gz_sim create -topic robot_description",
    ],
    "gz_world.launch.py": [
        f"arjuna run ros_gz_sim gzserver -r -s -v2 {_TB3_WORLD}",
        "ros_gz_sim/create -name burger -topic robot_description -x -2.0 -y -0.5",
        "ros_gz_bridge/parameter_bridge /clock@rosgraph_msgs/msg/Clock[gz.msgs.Clock",
    ],
    "installed_paths.launch.py": [
        "arjuna slam --params /opt/ros/humble/share/no_package/a.yaml",
        "nav2_map_server/map_server",
        "rviz2/rviz2 -d nav2_bringup/rviz/nav2_default_view.rviz",
    ],
    "lifecycle_slam.launch.py": [
        "slam_toolbox/async_slam_toolbox_node --ros-args -r __node:=slam_toolbox"
    ],
    "linorobot.launch.py": [
        "robot_localization/ekf_node --ros-args -r __node:=ekf_filter_node"
        " -r odometry/filtered:=odom"
    ],
    "multi_robot.launch.py": [
        "ros_gz_sim/create -name robot1 -x 0.0 -topic robot_description"
        " --ros-args -r __ns:=/robot1",
        "arjuna nav --without-localization --namespace robot1",
        "ros_gz_sim/create -name robot2 -x 1.5 -topic robot_description"
        " --ros-args -r __ns:=/robot2",
        "arjuna nav --without-localization --namespace robot2",
    ],
    "namespaced.launch.py": [
        f"my_robot/talker --ros-args -r __node:=inside -r __ns:=/turtlebot4 {_REMAPS}",
        f"my_robot/talker --ros-args -r __node:=root {_REMAPS}",
        "my_robot/talker --ros-args -r __node:=outside",
    ],
    "navigation2.launch.py": [
        "arjuna robot --map turtlebot3_navigation2/map/map.yaml"
        " --params turtlebot3_navigation2/param/burger.yaml",
        "rviz2/rviz2 -d nav2_bringup/rviz/nav2_default_view.rviz --ros-args -r __node:=rviz2",
    ],
    "opaque.launch.py": [
        "my_robot/talker --ros-args -r __node:=husky_0 -r __ns:=/husky",
        "my_robot/talker --ros-args -r __node:=husky_1 -r __ns:=/husky",
    ],
    "own_action.launch.py": ["nice -n 5 talk --loud"],
    "own_namespace_if.launch.py": [
        "slam_toolbox/sync_slam_toolbox_node --ros-args -r __node:=slam_toolbox",
        "nav2_map_server/map_saver_server",
    ],
    "own_navigation.launch.py": [
        f"nav2_controller/controller_server {_LEVEL} {_REMAPS} -r cmd_vel:=cmd_vel_nav",
        f"nav2_planner/planner_server {_LEVEL} -r __node:=planner_server {_REMAPS}",
        f"nav2_behaviors/behavior_server {_LEVEL} -r __node:=behavior_server {_REMAPS}",
        f"nav2_bt_navigator/bt_navigator {_LEVEL} -r __node:=bt_navigator {_REMAPS}",
        "nav2_lifecycle_manager/lifecycle_manager --ros-args"
        " -r __node:=lifecycle_manager_navigation",
    ],
    "perception.launch.py": ["depthimage_to_laserscan/depthimage_to_laserscan_node"],
    "record_teleop.launch.py": [
        "joy/joy_node --ros-args -r __node:=joy_node",
        "teleop_twist_joy/teleop_node --ros-args -r __node:=teleop_twist_joy_node"
        " -r /cmd_vel:=cmd_vel",
        "ros2 bag record -a",
    ],
    "remapped_navigation.launch.py": [
        "nav2_map_server/costmap_filter_info_server --ros-args -r __node:=lanes_filter_info_server",
        "arjuna robot --leave-out lanes_filter_info_server --map my_map.yaml"
        " --params my_robot/config/filters.yaml"
        " --param route_server:graph_filepath:=halls.geojson"
        " --param keepout_filter_mask_server:yaml_filename:=no.yaml"
        " --cmd-vel-topic /cmd_vel_nav_out --remap /scan:=/scan_filtered",
        "twist_mux/twist_mux --ros-args -r /cmd_vel_out:=cmd_vel",
        "robot_localization/ekf_node --ros-args -r __node:=ekf_filter_node",
        "rviz2/rviz2 -d nav2_route/rviz/route_tool.rviz",
        "nav2_map_server/map_server",
    ],
    "rsp.launch.py": ["robot_state_publisher/robot_state_publisher"],
    "sandbox.launch.py": [
        "gz sim -r -s nav2_minimal_tb3_sim/worlds/tb3_sandbox.sdf.xacro",
        "ros_gz_sim/create -name turtlebot3_waffle"
        " -file nav2_minimal_tb3_sim/urdf/gz_waffle.sdf.xacro -robot_namespace"
        "  -x 1.0 -y -0.5 -Y 0.0",
        "robot_state_publisher/robot_state_publisher",
        "ros_gz_bridge/parameter_bridge",
        "ros_gz_sim/create -entity cardboard_box"
        " -file nav2_minimal_tb3_sim/urdf/cardboard_box.sdf -z 0.15",
        "gz sim nav2_minimal_tb4_sim/worlds/depot.sdf",
        "explore_lite/explore --ros-args -r __node:=explore_node"
        " -r /tf:=tf -r /tf_static:=tf_static",
        "ros_gz_sim/create -name two -file nav2_minimal_tb3_sim/urdf/gz_waffle.sdf.xacro"
        " -robot_namespace second -x -8.0 -y -0.5 -Y 0.0",
    ],
    "several_robots.launch.py": [
        line
        for name, x in (("robot1", 0.5), ("robot2", 0.0))
        for line in (
            f"ros_gz_bridge/parameter_bridge --ros-args -r __ns:=/{name}",
            f"ros_gz_sim/create -name {name} -string SDF -x {x} --ros-args -r __ns:=/{name}",
            "robot_state_publisher/robot_state_publisher",
            "rclcpp_components/component_container_isolated --ros-args --log-level info"
            f" --ros-args -r __node:=nav2_container -r __ns:=/{name}",
        )
    ],
    "slam_nav.launch.py": [
        "arjuna robot --without-localization",
        "arjuna slam --use-sim-time false --params my_robot/config/slam.yaml",
    ],
    "spawn_after.launch.py": [
        "ros_gz_sim/create -file robot.sdf",
        f"{Path(sys.executable).parent}/ros2 service call /spawn std_srvs/srv/Trigger",
        "ros2 control load_controller --set-state active joint_broad",
    ],
    "spawned.launch.py": [
        "xacro -o WORLD headless:=False world.sdf.xacro",
        "gz sim -r -s WORLD",
        "arjuna run ros_gz_sim gzserver -v4 -g",
        "ros_gz_bridge/parameter_bridge",
        "ros_gz_sim/create -name waffle -string SDF -x -2.00",
        "robot_state_publisher/robot_state_publisher",
        "rclcpp_components/component_container_isolated --ros-args --log-level info"
        " --ros-args -r __node:=nav2_container",
    ],
    "static_frames.launch.py": [
        "tf2_ros/static_transform_publisher --x 0.1 --frame-id base_link --child-frame-id laser",
        "tf2_ros/static_transform_publisher 0 0 0.2 0 0 0 base_link imu_link",
        "laser_filters/scan_to_scan_filter_chain --ros-args -r scan:=scan_raw",
    ],
    "turtlebot3_own_world.launch.py": [
        "arjuna run ros_gz_sim gzserver -r -s -v2 my_robot/worlds/my.world",
        "ros_gz_sim/create -name burger -file urdf/burger.urdf -x -2.0 -y -0.5 -z 0.01",
        "robot_state_publisher/robot_state_publisher --ros-args -r __node:=robot_state_publisher",
    ],
    "turtlesim_mimic.launch.py": [
        "my_robot/talker --ros-args -r __node:=mimic"
        " -r /input/pose:=/turtlesim1/turtle1/pose"
        " -r /output/cmd_vel:=/turtlesim2/turtle1/cmd_vel"
    ],
    "urdf_display.launch.py": [
        "robot_state_publisher/robot_state_publisher",
        "joint_state_publisher_gui/joint_state_publisher_gui",
        "rviz2/rviz2 -d urdf_launch/config/urdf.rviz",
        "joy/joy_node --ros-args -r __node:=joy_node",
        "teleop_twist_joy/teleop_node --ros-args -r __node:=teleop_twist_joy_node"
        " -r /cmd_vel:=/joy_vel",
    ],
}
"""What files of other people's robots' shapes start."""
SAID: dict[str, list[str]] = {
    "robot_launch.py": ["rplidar_ros rplidar_composition is not started", "beside 'arjuna robot'"],
    "amcl.launch": ["nobody knows 'odom_alphal'; did you mean 'odom_alpha1'?"],
    "demo_launch.xml": ["[INFO] [user]: later r1"],
    "demo_launch.yaml": ["[INFO] [user]: later r2"],
    "drivers.launch.py": [
        "rplidar_ros rplidar_a1_launch.py is not included; its driver is ROS's",
        "a launch file is not included: package 'realsense2_camera' not found",
        "usb_cam camera.launch.py is not included",
        "my_robot talker is not started: there is no parameter file /not/installed/share/usb",
        "[INFO] [user]: container started",
        "apriltag_ros AprilTagNode is not started",
        "no_cpp_node is not started",
        "valid: controller_node, simple_pose.py, talker; programs of C++ are built by ROS's",
    ],
    "lifecycle_slam.launch.py": [
        "Failed to make transition 1 of '/slam_toolbox': its services do not answer"
    ],
    "linorobot.launch.py": ["micro_ros_agent micro_ros_agent is not started"],
    "multi_robot.launch.py": ["started robot1", "started robot2"],
    "own_action.launch.py": [
        "[INFO] [user]: said ab",
        "[INFO] [user]: after talk",
        "\n        LogInfo(...)",
    ],
    "perception.launch.py": [
        "image_proc image_proc::RectifyNode is not started",
        "realsense2_camera_node is not",
    ],
    "several_robots.launch.py": [
        "number 1",
        "timed",
        "make transition 1 of '/slam_toolbox': its services do not answer",
    ],
    "static_frames.launch.py": ["rplidar_ros rplidar_node is not started", "[INFO] [user]: bye"],
    "turtlesim_mimic.launch.py": [
        "turtlesim turtlesim_node is not started: package 'turtlesim' not found; it draws"
    ],
}
"""What is said of some, as of what cannot be started."""


@pytest.mark.parametrize(("name", "lines"), {**SEEDS, **SHAPES}.items())
def test_a_launch_file_starts_what_it_names(
    name: str, lines: list[str], started: Callable[..., Started]
) -> None:
    found, said = started(name), SAID.get(name, [])
    assert [line.removesuffix(" --ros-args") for line in found.lines] == lines
    assert all(text in found.said for text in said), found.said
    assert found.code == int(any("is not started" in text for text in said))
    assert "Traceback" not in found.said


def test_every_file_is_tried() -> None:
    assert {path.name for path in FILES.iterdir() if path.is_file()} == {*SEEDS, *SHAPES}
    assert len(SHAPES) >= 20


@pytest.mark.parametrize(
    ("name", "words", "line", "values"),
    [
        ("opaque.launch.py", ["count:=1"], 0, {"gains": [1.0, 2.0], "nested.deep.value": True}),
        ("demo_launch.xml", [], 0, {"speed": 0.5, "label": "5", "a": 1}),
        ("demo_launch.xml", [], 2, {"port": 8766, "address": "127.0.0.1"}),
        ("robot_launch.py", ["use_sim_time:=true"], 0, {"use_sim_time": True}),
        ("sim_launch.py", [], 1, {"robot_description": URDF, "use_sim_time": True}),
        ("namespaced.launch.py", [], 0, {"use_sim_time": True}),
        ("static_frames.launch.py", [], 2, {}),
        ("spawned.launch.py", [], 5, {"use_sim_time": True}),
        ("own_navigation.launch.py", ["use_sim_time:=true"], 0, {"use_sim_time": True}),
        ("turtlebot3_own_world.launch.py", [], 2, {"use_sim_time": True, "frame_prefix": ""}),
        ("urdf_display.launch.py", [], 3, {"device_id": 1, "autorepeat_rate": 20.0}),
        ("urdf_display.launch.py", [], 4, {"publish_stamped_twist": True}),
        ("own_navigation.launch.py", ["use_composition:=True"], 1, {"use_sim_time": False}),
        (
            "own_navigation.launch.py",
            [],
            4,
            {
                "autostart": True,
                "node_names": [
                    *("controller_server", "planner_server", "behavior_server", "bt_navigator"),
                ],
            },
        ),
    ],
)
def test_parameters_reach_a_node_with_their_types(
    name: str,
    words: list[str],
    line: int,
    values: dict[str, Any],
    started: Callable[..., Started],
) -> None:
    found = started(name, *words).parameters[line]
    assert {key: found[key] for key in values} == values


def test_a_file_of_an_installed_ros_is_the_one_that_is_here(
    started: Callable[..., Started],
) -> None:
    path = started("installed_paths.launch.py").parameters[1]["yaml_filename"]
    assert Path(path) == add_prefix() / "share/nav2_bringup/maps/tb3_sandbox.yaml"


def test_poses_of_robots_are_read_from_the_command_line(
    started: Callable[..., Started], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["ros2", "poses:=a={x: 1.5}; b={yaw: 1.57}"])
    said = started("several_robots.launch.py").said
    assert "a 1.5 0.0" in said
    assert "b 0.0 1.57" in said


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("cloned_multi", ["robots:=a={x: 1.0, y: 0.5}; b={x: -1, yaw: 1.57}", "params_file:=p"]),
        (
            "cloned_multi",
            [
                "robots:={name: a, pose: {x: 1.0, y: 0.5}};{name: b, pose: {x: -1, yaw: 1.57}}",
                "params_file:=p",
            ],
        ),
        (
            "unique_multi",
            [
                *("robots:=a={x: 1.0, y: 0.5}; b={x: -1, yaw: 1.57}", "a_params_file:=p"),
                "b_params_file:=p",
            ],
        ),
    ],
)
def test_nav2_s_several_robots_are_one_world_and_navigation_for_each(
    name: str, words: list[str], started: Callable[..., Started]
) -> None:
    file = add_prefix() / "share/nav2_bringup/launch" / f"{name}_tb3_simulation_launch.py"
    found = started(str(file), *words, "use_rviz:=False", "autostart:=True")
    assert found.lines == [
        "arjuna sim --robot urdf/burger.urdf --world worlds/pillar_arena.world"
        " --namespace a --at 1.0 0.5 --heading 0.0 --namespace b --at -1.0 0.0 --heading 1.57",
        "arjuna nav --map maps/pillar_arena.yaml --namespace a --params p",
        "arjuna nav --map maps/pillar_arena.yaml --namespace b --params p",
    ]
    assert "robots: 'x' is no robot; valid: NAME={x" in started(str(file), "robots:=x").said


@pytest.mark.parametrize("name", ["tb3_simulation", "tb4_loopback_simulation"])
def test_nav2_s_simulation_is_world_navigation_and_view(
    name: str, started: Callable[..., Started]
) -> None:
    file = add_prefix() / "share/nav2_bringup/launch" / f"{name}_launch.py"
    start = "arjuna sim --robot urdf/burger.urdf --world worlds/pillar_arena.world --at"
    found = started(str(file), "namespace:=tb3", "x_pose:=1.0", "y_pose:=0.5", "headless:=False")
    assert found.lines == [
        f"{start} 1.0 0.5 --namespace tb3",
        "arjuna nav --map maps/pillar_arena.yaml --namespace tb3",
        "arjuna view --namespace tb3",
    ]
    assert started(str(file), "use_rviz:=False", "slam:=True").lines == [
        f"{start} -2 -0.5",
        "arjuna nav --slam",
    ]


def test_a_turtlebot4_is_a_docked_robot_in_the_warehouse(started: Callable[..., Started]) -> None:
    file = add_prefix() / "share/turtlebot4_gz_bringup/launch/turtlebot4_gz.launch.py"
    found = started(str(file), "nav2:=true", "localization:=true", "x:=1.0", "namespace:=b")
    assert found.lines == [
        "arjuna sim --robot urdf/burger.urdf --world worlds/warehouse.world"
        " --at 1.0 0.0 --heading 0.0 --namespace b",
        "arjuna nav --without-navigation --map maps/warehouse.yaml --namespace b",
        "arjuna nav --without-localization --namespace b",
        "irobot_create_nodes/motion_control --ros-args -r __ns:=/b",
    ]
    assert "--world worlds/office.world" in started(str(file), "world:=office").lines[0]
    assert "no world 'maze'; valid: apriltag" in started(str(file), "world:=maze").said
    spawn = add_prefix() / "share/turtlebot4_ignition_bringup/launch/turtlebot4_spawn.launch.py"
    assert started(str(spawn), "x:=1.0", "yaw:=0.5", "namespace:=b").lines == [
        "ros_gz_sim/create -name turtlebot4 -file urdf/burger.urdf -robot_namespace b"
        " -x 1.0 -y 0.0 -Y 0.5",
        "irobot_create_nodes/motion_control --ros-args -r __ns:=/b",
    ]


def test_a_description_made_by_xacro_keeps_its_text(started: Callable[..., Started]) -> None:
    for name in ("rsp.launch.py", "display.launch.py", "urdf_display.launch.py"):
        text = started(name).parameters[0]["robot_description"]
        assert '\n<robot name="r">' in text


@pytest.mark.parametrize(
    ("name", "words", "line"),
    [
        ("display.launch.py", ["gui:=false"], "joint_state_publisher/joint_state_publisher"),
        ("own_namespace_if.launch.py", ["mode:=amcl"], "nav2_amcl/amcl --ros-args -r __node:=amcl"),
        (
            "own_namespace_if.launch.py",
            ["use_namespace:=true", "mode:=amcl"],
            "nav2_amcl/amcl --ros-args -r __node:=amcl -r __ns:=/ns",
        ),
        ("demo_launch.xml", ["gui:=true"], "rviz2/rviz2"),
        ("slam_nav.launch.py", ["sim:=true"], "arjuna nav --without-localization"),
    ],
)
def test_an_argument_decides(
    name: str, words: list[str], line: str, started: Callable[..., Started]
) -> None:
    assert line not in started(name).lines
    assert line in started(name, *words).lines


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("x = 1", "has no function generate_launch_description()"),
        ("def generate_launch_description():\n    return 1", "valid: LaunchDescription"),
        ("import moveit_configs_utils", "'moveit_configs_utils' is not installed here"),
        (
            "from ament_index_python import get_package_share_directory as share\n"
            "share('cartographer_ros')",
            "package 'cartographer_ros' not found.*online_async_launch.py' maps",
        ),
        ("def generate_launch_description(:", "SyntaxError"),
        (
            "from launch import *\nfrom launch.actions import *\n"
            "def generate_launch_description():\n"
            "    return LaunchDescription([DeclareLaunchArgument('map')])",
            "Required launch argument 'map' was not provided|missing required argument 'map'",
        ),
        (
            "from launch import *\nfrom launch.substitutions import *\n"
            "from launch.actions import *\ndef generate_launch_description():\n"
            "    return LaunchDescription([LogInfo(msg=LaunchConfiguration('nope'))])",
            "launch configuration 'nope' does not exist",
        ),
    ],
)
def test_a_broken_file_is_named_with_its_remedy(
    text: str, problem: str, tmp_path: Path, started: Callable[..., Started]
) -> None:
    (tmp_path / "broken.launch.py").write_text(text)
    found = started(str(tmp_path / "broken.launch.py"))
    assert (found.code, found.lines) == (1, [])
    assert re.search(problem, found.said), found.said


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("<launch><nod pkg='a' exec='b'/></launch>", "<nod> is unknown; did you mean 'node'?"),
        ("<launch><node pkg='a'/></launch>", "<node> lacks 'exec', it has: pkg"),
        ("<launch><log message='$(vra x)'/></launch>", "did you mean 'var'?"),
        ("<launch><log message='$(var x'/></launch>", "lacks a ')'"),
        ("<robot/>", "is of <robot>; valid: <launch>"),
        ("<launch><include file='no.py'/></launch>", "launch file no.py does not exist"),
    ],
)
def test_a_broken_xml_file_is_named(
    text: str, problem: str, tmp_path: Path, started: Callable[..., Started]
) -> None:
    (tmp_path / "broken.launch.xml").write_text(text)
    found = started(str(tmp_path / "broken.launch.xml"))
    assert found.code == 1
    assert problem in found.said


def test_a_description_is_printed_and_started_below_a_prefix(
    started: Callable[..., Started],
) -> None:
    printed = started("display.launch.py", "--print")
    assert (printed.code, printed.lines) == (0, [])
    assert "\n    Node(...)\n" in printed.said
    options = ("--launch-prefix", "nice -n 5", "--launch-prefix-filter", "joint_.*")
    prefixed = [
        line.startswith("nice -n 5 ") for line in started("display.launch.py", *options).lines
    ]
    assert sorted(prefixed) == [False, False, True]


def test_arguments_are_listed(
    started: Callable[..., Started], capsys: pytest.CaptureFixture[str]
) -> None:
    assert verb.run(["-s", str(FILES / "display.launch.py")]) == 0
    printed = capsys.readouterr().out
    assert "    'model':\n        Path of the URDF\n" in printed
    assert "        one of: true, false\n        (default: 'true')\n" in printed
    assert " at 0x" not in printed


def test_a_node_that_is_not_to_start_by_itself_is_left_alone(
    started: Callable[..., Started],
) -> None:
    assert "ake transition" in started("lifecycle_slam.launch.py").said
    assert "ake transition" not in started("lifecycle_slam.launch.py", "autostart:=false").said
