"""Launch files of Nav2, slam_toolbox, Gazebo and the TurtleBot3, and what starts the same here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from arjuna_core.files.shipped import shipped_file
from bringup.stack import NAV2_PROGRAMS

_NAV2 = {"params_file": "--params", "namespace": "--namespace", "log_level": "--log-level"}
_MAP = {"map": "--map", **_NAV2}
_GRAPH = {"graph": "--param route_server:graph_filepath:={}"}
_MASKS = {
    f"{kind}_mask": f"--param {kind}_filter_mask_server:yaml_filename:={{}}"
    for kind in ("keepout", "speed")
}
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
        ("nav",), {**_MAP, **_GRAPH, **_MASKS}, instead=("slam", "use_localization")
    ),
    ("nav2_bringup", "localization_launch.py"): Launch(("nav", "--without-navigation"), _MAP),
    ("nav2_bringup", "navigation_launch.py"): Launch(
        ("nav", "--without-localization"), {**_NAV2, **_GRAPH}
    ),
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
    **{
        ("nav2_loopback_sim", file): Launch(
            ("sim", *_BURGER, "--param", "placed_by_estimate:=true"),
            {"map": "--world", "namespace": "--namespace"},
            (),
            ("params_file", "scan_frame_id"),
        )
        for file in ("loopback_simulation.launch.py", "loopback_sim_launch.py")
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
    ("turtlebot4_navigation", "localization.launch.py"): Launch(
        ("nav", "--without-navigation"), {**_MAP, "params": "--params"}
    ),
    ("turtlebot4_navigation", "nav2.launch.py"): Launch(("nav", "--without-localization"), _NAV2),
    ("turtlebot4_navigation", "slam.launch.py"): Launch(
        ("slam", "--param", "synchronous:=true"),
        {"params": "--params", "sync": "--param synchronous:={}", **_NAV2},
        ("autostart", "use_lifecycle_manager"),
    ),
    **{
        ("turtlebot4_viz", f"view_{what}.launch.py"): Launch(
            ("view",), {"namespace": "--namespace"}, (), ("description", "model")
        )
        for what in ("model", "navigation", "robot")
    },
    ("slam_toolbox", "online_async_launch.py"): _mapper(),
    ("slam_toolbox", "online_sync_launch.py"): _mapper("synchronous:=true"),
    ("slam_toolbox", "offline_launch.py"): _mapper("synchronous:=true"),
    ("slam_toolbox", "localization_launch.py"): _mapper("mode:=localization"),
    ("slam_toolbox", "lifelong_launch.py"): _mapper("mode:=lifelong"),
}


_WORLD_OF_TB3 = "turtlebot3_gazebo", "turtlebot3_world.launch.py"
_NAV2_AND_VIEW = {
    ("nav2_bringup", "bringup_launch.py"): "",
    ("nav2_bringup", "rviz_launch.py"): "use_rviz",
}
COMPOSED = {
    **{
        ("nav2_bringup", f"{robot}_simulation_launch.py"): {
            _WORLD_OF_TB3: "use_simulator",
            **_NAV2_AND_VIEW,
        }
        for robot in ("tb3", "tb4")
    },
    **{
        ("nav2_bringup", f"{robot}_loopback_simulation{ending}"): {
            ("nav2_loopback_sim", "loopback_simulation.launch.py"): "",
            **_NAV2_AND_VIEW,
        }
        for robot in ("tb3", "tb4")
        for ending in (".launch.py", "_launch.py")
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
    ("rosbridge_server", "rosbridge_websocket_launch.xml"): {},
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
    ("explore_lite", "explore.launch.py"): "explore",
    ("nav2_minimal_tb3_sim", "spawn_tb3.launch.py"): "tb3_spawn",
    ("nav2_minimal_tb4_sim", "spawn_tb4.launch.py"): "tb4_spawn",
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
    **{
        ("robot_localization", f"{name}.launch.py"): name
        for name in ("dual_ekf_navsat_example", "ekf", "navsat_transform", "ukf")
    },
    ("nav2_route", "route_tool.launch.py"): "route_tool",
    ("slam_toolbox", "merge_maps_kinematic_launch.py"): "merge_maps",
    **{
        (f"turtlebot4_{simulator}_bringup", f"turtlebot4_{file}.launch.py"): f"turtlebot4{part}"
        for simulator in ("gz", "ignition")
        for file, part in ((simulator, ""), ("spawn", "_spawn"))
    },
    ("twist_mux", "twist_mux_launch.py"): "twist_mux",
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
