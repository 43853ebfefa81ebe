"""Launch files of other packages whose nodes are here: what a launch file of one's own includes."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import yaml
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, LogInfo, OpaqueFunction
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import Command, LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from arjuna_core.errors import ConfigError
from arjuna_core.files.input_file import read_text
from arjuna_core.files.shipped import shipped_file
from arjuna_core.files.yaml_file import plain
from bringup.ros2.verbs.forward import module_of
from bringup.ros2.worlds import world_of

_MODEL = "TURTLEBOT3_MODEL"
_CLONED = "robot1={x: 0.5, y: 0.5}; robot2={x: -0.5, y: -0.5, yaw: 1.5707}"
_UNIQUE = "robot1={x: 0.0, y: 0.5}; robot2={x: 0.0, y: -0.5}"


def launch_file(usual: Mapping[str, Any], *actions: Any) -> LaunchDescription:
    """Return what a launch file describes whose arguments have usual values, None for none."""
    declared = (DeclareLaunchArgument(name, default_value=value) for name, value in usual.items())
    return LaunchDescription([*declared, *actions])


def _node(package: str, executable: str = "", **more: Any) -> Node:
    return Node(package=package, executable=executable or package, output="screen", **more)


def _in_share(package: Any, *parts: Any) -> PathJoinSubstitution:
    return PathJoinSubstitution([FindPackageShare(package), *parts])


def _spawner(*words: Any, **more: Any) -> Node:
    return _node("ros_gz_sim", "create", arguments=list(words), **more)


def robot() -> LaunchDescription:
    """Publish a robot's description and its frames: `urdf_package`, `urdf_package_path`."""
    names = ("urdf_package", "urdf_package_path")
    command = Command(["xacro ", _in_share(*map(LaunchConfiguration, names))])
    text = {"robot_description": ParameterValue(command, value_type=str)}
    return launch_file(dict.fromkeys(names), _node("robot_state_publisher", parameters=[text]))


def display() -> LaunchDescription:
    """Show a robot, whose joints stand still: `jsp_gui` and `rviz_config` too."""
    usual = {"jsp_gui": "true", "rviz_config": _in_share("urdf_launch", "config", "urdf.rviz")}
    gui, joints = LaunchConfiguration("jsp_gui"), "joint_state_publisher"
    return launch_file(
        usual,
        *robot().entities,
        _node(joints, condition=UnlessCondition(gui)),
        _node(f"{joints}_gui", condition=IfCondition(gui)),
        _node("rviz2", arguments=["-d", LaunchConfiguration("rviz_config")]),
    )


def turtlebot3_description() -> LaunchDescription:
    """Publish the Burger's description and its frames: `use_sim_time`, `frame_prefix`."""
    parameters = {
        "use_sim_time": LaunchConfiguration("use_sim_time"),
        "robot_description": read_text(shipped_file("urdf/burger.urdf")),
        "frame_prefix": ParameterValue(
            LaunchConfiguration("frame_prefix", default=""), value_type=str
        ),
    }
    name = "robot_state_publisher"
    return launch_file({"use_sim_time": "false"}, _node(name, name=name, parameters=[parameters]))


def turtlebot3_spawn() -> LaunchDescription:
    """Put the Burger into the world: `x_pose`, `y_pose`."""
    x, y = (LaunchConfiguration(f"{axis}_pose", default="0.0") for axis in "xy")
    file = str(shipped_file("urdf/burger.urdf"))
    model = os.environ.get(_MODEL, "burger")
    remark = LogInfo(msg=f"the Burger stands for {_MODEL}={model}")
    spawner = _spawner("-name", "burger", "-file", file, "-x", x, "-y", y, "-z", "0.01")
    return launch_file({}, *([remark] if model != "burger" else []), spawner)


def _spawned(name: str, x: str, y: str) -> LaunchDescription:
    """Put a robot into a world: `robot_sdf`, `robot_name`, `namespace`, `x_pose`, `yaw` and so on.

    Source: nav2_minimal_tb3_sim, spawn_tb3.launch.py; nav2_minimal_tb4_sim, spawn_tb4.launch.py.
    """
    usual = {"namespace": "", "use_simulator": "True", "robot_name": name}
    usual["robot_sdf"] = str(shipped_file("urdf/burger.urdf"))
    given = {one: LaunchConfiguration(one) for one in usual}
    words: list[Any] = ["-name", given["robot_name"], "-file", given["robot_sdf"]]
    words += ["-robot_namespace", given["namespace"]]
    for option, axis, value in (("-x", "x_pose", x), ("-y", "y_pose", y), ("-Y", "yaw", "0.0")):
        words += [option, LaunchConfiguration(axis, default=value)]
    return launch_file(usual, _spawner(*words, condition=IfCondition(given["use_simulator"])))


tb3_spawn = partial(_spawned, "turtlebot3_waffle", "-2.0", "-0.5")
tb4_spawn = partial(_spawned, "turtlebot4", "-8.0", "-0.5")


def turtlebot4() -> LaunchDescription:
    """Start a Burger that stands on its dock in the warehouse, with a Create 3's motions.

    `nav2`, `localization`, `slam` and `rviz` start those beside it, as the original does.

    Source: turtlebot4_gz_bringup, turtlebot4_gz.launch.py.
    """

    def started(context: Any) -> list[Any]:
        given = context.launch_configurations
        words = ["sim", "--robot", str(shipped_file("urdf/burger.urdf")), "--world"]
        words += [str(world_of(given["world"]))]
        words += ["--at", given["x"], given["y"], "--heading", given["yaw"]]
        beside = {
            "rviz": ["view"],
            "slam": ["slam", "--param", "synchronous:=true"],
            "localization": ["nav", "--without-navigation", "--map", given["map"]],
            "nav2": ["nav", "--without-localization"],
        }
        wanted = [command for name, command in beside.items() if given[name].lower() == "true"]
        namespace = ["--namespace", given["namespace"]] if given["namespace"] else []
        motions = _create3(given["namespace"])
        return [*(process([*each, *namespace]) for each in (words, *wanted)), motions]

    known = {"world": "warehouse", "x": "0.0", "y": "0.0", "yaw": "0.0", "namespace": ""}
    known |= dict.fromkeys(("rviz", "slam", "localization", "nav2"), "false")
    known["map"] = str(shipped_file("maps/warehouse.yaml"))
    return launch_file(known, OpaqueFunction(function=started))


def turtlebot4_spawn() -> LaunchDescription:
    """Put a Burger with a Create 3's motions into a world that waits for its robot.

    Source: turtlebot4_gz_bringup, turtlebot4_spawn.launch.py.
    """
    known = {"namespace": "", "rviz": "false", "x": "0.0", "y": "0.0", "yaw": "0.0"}
    given = {name: LaunchConfiguration(name) for name in known}
    words: list[Any] = ["-name", "turtlebot4", "-file", str(shipped_file("urdf/burger.urdf"))]
    options = {"-robot_namespace": "namespace", "-x": "x", "-y": "y", "-Y": "yaw"}
    words += [word for option, name in options.items() for word in (option, given[name])]
    viewer = _node("rviz2", condition=IfCondition(given["rviz"]))
    return launch_file(known, _spawner(*words), viewer, _create3(given["namespace"]))


def _create3(namespace: Any) -> Node:
    sim_time = {"use_sim_time": True}
    package = "irobot_create_nodes"
    return _node(package, "motion_control", namespace=namespace, parameters=[sim_time])


def cloned_robots() -> LaunchDescription:
    """Drive the robots of `robots` in one world, each by `params_file` (all of one)."""
    return _several(_CLONED, lambda name, given: given["params_file"])


def unique_robots() -> LaunchDescription:
    """Drive two robots in one world, each by `NAME_params_file`."""
    return _several(_UNIQUE, lambda name, given: given.get(f"{name}_params_file", ""))


def _several(usual: str, params_of: Callable[[str, Any], str]) -> LaunchDescription:
    """Return a world of several Burgers, with navigation and a view for each in its namespace.

    Source: nav2_bringup, cloned_multi_tb3_simulation_launch.py, unique_multi_....
    """

    def started(context: Any) -> list[Any]:
        given = context.launch_configurations
        words = ["--robot", str(shipped_file("urdf/burger.urdf"))]
        words += ["--world", given["world"] or str(shipped_file("worlds/pillar_arena.world"))]
        stacks: list[list[str]] = []
        for name, pose in _poses(given["robots"]).items():
            x, y, yaw = (str(float(pose.get(key, 0.0))) for key in ("x", "y", "yaw"))
            words += ["--namespace", name, "--at", x, y, "--heading", yaw]
            params = params_of(name, given)
            chosen = ["--params", params] if params else []
            stacks.append(["nav", "--map", given["map"], "--namespace", name, *chosen])
            if given["use_rviz"].lower() == "true":
                stacks.append(["view", "--namespace", name])
        return [process(["sim", *words]), *map(process, stacks)]

    known = {"robots": usual, "world": "", "params_file": "", "use_rviz": "true"}
    known["map"] = str(shipped_file("maps/pillar_arena.yaml"))
    return launch_file(known, OpaqueFunction(function=started))


def _poses(text: str) -> dict[str, Mapping[str, Any]]:
    """Return poses by robots' names: `NAME={x: ...}; ...`, or `{name: NAME, pose: {x: ...}}; ...`.

    Raises:
        ConfigError: It is neither.
    """
    found: dict[str, Mapping[str, Any]] = {}
    for part in filter(None, map(str.strip, text.split(";"))):
        name, equals, pose = part.partition("=")
        try:
            one = plain(pose if equals else part)
            found[name.strip() if equals else one["name"]] = one if equals else one["pose"]
        except (yaml.YAMLError, KeyError, TypeError) as error:
            valid = "NAME={x: 1.0, y: 0.5, yaw: 0.0}; ..."
            raise ConfigError(f"robots: '{part}' is no robot; valid: {valid}") from error
    return found


def _fusing(file: str, program: str, name: str, *remappings: tuple[str, str]) -> Node:
    package = "robot_localization"
    path = _in_share(package, "params", f"{file}.yaml")
    return _node(package, f"{program}_node", name=name, parameters=[path], remappings=remappings)


def _fused(program: str, name: str) -> LaunchDescription:
    """Run a node of robot_localization as the package's file of its program's name says."""
    return launch_file({}, _fusing(program, program, name))


ekf = partial(_fused, "ekf", "ekf_filter_node")
ukf = partial(_fused, "ukf", "ukf_filter_node")
navsat_transform = partial(_fused, "navsat_transform", "navsat_transform_node")


def dual_ekf_navsat_example() -> LaunchDescription:
    """Fuse wheels and IMU in odom, with GPS in map."""
    file, filtered = "dual_ekf_navsat_example", "odometry/filtered"
    return launch_file(
        {},
        _fusing(file, "ekf", "ekf_filter_node_odom", (filtered, "odometry/local")),
        _fusing(file, "ekf", "ekf_filter_node_map", (filtered, "odometry/global")),
        _fusing(file, "navsat_transform", "navsat_transform", (filtered, "odometry/global")),
    )


def route_tool() -> LaunchDescription:
    """Show the map of `yaml_filename`, to draw a graph of routes on."""
    view = _in_share("nav2_route", "rviz", "route_tool.rviz")
    map_file = {"yaml_filename": LaunchConfiguration("yaml_filename")}
    server = _node("nav2_map_server", "map_server", parameters=[map_file])
    return launch_file({"yaml_filename": ""}, _node("rviz2", arguments=["-d", view]), server)


def merge_maps() -> LaunchDescription:
    """Put saved graphs together into one map."""
    return launch_file({}, _node("slam_toolbox", "merge_maps_kinematic"))


def explore() -> LaunchDescription:
    """Explore with m-explore's node: `use_sim_time`, `namespace`.

    Source: explore_lite, explore.launch.py.
    """
    file = _in_share("explore_lite", "config", "params.yaml")
    sim_time = {"use_sim_time": LaunchConfiguration("use_sim_time")}
    node = _node(
        "explore_lite",
        "explore",
        name="explore_node",
        namespace=LaunchConfiguration("namespace"),
        parameters=[file, sim_time],
        remappings=[("/tf", "tf"), ("/tf_static", "tf_static")],
    )
    return launch_file({"use_sim_time": "true", "namespace": ""}, node)


def twist_mux() -> LaunchDescription:
    """Pass on the commands of who comes first: `config_topics`, `config_locks`, `cmd_vel_out`."""
    usual: dict[str, Any] = {
        f"config_{kind}": _in_share("twist_mux", "config", f"twist_mux_{kind}.yaml")
        for kind in ("locks", "topics")
    }
    files = [LaunchConfiguration(name) for name in usual]
    usual |= {"cmd_vel_out": "twist_mux/cmd_vel", "use_sim_time": "False"}
    sim_time = {"use_sim_time": LaunchConfiguration("use_sim_time")}
    out = [("/cmd_vel_out", LaunchConfiguration("cmd_vel_out"))]
    return launch_file(usual, _node("twist_mux", parameters=[sim_time, *files], remappings=out))


def teleop() -> LaunchDescription:
    """Drive by a joystick: `config_filepath`, `joy_dev`, `joy_vel`, `publish_stamped_twist`."""
    usual = {"joy_config": "ps3", "joy_dev": "0", "joy_vel": "cmd_vel", "config_filepath": ""}
    usual["publish_stamped_twist"] = "false"
    return launch_file(usual, OpaqueFunction(function=_joystick))


def _joystick(context: Any) -> list[Node]:
    given = context.launch_configurations
    number = given["joy_dev"].removeprefix("/dev/input/js")
    device = {"device_id": int(number)} if number.isdigit() else {}
    file = given["config_filepath"]
    stamped = {"publish_stamped_twist": LaunchConfiguration("publish_stamped_twist")}
    joy = {**device, "deadzone": 0.3, "autorepeat_rate": 20.0}  # as that launch file sets them
    return [
        _node("joy", "joy_node", name="joy_node", parameters=[joy]),
        _node(
            "teleop_twist_joy",
            "teleop_node",
            name="teleop_twist_joy_node",
            parameters=[*([file] if file else []), stamped],
            remappings=[("/cmd_vel", given["joy_vel"])],
        ),
    ]


def process(command: list[str]) -> ExecuteProcess:
    """Return the action of a command of ours."""
    words = [sys.executable, "-m", module_of(command[0]), *command]
    name = command[2] if command[0] == "run" else command[0]
    return ExecuteProcess(cmd=words, name=name, output="screen")
