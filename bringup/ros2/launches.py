"""Launch files of Nav2, slam_toolbox, Gazebo and the TurtleBot3, and what starts the same here."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from arjuna_core.errors import nearest
from arjuna_core.files.shipped import shipped_file
from bringup.parameters.files import load_parameters
from bringup.stack import NAV2_PROGRAMS

_STARTS = "nodes start at once"
_IDLE = {
    "autostart": ("true", _STARTS),
    "use_lifecycle_manager": ("", _STARTS),
    "use_composition": ("", "each group of nodes is one process"),
    "container_name": ("", "there are no containers"),
    "use_respawn": ("true", "what dies is started again"),
    "log_settings": ("", "log_level:=LEVEL counts"),
    "gui": ("false", "the simulator has no window; 'arjuna view' shows it"),
    "pause": ("false", "'arjuna world pause' pauses it"),
}
"""Arguments without an effect: the value that says what happens anyhow (none: no matter), why."""
_NAV2 = {"params_file": "--params", "namespace": "--namespace", "log_level": "--log-level"}
_MAP = {"map": "--map", **_NAV2}
_SLAM = {"slam_params_file": "--params", **_NAV2}
_BURGER = ("--robot", str(shipped_file("urdf/burger.urdf")))
_AT = {"x_pose": "", "y_pose": "", "namespace": "--namespace"}
_WORLD = {"world": ""}
_GZ_ARGS = {"gz_args": "", "ign_args": "", "world_sdf_file": ""}
_SPAWN = {
    "file": "-file",
    "string": "-string",
    "model_string": "-string",
    "topic": "-topic",
    "entity_name": "-name",
    **{name: f"-{name}" for name in ("x", "y", "z", "R", "P", "Y")},
}
_BRIDGE = {"config_file": "--ros-args -p config_file:={}", "namespace": "-r __ns:=/{}"}
_CONTAINED = ("bridge_name", "bridge_params", "container_name", "create_own_container")
_GZ = ("gui", "pause"), ("debug", "gz_version", "on_exit_shutdown", "server", "verbose")
_NAV2_ONLY = ("autostart", "use_composition", "container_name", "use_respawn")


@dataclass(frozen=True)
class Launch:
    """The command of ours that starts the same as a launch file.

    Attributes:
        words: The command, or `ros2 run PACKAGE EXECUTABLE` as `run` and those.
        options: The command's option for an argument of the file; "" for a word of it.
        idle: Its arguments that have no effect here.
        instead: Its arguments that say what locates the robot in place of a map.
    """

    words: tuple[str, ...]
    options: Mapping[str, str]
    idle: tuple[str, ...] = _NAV2_ONLY
    instead: tuple[str, ...] = ()


def _mapper(*parameters: str) -> Launch:
    words = (word for parameter in parameters for word in ("--param", parameter))
    return Launch(("slam", *words), _SLAM, ("autostart", "use_lifecycle_manager"))


LAUNCHES: dict[tuple[str, str], Launch] = {
    ("nav2_bringup", "bringup_launch.py"): Launch(
        ("nav",), _MAP, instead=("slam", "use_localization")
    ),
    ("nav2_bringup", "localization_launch.py"): Launch(("nav", "--without-navigation"), _MAP),
    ("nav2_bringup", "navigation_launch.py"): Launch(("nav", "--without-localization"), _NAV2),
    ("nav2_bringup", "rviz_launch.py"): Launch(
        ("view",), {"namespace": "--namespace", "rviz_config": "--config"}, ()
    ),
    ("nav2_bringup", "slam_launch.py"): Launch(
        ("slam", "--param", "synchronous:=true"), _NAV2, _NAV2_ONLY
    ),
    **{
        ("nav2_collision_monitor", f"{name}_node.launch.py"): Launch(
            ("run", "nav2_collision_monitor", name, "--ros-args"),
            {"params_file": "--params-file"},
        )
        for name in ("collision_monitor", "collision_detector")
    },
    **{
        (package, file): Launch(("run", package, "gzserver"), options, *_GZ)
        for package, file, options in (
            ("gazebo_ros", "gazebo.launch.py", _WORLD),
            ("gazebo_ros", "gzserver.launch.py", _WORLD),
            ("ros_gz_sim", "gz_sim.launch.py", _GZ_ARGS),
            ("ros_gz_sim", "gz_server.launch.py", _GZ_ARGS),
            ("ros_ign_gazebo", "ign_gazebo.launch.py", _GZ_ARGS),
        )
    },
    ("ros_gz_sim", "gz_spawn_model.launch.py"): Launch(
        ("run", "ros_gz_sim", "create"), _SPAWN, (), ("allow_renaming", "world")
    ),
    ("ros_gz_bridge", "ros_gz_bridge.launch.py"): Launch(
        ("run", "ros_gz_bridge", "parameter_bridge"),
        _BRIDGE,
        (),
        (*_CONTAINED, "use_composition", "use_respawn", "log_level"),
    ),
    ("gazebo_ros", "gzclient.launch.py"): Launch(("run", "gazebo_ros", "gzclient"), {}, *_GZ),
    **{
        ("turtlebot3_gazebo", f"{file}.launch.py"): Launch(
            ("sim", *_BURGER, "--world", str(shipped_file(f"worlds/{world}.world")), "--at", *at),
            *(_AT, *_GZ),
        )
        for file, world, at in (
            ("empty_world", "empty", ("0", "0")),
            ("turtlebot3_world", "pillar_arena", ("-2", "-0.5")),
            ("turtlebot3_house", "office", ("0", "0")),
        )
    },
    ("turtlebot3_bringup", "rviz2.launch.py"): Launch(("view",), {}, ()),
    ("turtlebot3_cartographer", "cartographer.launch.py"): Launch(("slam",), {}, ()),
    ("turtlebot3_navigation2", "navigation2.launch.py"): Launch(("nav",), _MAP),
    ("slam_toolbox", "online_async_launch.py"): _mapper(),
    ("slam_toolbox", "online_sync_launch.py"): _mapper("synchronous:=true"),
    ("slam_toolbox", "offline_launch.py"): _mapper("synchronous:=true"),
    ("slam_toolbox", "localization_launch.py"): _mapper("mode:=localization"),
    ("slam_toolbox", "lifelong_launch.py"): _mapper("mode:=lifelong"),
}


_WORLD_OF_TB3 = "turtlebot3_gazebo", "turtlebot3_world.launch.py"
COMPOSED = {
    **{
        ("nav2_bringup", f"{name}_launch.py"): {
            _WORLD_OF_TB3: "use_simulator",
            ("nav2_bringup", "bringup_launch.py"): "",
            ("nav2_bringup", "rviz_launch.py"): "use_rviz",
        }
        for name in (
            *("tb3_simulation", "tb3_loopback_simulation"),
            *("tb4_simulation", "tb4_loopback_simulation"),
        )
    },
    ("ros_gz_sim", "ros_gz_sim.launch.py"): {
        ("ros_gz_sim", "gz_server.launch.py"): "",
        ("ros_gz_bridge", "ros_gz_bridge.launch.py"): "",
    },
    ("ros_gz_sim", "ros_gz_spawn_model.launch.py"): {
        ("ros_gz_bridge", "ros_gz_bridge.launch.py"): "",
        ("ros_gz_sim", "gz_spawn_model.launch.py"): "",
    },
    ("foxglove_bridge", "foxglove_bridge_launch.xml"): {},
}
"""Launch files that include those of `LAUNCHES`: each one's argument that leaves it out."""


DESCRIBED = {
    **dict.fromkeys(
        (
            ("turtlebot3_bringup", "turtlebot3_state_publisher.launch.py"),
            ("turtlebot3_gazebo", "robot_state_publisher.launch.py"),
        ),
        "turtlebot3_description",
    ),
    ("turtlebot3_gazebo", "spawn_turtlebot3.launch.py"): "turtlebot3_spawn",
    ("teleop_twist_joy", "teleop-launch.py"): "teleop",
    ("nav2_bringup", "cloned_multi_tb3_simulation_launch.py"): "cloned_robots",
    **dict.fromkeys(
        (
            ("nav2_bringup", "unique_multi_tb3_simulation_launch.py"),
            ("nav2_bringup", "multi_tb3_simulation_launch.py"),
        ),
        "unique_robots",
    ),
    ("urdf_launch", "description.launch.py"): "robot",
    ("urdf_launch", "display.launch.py"): "display",
}
"""Launch files of nodes that are here, and the functions of `described` that describe them."""


PLUGINS = {
    **{
        f"{package}::{''.join(word.capitalize() for word in name.split('_'))}": (package, name)
        for package, name in NAV2_PROGRAMS
    },
    "behavior_server::BehaviorServer": ("nav2_behaviors", "behavior_server"),
    "demo_nodes_cpp::Listener": ("demo_nodes_cpp", "listener"),
    "demo_nodes_cpp::Talker": ("demo_nodes_cpp", "talker"),
    "nav2_amcl::AmclNode": ("nav2_amcl", "amcl"),
    "opennav_docking::DockingServer": ("opennav_docking", "opennav_docking"),
    "slam_toolbox::AsynchronousSlamToolbox": ("slam_toolbox", "async_slam_toolbox_node"),
    "slam_toolbox::SynchronousSlamToolbox": ("slam_toolbox", "sync_slam_toolbox_node"),
    "depthimage_to_laserscan::DepthImageToLaserScanROS": (
        "depthimage_to_laserscan",
        "depthimage_to_laserscan_node",
    ),
    "pointcloud_to_laserscan::PointCloudToLaserScanNode": (
        "pointcloud_to_laserscan",
        "pointcloud_to_laserscan_node",
    ),
}
"""Package and executable of nodes that containers load, by their plug-ins."""


@dataclass
class Translation:
    """A launch file with arguments, as a command of ours, and remarks on those without effect."""

    command: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def arguments_of(launch: Launch) -> str:
    """Return the arguments of a launch file, those without an effect apart."""
    known = sorted(known_arguments(launch) - set(launch.idle))
    lines = [f"Arguments (NAME:=VALUE): {', '.join(known)}"]
    return "\n".join([*lines, f"Without an effect here: {', '.join(sorted(launch.idle))}"])


def translated(launch: Launch, words: list[str]) -> Translation:
    """Return our command for a launch file with arguments, and what of them has no effect."""
    found = Translation()
    known = known_arguments(launch)
    given: dict[str, str] = {}
    for word in words:
        name, sign, value = word.partition(":=")
        if sign and name in known:
            given[name] = value
        else:
            what = "argument" if sign else "option"
            found.remarks.append(f"no effect: {word} (unknown {what}; {nearest(name, known)})")
    found.remarks += _idle(launch, given)
    if given.get("use_namespace", "true").lower() == "false" and given.pop("namespace", ""):
        found.remarks.append("no effect: namespace (use_namespace is false)")
    if "x_pose" in launch.options and {"x_pose", "y_pose"} & given.keys():
        at = [given.pop(name, "0") for name in ("x_pose", "y_pose")]
        given["at"] = " ".join(at)
    found.command = _command(launch, given)
    return found


def known_arguments(launch: Launch) -> set[str]:
    """Return the arguments that a launch file has."""
    return {*launch.options, *launch.idle, *launch.instead, "use_namespace", "use_sim_time"}


def _idle(launch: Launch, given: Mapping[str, str]) -> list[str]:
    lines = []
    for name in (name for name in launch.idle if name in given):
        anyhow, reason = _IDLE[name]
        if given[name].lower() != anyhow:
            lines.append(f"no effect: {name}:={given[name]} ({reason})")
    return lines


def _command(launch: Launch, given: dict[str, str]) -> list[str]:
    first, *rest = launch.words
    if given.get("use_sim_time", "true").lower() == "false":
        if first == "slam":
            rest += ["--use-sim-time", "false"]
        first = "robot" if first == "nav" else first
    if "map" in launch.options:
        rest += _located(given)
    if "at" in given:
        rest[-3:] = ["--at", *shlex.split(given["at"])]
    for name, option in launch.options.items():
        if value := given.get(name, ""):
            words = option.replace("/{}", f"/{value.lstrip('/')}").split()
            inside = [word.replace("{}", value) for word in words]
            rest += inside if "{}" in option else [option, value] if option else shlex.split(value)
    return [first, *rest]


def _located(given: dict[str, str]) -> list[str]:
    if given.get("slam", "false").lower() == "true":
        given.pop("map", None)
        return ["--slam"]
    if given.get("use_localization", "true").lower() == "false":
        given.pop("map", None)
        return ["--without-localization"]
    if not given.get("map") and given.get("params_file"):
        nodes = load_parameters([Path(given["params_file"])])
        named = (values.get("yaml_filename") for values in nodes.values())
        given["map"] = next((name for name in named if isinstance(name, str) and name), "")
    return []
