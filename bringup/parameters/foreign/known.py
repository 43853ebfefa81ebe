"""Names that Nav2, slam_toolbox and AMCL give parameters and nodes which we do without.

`*` stands for a plug-in's name. `name=a|b` is about those values of a parameter that we do have.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import Any

_ANYWHERE = """
    action_server_result_timeout allow_parameter_qos_overrides autostart_node bond_heartbeat_period
    diagnostic_updater.* introspection_mode qos_overrides.* service_introspection_mode start_type*
    strict_param_loading use_realtime_priority use_sim_time enable_stamped_cmd_vel
"""
_COSTMAP = """
    combination_method filters footprint_clearing_enabled
    initial_transform_timeout map_vis_z max_obstacle_height min_obstacle_height observation_sources
    raytrace_range obstacle_range robot_frame subscribe_to_updates unknown_cost_value use_maximum
    unknown_threshold mark_threshold origin_z z_resolution z_voxels publish_voxel_map
    *.combination_method *.inflate_around_unknown *.map_vis_z *.max_obstacle_height
    *.min_obstacle_height *.subscribe_to_updates *.transform_tolerance *.unknown_threshold
    *.mark_threshold *.origin_z *.z_resolution *.z_voxels *.publish_voxel_map
    *.footprint_clearing_enabled *.sensor_frame *.observation_persistence *.obstacle_range
    *.raytrace_range *.trinary_costmap *.use_maximum *.track_unknown_space *.lethal_cost_threshold
    *.topic *.data_type *.marking *.clearing *.expected_update_rate *.inf_is_valid
    *.obstacle_max_range *.obstacle_min_range *.raytrace_max_range *.raytrace_min_range
    *.observation_sources voxel_layer.* *_filter.*
"""
_SMAC = """
    *.allow_primitive_interpolation *.allow_reverse_expansion *.allow_unknown
    *.analytic_expansion_* *.angle_quantization_bins *.cache_obstacle_heuristic *.change_penalty
    *.cost_penalty *.cost_travel_multiplier *.debug_visualizations *.downsample_costmap
    *.downsample_obstacle_heuristic *.downsampling_factor *.lattice_filepath *.lookup_table_size
    *.max_iterations *.max_on_approach_iterations *.max_planning_time *.minimum_turning_radius
    *.motion_model_for_search *.non_straight_penalty *.retrospective_penalty *.reverse_penalty
    *.rotation_penalty *.smooth_path *.smoother.* *.terminal_checking_interval *.tolerance
    *.use_quadratic_cost_penalty *.coarse_search_resolution *.goal_heading_mode *.use_astar
    *.how_many_corners *.w_euc_cost *.w_traversal_cost *.w_heuristic_cost
    *.use_final_approach_orientation
"""
_CONTROLLERS = """
    *.allow_reversing *.cancel_deceleration *.curvature_lookahead_dist *.goal_dist_tol
    *.interpolate_curvature_after_goal *.max_linear_accel *.max_linear_decel *.stateful
    *.transform_tolerance *.use_approach_linear_velocity_scaling *.use_cancel_deceleration
    *.use_fixed_curvature_lookahead *.use_interpolation *.use_path_orientations
    *.min_distance_to_obstacle *.use_dynamic_window *.allow_backward *.rotation_scaling_factor
    *.in_place_collision_resolution *.initial_rotation_threshold *.closed_loop
    *.initial_rotation_min_angle *.final_rotation *.motion_target_dist *.max_cost_threshold
    *.debug_trajectory_details *.publish_* *.marker_lifetime *.default_critic_namespaces
    *.trajectory_generator_name *.prune_plan *.short_circuit_trajectory_evaluation *.class
    *.min_vel_y *.max_vel_y *.acc_lim_y *.decel_lim_y *.min_y_velocity_threshold *.vy_samples
    *.discretize_by_time *.time_granularity *.include_last_point *.limit_vel_cmd_in_traj
    *.min_speed_theta *.split_path *.sim_period *.x_only_threshold *.shorten_transformed_plan
    *.visualize *.Visualization.* *.TrajectoryVisualizer.* *.vy_max *.vy_std *.ay_max *.ay_min
    *.AckermannConstraints.* *.inflation_layer_name *.motion_model=ackermann|omni
    *.advanced.* *.TrajectoryValidator.* *.reset_period *.open_loop
"""
_KNOWN = {
    "amcl": "random_seed laser_max_beams plugin",
    "map_server": "map_topic yaml_topic",
    "map_saver": "save_map_timeout",
    "slam_toolbox": """
        interactive_mode localization_on_configure paused_new_measurements paused_processing
        map_and_localization* first_map_only use_lifecycle_manager optimize_graph
        minimum_time_interval_lifelong tf_publish_rate scan_qos resolution_map
    """,
    "planner_server": f"expected_planner_frequency service_qos partial_plan* {_SMAC}",
    "controller_server": f"""
        min_x_velocity_threshold min_y_velocity_threshold min_theta_velocity_threshold
        publish_zero_velocity odom_duration search_window local_costmap.* path_handler_plugins
        {_CONTROLLERS}
    """,
    "smoother_server": """
        costmap_topic footprint_topic robot_base_frame transform_tolerance
        *.path_downsampling_factor *.path_upsampling_factor *.keep_* *.optimizer.* *.w_curve
        *.w_dist *.w_smooth_cusp *.w_cost* *.cusp_* *.cost_check_points *.reversing_enabled
        *.minimum_turning_radius *.enforce_path_inversion *.window_size *.poly_order
    """,
    "behavior_server": """
        local_costmap_topic global_costmap_topic local_footprint_topic global_footprint_topic
        costmap_topic footprint_topic local_frame global_frame robot_base_frame transform_tolerance
        cmd_vel_teleop odom_topic *.acceleration_limit *.deceleration_limit *.minimum_speed
    """,
    "bt_navigator": """
        plugin_lib_names default_bt_xml_filename default_server_timeout default_cancel_timeout
        always_reload_bt_xml error_code_name_prefixes navigators navigate_to_pose.*
        navigate_through_poses.* *_blackboard_id enable_groot_monitoring groot_zmq_* filter_duration
        bt_search_directories odom_duration
    """,
    "waypoint_follower": """
        input_at_waypoint.* photo_at_waypoint.* wait_at_waypoint.timeout
        waypoint_task_executor_plugin=input_at_waypoint|photo_at_waypoint
    """,
    "velocity_smoother": """
        odom_duration stamp_smoothed_velocity_with_smoothing_time
    """,
    "docking_server": """
        initial_rotation backward_blind odom_topic odom_duration rotation_angular_tolerance
        max_staging_time action_server_result_timeout controller.costmap_topic
        controller.footprint_topic controller.transform_tolerance controller.simulation_step
        controller.rotate_to_heading_* controller.rotate_to_dock* controller.deceleration_max
        controller.angular_disengage_threshold controller.type *.dock_direction *.rotate_to_dock
        *.detector_service_* *.subscribe_toggle
    """,
    "route_server": """
        costmap_topic max_iterations max_planning_time smooth_corners smoothing_radius
        edge_cost_functions operations graph_file_loader graph_file_saver aggregate_blocked_edges
        enable_nn_search max_nn_search_iterations num_nearest_nodes min_prune_distance_from_goal
        min_distance_from_start global_frame transform_tolerance *.plugin *Scorer.* *.speed_tag
        *.speed_limit_topic *.max_collision_dist *.*_topic *.service_name
    """,
    "collision_monitor": """
        transform_tolerance base_shift_correction observation_sources *.type *.action_type
        *.visualize *.polygon_pub_topic *.footprint_topic *.polygon_sub_topic *.sources_names
        *.polygon_subscribe_transient_local *.max_points *.holonomic *.velocity_polygons
        *.min_height *.max_height *.min_range *.use_global_height *.obstacles_angle *.topic
        *.points *.radius *.min_points *.slowdown_ratio *.linear_limit *.angular_limit
        *.time_before_collision *.simulation_time_step *.enabled
        *.sampling_distance *.source_timeout scan.enabled pointcloud.enabled range.enabled
    """,
    "local_costmap/local_costmap": _COSTMAP,
    "global_costmap/global_costmap": _COSTMAP,
    "explorer": "",
    "ekf_filter_node": """
        frequency two_d_mode print_diagnostics debug* map_frame odom_frame base_link_frame
        world_frame *_config *_differential *_relative *_queue_size *_nodelay *_rejection_threshold
        *_remove_gravitational_acceleration process_noise_covariance initial_estimate_covariance
        dynamic_process_noise_covariance use_control *_limits *_gains control_*
        transform_time_offset transform_timeout publish_acceleration
        permit_corrected_publication reset_on_time_jump
        smooth_lagged_data history_length disabled_at_startup predict_to_current_time
    """,
    "robot_state_publisher": "robot_description frame_prefix ignore_timestamp",
}
_NODES = """
    *_rclcpp_node *_client lifecycle_manager* *lifecycle_manager *filter_info_server
    *filter_mask_server *_mask_server following_server
    loopback_simulator collision_detector base_footprint_publisher
    joint_state_publisher* ros_gz_bridge gz_* gazebo* controller_manager diff_drive_controller
    twist_mux teleop_* rviz* navsat_transform* map_merging turtlebot3_* turtlebot4_* create3_*
    amcl_* planner_server_* controller_server_* bt_navigator_* joy_node camera* *_driver* *lidar*
"""


def known_node(name: str) -> bool:
    """Tell whether Nav2 and its company have a node that we do without."""
    return any(fnmatchcase(name.rsplit("/", 1)[-1], pattern) for pattern in _NODES.split())


def known_elsewhere(node: str, key: str) -> bool:
    """Tell whether others know a parameter, by its dotted name, of one of our nodes."""
    entries = (_ANYWHERE + _KNOWN.get(node, "")).split()
    return any(fnmatchcase(key, entry) for entry in entries if "=" not in entry)


def known_value(node: str, key: str, value: Any) -> bool:
    """Tell whether others know a value of a parameter that we have without that value."""
    text = str(value).lower()
    for entry in _KNOWN.get(node, "").split():
        pattern, equals, values = entry.partition("=")
        if equals and fnmatchcase(key, pattern) and text in values.split("|"):
            return True
    return False
