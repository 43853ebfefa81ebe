"""Names of ROS 1's gmapping, karto, amcl, move_base, its costmaps and planners, and ours."""

from __future__ import annotations

from bringup.parameters.foreign.ros1_others import KARTO
from bringup.parameters.foreign.ros1_planners import PLANNERS

_FOLLOW = "controller_server:FollowPath"
_MOVES = "controller_server:progress_checker"
_STAY, _END = "=", "-"  # what begins a line of names that stay, or that mean nothing here
_COSTMAP = """
= update_frequency publish_frequency global_frame robot_base_frame width height origin_x origin_y
= resolution rolling_window footprint robot_radius footprint_padding transform_tolerance
= track_unknown_space lethal_cost_threshold map_topic trinary_costmap unknown_cost_value
= always_send_full_costmap use_maximum
subscribe_to_updates static_layer.subscribe_to_updates
combination_method obstacle_layer.combination_method
max_obstacle_height obstacle_layer.max_obstacle_height
min_obstacle_height obstacle_layer.min_obstacle_height
unknown_threshold obstacle_layer.unknown_threshold
publish_voxel_map obstacle_layer.publish_voxel_map
mark_threshold obstacle_layer.mark_threshold
origin_z obstacle_layer.origin_z
z_resolution obstacle_layer.z_resolution
z_voxels obstacle_layer.z_voxels
footprint_clearing_enabled obstacle_layer.footprint_clearing_enabled
inflation_radius inflation_layer.inflation_radius
inflate_unknown inflation_layer.inflate_unknown
cost_scaling_factor inflation_layer.cost_scaling_factor
obstacle_range obstacle_layer.scan.obstacle_max_range
raytrace_range obstacle_layer.scan.raytrace_max_range
observation_sources obstacle_layer.observation_sources
- static_map map_type first_map_only
"""
TABLES = {
    "amcl": """
= min_particles max_particles update_min_d update_min_a resample_interval transform_tolerance
= recovery_alpha_slow recovery_alpha_fast save_pose_rate first_map_only selective_resampling
= laser_min_range laser_max_range laser_likelihood_max_dist laser_model_type do_beamskip
= beam_skip_distance beam_skip_threshold beam_skip_error_threshold alpha1 alpha2 alpha3 alpha4
= alpha5 odom_frame_id base_frame_id global_frame_id tf_broadcast
kld_err pf_err
kld_z pf_z
initial_pose_x initial_pose.x
initial_pose_y initial_pose.y
initial_pose_a initial_pose.yaw
laser_max_beams max_beams
laser_z_hit z_hit
laser_z_short z_short
laser_z_max z_max
laser_z_rand z_rand
laser_sigma_hit sigma_hit
laser_lambda_short lambda_short
odom_model_type robot_model_type
odom_alpha1 alpha1
odom_alpha2 alpha2
odom_alpha3 alpha3
odom_alpha4 alpha4
odom_alpha5 alpha5
- initial_cov_xx initial_cov_yy initial_cov_aa gui_publish_rate use_map_topic
- force_update_after_initialpose force_update_after_set_map std_warn_level_x std_warn_level_y
- std_warn_level_yaw restore_defaults
""",
    "gmapping": """
= base_frame odom_frame map_frame scan_topic map_update_interval throttle_scans
= transform_publish_period
maxUrange max_laser_range
linearUpdate minimum_travel_distance
angularUpdate minimum_travel_heading
temporalUpdate minimum_time_interval
delta resolution
maxRange max_laser_range
- minimumScore particles sigma kernelSize lstep astep iterations lsigma ogain lskip srr srt
- str stt resampleThreshold xmin ymin xmax ymax llsamplerange llsamplestep lasamplerange
- lasamplestep occ_thresh tf_delay inverted_laser
""",
    "move_base": f"""
controller_frequency controller_server:controller_frequency
planner_frequency bt_navigator:replanning_frequency
controller_patience controller_server:failure_tolerance
oscillation_timeout {_MOVES}.movement_time_allowance
oscillation_distance {_MOVES}.required_movement_radius
base_local_planner {_FOLLOW}.plugin
base_global_planner planner_server:GridBased.plugin
max_planning_retries bt_navigator:number_of_retries
recovery_behavior_enabled bt_navigator:number_of_retries
clearing_rotation_allowed bt_navigator:spin_dist
- planner_patience recovery_behaviors conservative_reset_dist shutdown_costmaps
- make_plan_clear_costmap make_plan_add_unreachable_goal restore_defaults
""",
    **PLANNERS,
    "global_costmap": _COSTMAP,
    "local_costmap": _COSTMAP,
    "slam_toolbox": KARTO,
}
"""By section, a line each: a name of ROS 1 and ours, `NODE:NAME`; or `=` or `-` and many names."""
NODES = {
    "amcl": "amcl",
    "gmapping": "slam_toolbox",
    "slam_toolbox": "slam_toolbox",
    "global_costmap": "global_costmap/global_costmap",
    "local_costmap": "local_costmap/local_costmap",
}
"""Which of our nodes stands for a section, where its table does not say."""
SECTIONS = {
    "slam_gmapping": "gmapping",
    "slam_karto": "slam_toolbox",
    "DWAPlanner": "DWAPlannerROS",
    **{name: name for name in TABLES},
}
"""Which table a section of a file is of."""
TOPICS = {
    ("amcl", "scan"): (("amcl", "scan_topic"),),
    ("gmapping", "scan"): (("slam_toolbox", "scan_topic"),),
    ("move_base", "odom"): (
        ("bt_navigator", "odom_topic"),
        ("controller_server", "odom_topic"),
    ),
    ("move_base", "cmd_vel"): (
        ("collision_monitor", "cmd_vel_out_topic"),
        ("docking_server", "cmd_vel_topic"),
    ),
}
"""Our parameters for a topic that a launch file renames, by section and its old name."""
CLASSES = {
    "dwa_local_planner/DWAPlannerROS": "dwb_core::DWBLocalPlanner",
    "base_local_planner/TrajectoryPlannerROS": "dwb_core::DWBLocalPlanner",
    "navfn/NavfnROS": "nav2_navfn_planner::NavfnPlanner",
    "global_planner/GlobalPlanner": "nav2_navfn_planner::NavfnPlanner",
    "diff": "nav2_amcl::DifferentialMotionModel",
    "diff-corrected": "nav2_amcl::DifferentialMotionModel",
    "omni": "nav2_amcl::OmniMotionModel",
    "omni-corrected": "nav2_amcl::OmniMotionModel",
    "costmap_2d::StaticLayer": "nav2_costmap_2d::StaticLayer",
    "costmap_2d::ObstacleLayer": "nav2_costmap_2d::ObstacleLayer",
    "costmap_2d::VoxelLayer": "nav2_costmap_2d::VoxelLayer",
    "costmap_2d::InflationLayer": "nav2_costmap_2d::InflationLayer",
}


def targets(section: str) -> dict[str, list[tuple[str, str]]]:
    """Return what becomes of a section's names: nodes and names of ours, none where they end."""
    node, found = NODES.get(section, ""), dict[str, list[tuple[str, str]]]()
    for line in filter(None, TABLES[section].splitlines()):
        first, *names = line.split()
        if first == _STAY:
            found |= {name: [(node, name)] for name in names}
        elif first == _END:
            found |= {name: [] for name in names}
        else:
            ours = (name.rpartition(":")[::2] for name in names)
            found[first] = [(given or node, name) for given, name in ours]
    return found
