"""Names of Nav2, slam_toolbox, AMCL and their company that have no effect here, with the reason.

Patterns of names by reason: `*` stands for a plug-in's name, `name=a|b` for these values of a
parameter that has an effect otherwise. A name that is in no table is unknown.
"""

from __future__ import annotations

from collections.abc import Mapping
from fnmatch import fnmatchcase
from functools import cache
from typing import Any

from bringup.parameters.remarks import Kind

Table = Mapping[str, Mapping[str, str]]

COSTMAPS = ("local_costmap/local_costmap", "global_costmap/global_costmap")
_NOT_NEEDED: Table = {
    "*": {
        "rclcpp's own, with no counterpart in a Python node": (
            "allow_parameter_qos_overrides autostart_node qos_overrides.* start_type*"
            " introspection_mode service_introspection_mode diagnostic_updater.*"
            " strict_param_loading use_realtime_priority"
        ),
        "processes are watched by their supervisor": "bond_heartbeat_period bond_timeout",
        "results are kept until they are fetched": "action_server_result_timeout",
        "what a costmap lacks it says, and goes on": "initial_transform_timeout",
        "the node handles no velocities": "enable_stamped_cmd_vel",
    },
    "amcl": {
        "the option --seed": "random_seed",
        "of AMCL before Nav2": "laser_max_beams",
    },
    "map_saver": {"the map's topic is asked until it answers": "save_map_timeout"},
    "slam_toolbox": {
        "state, which slam_toolbox publishes as parameters": (
            "interactive_mode paused_new_measurements paused_processing"
        ),
        "Ceres is not used: Gauss-Newton on a sparse Cholesky factor": (
            "solver_plugin ceres_* optimize_graph"
        ),
        "of other versions": (
            "first_map_only minimum_time_interval_lifelong tf_publish_rate scan_qos resolution_map"
            " use_lifecycle_manager localization_on_configure"
        ),
    },
    "planner_server": {
        "Nav2 only warns below it": "expected_planner_frequency",
        "how Nav2's search is made fast or cut short": (
            "*.max_on_approach_iterations *.terminal_checking_interval *.lookup_table_size"
            " *.cache_obstacle_heuristic *.downsample_obstacle_heuristic"
            " *.allow_primitive_interpolation *.analytic_expansion_max_cost_override"
        ),
        "of other versions": "service_qos partial_plan*",
    },
    "controller_server": {
        "of other versions": "search_window local_costmap.* path_handler_plugins *.class",
        "plans are pruned, and trajectories judged, whole": (
            "*.prune_plan *.shorten_transformed_plan *.short_circuit_trajectory_evaluation"
            " *.include_last_point *.default_critic_namespaces *.trajectory_generator_name"
        ),
        "the costmap's own counts": "*.transform_tolerance *.inflation_layer_name",
    },
    "behavior_server": {
        "of Nav2 before Humble": "costmap_topic footprint_topic",
        "no behavior of Nav2's reads it": "global_frame",
    },
    "bt_navigator": {
        "every tree node of Nav2 is built in": "plugin_lib_names",
        "of Nav2 before Humble": "default_bt_xml_filename",
        "names of Groot's monitor": "enable_groot_monitoring groot_* *.groot_* *.enable_groot_*",
        "the navigators are Nav2's two": (
            "navigators navigate_to_pose.plugin navigate_through_poses.plugin"
        ),
        "trees are read again when their file has changed": "always_reload_bt_xml",
        "the blackboard's names are Nav2's": "*_blackboard_id",
    },
    "ekf_filter_node": {
        "for debugging robot_localization": "print_diagnostics debug*",
    },
    "robot_state_publisher": {
        "stamps are the joint states' always": "ignore_timestamp",
    },
}
_OF_COSTMAPS = {
    "of Nav2 before Foxy": "robot_frame raytrace_range obstacle_range",
}
_NO_EFFECT: Table = {
    **dict.fromkeys(COSTMAPS, _OF_COSTMAPS),
    "slam_toolbox": {
        "slam_toolbox switches between mapping and localization": "map_and_localization*",
    },
    "planner_server": {
        "Nav2 ends a search after this time": "*.max_planning_time",
        "Nav2 smooths the path inside the planner": "*.smooth_path *.smoother.*",
        "Nav2 turns the last pose into the path's direction": "*.use_final_approach_orientation",
        "Nav2 searches on a coarser costmap": "*.downsampl* *.coarse_search_resolution",
        "Nav2 weighs costs by their square": "*.use_quadratic_cost_penalty",
        "Nav2 searches so": "*.goal_heading_mode",
        "Nav2 publishes the expansions": "*.debug_visualizations",
    },
    "controller_server": {
        "Nav2 takes odometry's mean over it": "odom_duration",
        "Nav2 drives paths in reverse": (
            "*.allow_reversing *.allow_backward *.split_path *.enforce_path_inversion *.inversion_*"
        ),
        "Nav2 slows down so where a goal is cancelled": "*cancel_deceleration",
        "Nav2 drives so": (
            "*.interpolate_curvature_after_goal *.use_approach_linear_velocity_scaling"
            " *.use_dynamic_window *.min_distance_to_obstacle *.goal_dist_tol *.use_interpolation"
            " *.max_linear_accel *.max_linear_decel *.max_cost_threshold *.initial_rotation*"
            " *.final_rotation *.rotation_scaling_factor *.in_place_collision_resolution"
            " *.motion_target_dist *.reset_period *.advanced.* *.TrajectoryValidator.*"
        ),
        "Nav2 publishes it": (
            "*.publish_* *.marker_lifetime *.visualize *.Visualization.* *.TrajectoryVisualizer.*"
            " *.debug_trajectory_details"
        ),
        "Nav2 drives sideways": (
            "*.min_vel_y *.max_vel_y *.acc_lim_y *.decel_lim_y min_y_velocity_threshold"
            " *.vy_samples *.vy_max *.vy_std *.ay_max *.ay_min *.motion_model=omni"
        ),
        "Nav2 keeps this turning radius": "*.AckermannConstraints.* *.motion_model=ackermann",
        "Nav2 samples so": (
            "*.discretize_by_time *.time_granularity *.limit_vel_cmd_in_traj *.min_speed_theta"
            " *.sim_period *.x_only_threshold"
        ),
    },
    "smoother_server": {
        "Nav2 takes costs and outline from these topics": "costmap_topic footprint_topic",
        "Nav2 looks up transforms so": "robot_base_frame transform_tolerance",
        "the constrained smoother": (
            "*.path_downsampling_factor *.path_upsampling_factor *.keep_* *.optimizer.* *.w_curve"
            " *.w_dist *.w_smooth_cusp *.w_cost* *.cusp_* *.cost_check_points *.reversing_enabled"
            " *.minimum_turning_radius"
        ),
        "Nav2 smooths parts driven in reverse apart": "*.enforce_path_inversion",
        "the filter has seven points of second order": "*.window_size *.poly_order",
    },
    "behavior_server": {
        "Nav2 takes costs and outlines from these topics": "*_costmap_topic *_footprint_topic",
        "Nav2 takes the speed from it": "odom_topic",
        "Nav2 ramps the speed so": "*.acceleration_limit *.deceleration_limit *.minimum_speed",
    },
    "bt_navigator": {
        "Nav2 waits so long for a server": "default_server_timeout default_cancel_timeout",
        "Nav2 shortens error codes so": "error_code_name_prefixes",
        "Nav2 smooths odometry so": "filter_duration odom_duration",
        "Nav2 looks for trees there": "bt_search_directories",
        "a navigator of one's own": "*.plugin",
    },
    "velocity_smoother": {
        "Nav2 takes odometry's mean over it": "odom_duration",
        "Nav2 stamps with the time of smoothing": "stamp_smoothed_velocity_with_smoothing_time",
    },
    "docking_server": {
        "Nav2 docks so": (
            "initial_rotation backward_blind rotation_angular_tolerance max_staging_time"
            " controller.simulation_step controller.transform_tolerance controller.rotate_to_*"
            " controller.deceleration_max controller.angular_disengage_threshold controller.type"
            " *.dock_direction *.rotate_to_dock *.detector_service_* *.subscribe_toggle"
        ),
        "Nav2 takes costs and outlines from these topics": (
            "controller.costmap_topic controller.footprint_topic"
        ),
        "Nav2 smooths odometry so": "odom_topic odom_duration",
    },
    "route_server": {
        "Nav2 scores and tracks routes so": (
            "costmap_topic max_iterations max_planning_time smooth_corners smoothing_radius"
            " edge_cost_functions operations graph_file_loader graph_file_saver global_frame"
            " aggregate_blocked_edges enable_nn_search max_nn_search_iterations num_nearest_nodes"
            " min_prune_distance_from_goal min_distance_from_start transform_tolerance *.plugin"
            " *Scorer.* *.speed_tag *.speed_limit_topic *.max_collision_dist *.*_topic"
            " *.service_name"
        ),
    },
    "ekf_filter_node": {
        "robot_localization fuses so": (
            "frequency two_d_mode map_frame odom_frame base_link_frame* world_frame odom[1-9]*"
            " imu[1-9]* pose[0-9]* twist[0-9]* *_config *_differential *_relative *_queue_size"
            " *_nodelay *_rejection_threshold *_remove_gravitational_acceleration"
            " *_pose_use_child_frame process_noise_covariance initial_estimate_covariance"
            " dynamic_process_noise_covariance use_control stamped_control control_* *_limits"
            " *_gains transform_time_offset transform_timeout publish_acceleration"
            " permit_corrected_publication reset_on_time_jump smooth_lagged_data history_length"
            " disabled_at_startup predict_to_current_time initial_state gravitational_acceleration"
        ),
    },
    "robot_state_publisher": {
        "the robot is its file's (--robot)": "robot_description frame_prefix",
    },
}
_SAFETY: Mapping[str, str] = {
    "controller_server": "*.AckermannConstraints.* *.motion_model",
}
"""Names that keep a robot from harm where they have an effect."""
_NODES: Mapping[Kind, Mapping[str, str]] = {
    Kind.NOT_NEEDED: {
        "a part of Nav2's nodes before Humble": (
            "*_rclcpp_node *_client amcl_* planner_server_* controller_server_* bt_navigator_*"
        ),
        "'nav' and 'slam' bring their own": "lifecycle_manager* *lifecycle_manager",
        "the simulator speaks ROS": "ros_gz_bridge gz_* gazebo* loopback_simulator",
    },
    Kind.NO_EFFECT: {
        "objects are not followed": "following_server",
        "robot_localization's second filter": "ekf_* ukf_*",
        "GPS is fused by the waypoint follower alone": "navsat_transform*",
        "no such node": (
            "base_footprint_publisher joint_state_publisher* controller_manager"
            " diff_drive_controller twist_mux teleop_* rviz* map_merging turtlebot3_* turtlebot4_*"
            " create3_* joy_node camera* *_driver* *lidar*"
        ),
    },
}
_SAFE_NODES = ("twist_mux",)


@cache
def _entries(node: str) -> tuple[tuple[str, Kind, str], ...]:
    """Return pattern, kind and reason of each name of a node, its own before everybody's."""
    tables = ((Kind.NOT_NEEDED, _NOT_NEEDED), (Kind.NO_EFFECT, _NO_EFFECT))
    return tuple(
        (pattern, kind, reason)
        for name in (node, "*")
        for kind, table in tables
        for reason, patterns in table.get(name, {}).items()
        for pattern in patterns.split()
    )


def of_key(node: str, key: str) -> tuple[Kind, str] | None:
    """Return why a name of a node has no effect; None where nobody is known to use it."""
    for pattern, kind, reason in _entries(node):
        if "=" not in pattern and fnmatchcase(key, pattern):
            return kind, reason
    return None


def of_value(node: str, key: str, value: Any) -> tuple[Kind, str] | None:
    """Return why a value has no effect where other values of its parameter have one."""
    text = str(value).lower()
    for pattern, kind, reason in _entries(node):
        name, equals, values = pattern.partition("=")
        if equals and fnmatchcase(key, name) and text in values.split("|"):
            return kind, reason
    return None


def of_node(name: str) -> tuple[Kind, str, bool] | None:
    """Return why a node has no counterpart, and whether it keeps robots from harm."""
    last = name.rsplit("/", 1)[-1]
    for kind, reasons in _NODES.items():
        for reason, patterns in reasons.items():
            if any(fnmatchcase(last, pattern) for pattern in patterns.split()):
                return kind, reason, any(fnmatchcase(last, one) for one in _SAFE_NODES)
    return None


def is_safety(node: str, key: str) -> bool:
    """Return whether a name keeps a robot from harm where it has an effect."""
    return any(fnmatchcase(key, pattern) for pattern in _SAFETY.get(node, "").split())
