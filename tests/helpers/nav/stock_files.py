"""Parameter files as Nav2, slam_toolbox and robots' makers ship them: their names and forms."""

from __future__ import annotations

from tests.helpers.nav.stock_plugins import (
    DWB,
    GRACEFUL,
    MPPI,
    NAVFN,
    OLD_NAVFN,
    PURE_PURSUIT_UNDER_SHIM,
    SMAC_2D,
    SMAC_HYBRID,
    THETA_STAR,
)
from tests.helpers.nav.stock_slam import GUIDE_SLAM, SLAM_ASYNC

_AMCL = """
  amcl:
    ros__parameters: {alpha1: 0.2, alpha2: 0.2, alpha3: 0.2, alpha4: 0.2, alpha5: 0.2,
      base_frame_id: base_footprint, beam_skip_distance: 0.5, beam_skip_error_threshold: 0.9,
      beam_skip_threshold: 0.3, do_beamskip: false, global_frame_id: map, lambda_short: 0.1,
      laser_likelihood_max_dist: 2.0, laser_max_range: 100.0, laser_min_range: -1.0,
      laser_model_type: likelihood_field, max_beams: 60, max_particles: 2000, min_particles: 500,
      odom_frame_id: odom, pf_err: 0.05, pf_z: 0.99, recovery_alpha_fast: 0.0,
      recovery_alpha_slow: 0.0, resample_interval: 1,
      robot_model_type: "nav2_amcl::DifferentialMotionModel", save_pose_rate: 0.5, sigma_hit: 0.2,
      tf_broadcast: true, transform_tolerance: 1.0, update_min_a: 0.2, update_min_d: 0.25,
      z_hit: 0.5, z_max: 0.05, z_rand: 0.5, z_short: 0.05, scan_topic: scan, use_sim_time: true}
"""
_COSTMAPS = """
  local_costmap:
    local_costmap:
      ros__parameters:
        update_frequency: 5.0
        publish_frequency: 2.0
        global_frame: odom
        robot_base_frame: base_link
        rolling_window: true
        width: 3
        height: 3
        resolution: 0.05
        robot_radius: 0.22
        plugins: ["voxel_layer", "inflation_layer"]
        inflation_layer: {plugin: "nav2_costmap_2d::InflationLayer", cost_scaling_factor: 3.0,
          inflation_radius: 0.70}
        voxel_layer:
          plugin: "nav2_costmap_2d::VoxelLayer"
          enabled: true
          publish_voxel_map: true
          origin_z: 0.0
          z_resolution: 0.05
          z_voxels: 16
          max_obstacle_height: 2.0
          mark_threshold: 0
          observation_sources: scan
          scan: {topic: /scan, max_obstacle_height: 2.0, clearing: true, marking: true,
            data_type: LaserScan, raytrace_max_range: 3.0, raytrace_min_range: 0.0,
            obstacle_max_range: 2.5, obstacle_min_range: 0.0}
        static_layer: {plugin: "nav2_costmap_2d::StaticLayer",
          map_subscribe_transient_local: true}
        always_send_full_costmap: true
  global_costmap:
    global_costmap:
      ros__parameters:
        update_frequency: 1.0
        publish_frequency: 1.0
        global_frame: map
        robot_base_frame: base_link
        robot_radius: 0.22
        resolution: 0.05
        track_unknown_space: true
        plugins: ["static_layer", "obstacle_layer", "inflation_layer"]
        obstacle_layer:
          plugin: "nav2_costmap_2d::ObstacleLayer"
          enabled: true
          observation_sources: scan
          scan: {topic: /scan, max_obstacle_height: 2.0, clearing: true, marking: true,
            data_type: LaserScan, raytrace_max_range: 3.0, raytrace_min_range: 0.0,
            obstacle_max_range: 2.5, obstacle_min_range: 0.0}
        static_layer: {plugin: "nav2_costmap_2d::StaticLayer",
          map_subscribe_transient_local: true}
        inflation_layer: {plugin: "nav2_costmap_2d::InflationLayer", cost_scaling_factor: 3.0,
          inflation_radius: 0.7}
        always_send_full_costmap: true
"""
_SERVERS = """
  bt_navigator:
    ros__parameters:
      global_frame: map
      robot_base_frame: base_link
      odom_topic: /odom
      bt_loop_duration: 10
      default_server_timeout: 20
      wait_for_service_timeout: 1000
      action_server_result_timeout: 900.0
      navigators: ["navigate_to_pose", "navigate_through_poses"]
      navigate_to_pose: {plugin: "nav2_bt_navigator::NavigateToPoseNavigator"}
      navigate_through_poses: {plugin: "nav2_bt_navigator::NavigateThroughPosesNavigator"}
      error_code_names: [compute_path_error_code, follow_path_error_code]
  map_server: {ros__parameters: {yaml_filename: ""}}
  map_saver: {ros__parameters: {save_map_timeout: 5.0, free_thresh_default: 0.25,
    occupied_thresh_default: 0.65, map_subscribe_transient_local: true}}
  smoother_server:
    ros__parameters:
      smoother_plugins: ["simple_smoother"]
      simple_smoother: {plugin: "nav2_smoother::SimpleSmoother", tolerance: 1.0e-10,
        max_its: 1000, do_refinement: true}
  behavior_server:
    ros__parameters:
      local_costmap_topic: local_costmap/costmap_raw
      global_costmap_topic: global_costmap/costmap_raw
      local_footprint_topic: local_costmap/published_footprint
      global_footprint_topic: global_costmap/published_footprint
      cycle_frequency: 10.0
      behavior_plugins: ["spin", "backup", "drive_on_heading", "assisted_teleop", "wait"]
      spin: {plugin: "nav2_behaviors::Spin"}
      backup: {plugin: "nav2_behaviors::BackUp"}
      drive_on_heading: {plugin: "nav2_behaviors::DriveOnHeading"}
      wait: {plugin: "nav2_behaviors::Wait"}
      assisted_teleop: {plugin: "nav2_behaviors::AssistedTeleop"}
      local_frame: odom
      global_frame: map
      robot_base_frame: base_link
      transform_tolerance: 0.1
      simulate_ahead_time: 2.0
      max_rotational_vel: 1.0
      min_rotational_vel: 0.4
      rotational_acc_lim: 3.2
  waypoint_follower:
    ros__parameters:
      loop_rate: 20
      stop_on_failure: false
      action_server_result_timeout: 900.0
      waypoint_task_executor_plugin: "wait_at_waypoint"
      wait_at_waypoint: {plugin: "nav2_waypoint_follower::WaitAtWaypoint", enabled: true,
        waypoint_pause_duration: 200}
  velocity_smoother:
    ros__parameters:
      smoothing_frequency: 20.0
      scale_velocities: false
      feedback: "OPEN_LOOP"
      max_velocity: [0.5, 0.0, 2.0]
      min_velocity: [-0.5, 0.0, -2.0]
      max_accel: [2.5, 0.0, 3.2]
      max_decel: [-2.5, 0.0, -3.2]
      odom_topic: "odom"
      odom_duration: 0.1
      deadband_velocity: [0.0, 0.0, 0.0]
      velocity_timeout: 1.0
  collision_monitor:
    ros__parameters:
      base_frame_id: "base_footprint"
      odom_frame_id: "odom"
      cmd_vel_in_topic: "cmd_vel_smoothed"
      cmd_vel_out_topic: "cmd_vel"
      state_topic: "collision_monitor_state"
      transform_tolerance: 0.2
      source_timeout: 1.0
      base_shift_correction: true
      stop_pub_timeout: 2.0
      polygons: ["FootprintApproach"]
      FootprintApproach: {type: "polygon", action_type: "approach",
        footprint_topic: "/local_costmap/published_footprint", time_before_collision: 1.2,
        simulation_time_step: 0.1, min_points: 6, visualize: false, enabled: true}
      observation_sources: ["scan"]
      scan: {type: "scan", topic: "scan", min_height: 0.15, max_height: 2.0, enabled: true}
  docking_server:
    ros__parameters: {controller_frequency: 50.0, dock_plugins: [simple_charging_dock],
      simple_charging_dock: {plugin: 'opennav_docking::SimpleChargingDock'}}
  loopback_simulator: {ros__parameters: {base_frame_id: "base_footprint", update_duration: 0.02}}
"""
_CHECKERS = """
      controller_frequency: 20.0
      costmap_update_timeout: 0.30
      min_x_velocity_threshold: 0.001
      min_y_velocity_threshold: 0.5
      min_theta_velocity_threshold: 0.001
      failure_tolerance: 0.3
      progress_checker_plugins: ["progress_checker"]
      goal_checker_plugins: ["general_goal_checker"]
      controller_plugins: ["FollowPath"]
      use_realtime_priority: false
      progress_checker: {plugin: "nav2_controller::SimpleProgressChecker",
        required_movement_radius: 0.5, movement_time_allowance: 10.0}
      general_goal_checker: {stateful: true, plugin: "nav2_controller::SimpleGoalChecker",
        xy_goal_tolerance: 0.25, yaw_goal_tolerance: 0.25}
"""
OLD_CHECKERS = """
      use_sim_time: True
      controller_frequency: 10.0
      min_x_velocity_threshold: 0.001
      min_y_velocity_threshold: 0.5
      min_theta_velocity_threshold: 0.001
      failure_tolerance: 0.3
      progress_checker_plugin: "moves"
      goal_checker_plugins: ["general_goal_checker", "precise"]
      controller_plugins: ["FollowPath"]
      moves: {plugin: "nav2_controller/SimpleProgressChecker", required_movement_radius: 0.5,
        movement_time_allowance: 10.0}
      precise: {plugin: "nav2_controller/SimpleGoalChecker", xy_goal_tolerance: 0.05,
        yaw_goal_tolerance: 0.05, stateful: True}
      general_goal_checker: {stateful: True, plugin: "nav2_controller/StoppedGoalChecker",
        xy_goal_tolerance: 0.05, yaw_goal_tolerance: 0.05}
"""
GUIDE_NAV = """
bt_navigator:
  ros__parameters: {global_frame: map, robot_base_frame: base_link, odom_topic: /odom,
    default_bt_xml_filename: "navigate_w_replanning_time.xml"}
controller_server:
  ros__parameters:
    controller_plugins: ["FollowPath"]
    FollowPath:
      plugin: "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController"
      desired_linear_vel: 0.3
      max_linear_accel: 2.5
      max_linear_decel: 2.5
      lookahead_dist: 0.6
local_costmap: {local_costmap: {ros__parameters: {update_frequency: 5.0, global_frame: odom,
  robot_base_frame: base_link, rolling_window: true, width: 3, height: 3, resolution: 0.05}}}
"""


def nav2_file(controller: str = MPPI, planner: str = NAVFN, checkers: str = _CHECKERS) -> str:
    """Return Jazzy's nav2_params.yaml with a controller and a planner of a choice."""
    body = "\n".join(
        [
            _AMCL,
            _SERVERS,
            _COSTMAPS,
            f"  controller_server:\n    ros__parameters:\n{checkers}{controller}",
            "  planner_server:\n    ros__parameters:\n      expected_planner_frequency: 20.0\n"
            f'      planner_plugins: ["GridBased"]\n{planner}',
        ]
    )
    return "\n".join(line.removeprefix("  ") for line in body.splitlines())


def humble_file() -> str:
    """Return a file of Humble's form, as TurtleBot3's: `/` in classes, singular checkers, DWB."""
    old = nav2_file(DWB, OLD_NAVFN, OLD_CHECKERS).replace("nav2_behaviors::", "nav2_behaviors/")
    helpers = ("bt_navigator_navigate_to_pose_rclcpp_node", "amcl_map_client", "amcl_rclcpp_node")
    return old + "".join(
        f"\n{name}: {{ros__parameters: {{use_sim_time: true}}}}" for name in helpers
    )


FILES = {
    "Jazzy's nav2_params": nav2_file(),
    "TurtleBot3 on Humble": humble_file(),
    "TurtleBot4 with DWB": nav2_file(DWB),
    "the shim": nav2_file(PURE_PURSUIT_UNDER_SHIM),
    "graceful": nav2_file(GRACEFUL),
    "Theta*": nav2_file(planner=THETA_STAR),
    "Smac 2D": nav2_file(planner=SMAC_2D),
    "Smac Hybrid": nav2_file(planner=SMAC_HYBRID),
    "mapper_params_online_async": SLAM_ASYNC,
    "a guide's SLAM": GUIDE_SLAM,
    "a guide's navigation": GUIDE_NAV,
}
