"""Names of ROS 1 that need no table: those that stay, and those of what is not here."""

from __future__ import annotations

KARTO = """
= base_frame odom_frame map_frame map_name scan_topic mode resolution max_laser_range
= map_update_interval transform_publish_period transform_timeout tf_buffer_duration throttle_scans
= minimum_time_interval minimum_travel_distance minimum_travel_heading solver_plugin
= ceres_linear_solver ceres_preconditioner ceres_trust_strategy ceres_dogleg_type
= ceres_loss_function debug_logging stack_size_to_use enable_interactive_mode use_map_saver
= map_file_name map_start_pose map_start_at_dock use_scan_matching use_scan_barycenter
= scan_buffer_size scan_buffer_maximum_scan_distance link_match_minimum_response_fine
= link_scan_maximum_distance loop_search_maximum_distance do_loop_closing
= loop_match_minimum_chain_size loop_match_maximum_variance_coarse
= loop_match_minimum_response_coarse loop_match_minimum_response_fine
= correlation_search_space_dimension correlation_search_space_resolution
= correlation_search_space_smear_deviation loop_search_space_dimension loop_search_space_resolution
= loop_search_space_smear_deviation distance_variance_penalty angle_variance_penalty
= fine_search_angle_offset coarse_search_angle_offset coarse_angle_resolution minimum_angle_penalty
= minimum_distance_penalty use_response_expansion min_pass_through occupancy_threshold
= lifelong_minimum_score lifelong_iou_match lifelong_node_removal_score lifelong_overlap_score_scale
= lifelong_constraint_multiplier lifelong_nearby_penalty lifelong_candidates_scale
delta resolution
"""
"""What slam_karto and slam_toolbox called as ROS 2's slam_toolbox does, which tells of each."""
_ELSEWHERE = """
TebLocalPlannerROS EBandPlannerROS MpcLocalPlannerROS SBPLLatticePlanner CarrotPlanner
aggressive_reset conservative_reset clearing_rotation rotate_recovery clear_costmap_recovery
move_slow_and_clear velocity_smoother navigation_velocity_smoother cmd_vel_mux
hector_mapping hector_trajectory_server hector_geotiff cartographer_node cartographer
robot_state_publisher joint_state_publisher robot_description rosdistro rosversion roslaunch
run_id use_sim_time gazebo
"""
WITHOUT = frozenset(_ELSEWHERE.split())
"""Sections of planners, mappers, recoveries and helpers that are not here, and roslaunch's own."""
STRANGERS = {
    "hector_mapping": """
        map_resolution map_size map_start_* map_multi_res_levels update_factor_* pub_map_odom*
        map_update_*_thresh use_tf_* laser_*_dist laser_z_* output_timing advertise_map_service
        scan_subscriber_queue_size map_pub_period map_with_known_poses base_frame odom_frame
        map_frame scan_topic
    """,
    "cartographer": """
        map_builder trajectory_builder MAP_BUILDER TRAJECTORY_BUILDER* POSE_GRAPH tracking_frame
        published_frame provide_odom_frame publish_frame_projected_to_2d use_odometry use_nav_sat
        use_landmarks num_* lookup_transform_timeout_sec *_period_sec *_sampling_ratio
        odom_frame map_frame
    """,
    "robot_localization": """
        frequency two_d_mode sensor_timeout publish_tf publish_acceleration print_diagnostics debug*
        world_frame base_link_frame odom_frame map_frame odom? odom?_* imu? imu?_* pose? pose?_*
        twist? twist?_* process_noise_covariance initial_estimate_covariance use_control control_*
        transform_time_offset transform_timeout
    """,
    "teb_local_planner": """
        teb_autosize dt_ref dt_hysteresis global_plan_* force_reinit_* feasibility_check_no_poses
        max_vel_x max_vel_x_backwards max_vel_y max_vel_theta acc_lim_x acc_lim_y acc_lim_theta
        min_turning_radius footprint_model wheelbase cmd_angle_* xy_goal_tolerance
        yaw_goal_tolerance free_goal_vel min_obstacle_dist inflation_dist include_*
        costmap_obstacles_* costmap_converter* obstacle_poses_affected no_*_iterations
        optimization_* penalty_epsilon weight_* enable_homotopy_class_planning
        enable_multithreading max_number_classes selection_* roadmap_graph_* viapoints_*
        obstacle_heading_threshold visualize_hc_graph odom_topic map_frame allow_init_*
        exact_arc_length
    """,
}
"""Programs that are not here, by names of their parameters with `*` and `?`, also shared ones."""
CURES = {
    "hector_mapping": "'slam' maps in its place, and needs none of them",
    "cartographer": "'slam' maps in its place, and needs none of them",
    "robot_localization": (
        "below 'ekf_filter_node: {ros__parameters: {...}}', ROS 2's form, they are read"
    ),
    "teb_local_planner": "'FollowPath.plugin' may be a pure pursuit, DWB or MPPI",
}
"""What to do without each."""
REASONS = {
    "planner_patience": "a plan that is not found is tried once more at once, then it recovers",
    "recovery_behavior_enabled": "recoveries run here in any case; false sets number_of_retries: 0",
    "clearing_rotation_allowed": "a recovery spins here in any case; false sets spin_dist: 0",
    "maxRange": "the scan's own range_max counts, and max_laser_range is maxUrange",
    "meter_scoring": "weights are of metres here; those of the file are written so",
    "escape_vel": "the way out is backwards here; below 0 it sets backup_speed",
    "min_vel_theta": "above 0 it sets the least rate of a turn on the spot, min_rotational_vel",
    "holonomic_robot": "DWB drives forward and turns here",
    "particles": "there is one map and its pose graph, no particles",
    "minimumScore": "there is no score of that kind; match_minimum_response is the nearest",
    **dict.fromkeys(("xmin", "ymin", "xmax", "ymax"), "the map grows as it is seen"),
}
"""Why a name has no effect here, or at a value, where a person who set it would ask."""
