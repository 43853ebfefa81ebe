"""Parameters of controllers and planners as stock files have them."""

from __future__ import annotations

_CRITICS = """
        critics: [ConstraintCritic, CostCritic, GoalCritic, GoalAngleCritic, PathAlignCritic,
          PathFollowCritic, PathAngleCritic, PreferForwardCritic]
        ConstraintCritic: {enabled: true, cost_power: 1, cost_weight: 4.0}
        CostCritic: {enabled: true, cost_power: 1, cost_weight: 3.81, near_collision_cost: 253,
          critical_cost: 300.0, consider_footprint: false, collision_cost: 1000000.0,
          near_goal_distance: 1.0, trajectory_point_step: 2}
        GoalCritic: {enabled: true, cost_power: 1, cost_weight: 5.0, threshold_to_consider: 1.4}
        GoalAngleCritic: {enabled: true, cost_power: 1, cost_weight: 3.0,
          threshold_to_consider: 0.5}
        PreferForwardCritic: {enabled: true, cost_power: 1, cost_weight: 5.0,
          threshold_to_consider: 0.5}
        PathAlignCritic: {enabled: true, cost_power: 1, cost_weight: 14.0,
          max_path_occupancy_ratio: 0.05, trajectory_point_step: 4, threshold_to_consider: 0.5,
          offset_from_furthest: 20, use_path_orientations: false}
        PathFollowCritic: {enabled: true, cost_power: 1, cost_weight: 5.0, offset_from_furthest: 5,
          threshold_to_consider: 1.4}
        PathAngleCritic: {enabled: true, cost_power: 1, cost_weight: 2.0, offset_from_furthest: 4,
          threshold_to_consider: 0.5, max_angle_to_furthest: 1.0, mode: 0}
"""
MPPI = f"""
      FollowPath:
        plugin: "nav2_mppi_controller::MPPIController"
        time_steps: 56
        model_dt: 0.05
        batch_size: 2000
        ax_max: 3.0
        ax_min: -3.0
        ay_max: 3.0
        ay_min: -3.0
        az_max: 3.5
        vx_std: 0.2
        vy_std: 0.2
        wz_std: 0.4
        vx_max: 0.5
        vx_min: -0.35
        vy_max: 0.5
        wz_max: 1.9
        iteration_count: 1
        prune_distance: 1.7
        transform_tolerance: 0.1
        temperature: 0.3
        gamma: 0.015
        motion_model: "DiffDrive"
        visualize: true
        regenerate_noises: true
        TrajectoryVisualizer: {{trajectory_step: 5, time_step: 3}}
        AckermannConstraints: {{min_turning_r: 0.2}}
{_CRITICS}"""
DWB = """
      FollowPath:
        plugin: "dwb_core::DWBLocalPlanner"
        debug_trajectory_details: true
        min_vel_x: 0.0
        min_vel_y: 0.0
        max_vel_x: 0.26
        max_vel_y: 0.0
        max_vel_theta: 1.0
        min_speed_xy: 0.0
        max_speed_xy: 0.26
        min_speed_theta: 0.0
        acc_lim_x: 2.5
        acc_lim_y: 0.0
        acc_lim_theta: 3.2
        decel_lim_x: -2.5
        decel_lim_y: 0.0
        decel_lim_theta: -3.2
        vx_samples: 20
        vy_samples: 5
        vtheta_samples: 20
        sim_time: 1.7
        linear_granularity: 0.05
        angular_granularity: 0.025
        transform_tolerance: 0.2
        xy_goal_tolerance: 0.25
        trans_stopped_velocity: 0.25
        short_circuit_trajectory_evaluation: true
        stateful: true
        critics: ["RotateToGoal", "Oscillation", "BaseObstacle", "GoalAlign", "PathAlign",
          "PathDist", "GoalDist"]
        BaseObstacle.scale: 0.02
        PathAlign.scale: 32.0
        PathAlign.forward_point_distance: 0.1
        GoalAlign.scale: 24.0
        GoalAlign.forward_point_distance: 0.1
        PathDist.scale: 32.0
        GoalDist.scale: 24.0
        RotateToGoal.scale: 32.0
        RotateToGoal.slowing_factor: 5.0
        RotateToGoal.lookahead_time: -1.0
"""
PURE_PURSUIT_UNDER_SHIM = """
      FollowPath:
        plugin: "nav2_rotation_shim_controller::RotationShimController"
        primary_controller: "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController"
        angular_dist_threshold: 0.785
        angular_disengage_threshold: 0.3925
        forward_sampling_distance: 0.5
        rotate_to_heading_angular_vel: 1.8
        max_angular_accel: 3.2
        simulate_ahead_time: 1.0
        rotate_to_goal_heading: false
        desired_linear_vel: 0.3
        max_linear_accel: 2.5
        max_linear_decel: 2.5
        use_rotate_to_heading: false
"""
GRACEFUL = """
      FollowPath:
        plugin: nav2_graceful_controller::GracefulController
        transform_tolerance: 0.1
        min_lookahead: 0.25
        max_lookahead: 1.0
        initial_rotation: true
        initial_rotation_threshold: 0.75
        prefer_final_rotation: true
        allow_backward: false
        k_phi: 2.0
        k_delta: 1.0
        beta: 0.4
        lambda: 2.0
        v_linear_min: 0.1
        v_linear_max: 0.5
        v_angular_max: 5.0
        v_angular_min_in_place: 0.25
        slowdown_radius: 1.5
"""
NAVFN = """
      GridBased: {plugin: "nav2_navfn_planner::NavfnPlanner", tolerance: 0.5, use_astar: false,
        allow_unknown: true, use_final_approach_orientation: false}
"""
OLD_NAVFN = """
      GridBased: {plugin: "nav2_navfn_planner/NavfnPlanner", tolerance: 0.5, use_astar: true,
        allow_unknown: true}
"""
THETA_STAR = """
      GridBased: {plugin: "nav2_theta_star_planner::ThetaStarPlanner", how_many_corners: 8,
        w_euc_cost: 1.0, w_traversal_cost: 2.0, w_heuristic_cost: 1.0,
        terminal_checking_interval: 5000, allow_unknown: true}
"""
SMAC_2D = """
      GridBased: {plugin: "nav2_smac_planner::SmacPlanner2D", tolerance: 0.125,
        downsample_costmap: false, downsampling_factor: 1, allow_unknown: true,
        max_iterations: 1000000, max_on_approach_iterations: 1000, max_planning_time: 2.0,
        cost_travel_multiplier: 2.0, use_final_approach_orientation: false,
        smoother: {max_iterations: 1000, w_smooth: 0.3, w_data: 0.2, tolerance: 1.0e-10}}
"""
SMAC_HYBRID = """
      GridBased: {plugin: "nav2_smac_planner::SmacPlannerHybrid", downsample_costmap: false,
        downsampling_factor: 1, tolerance: 0.25, allow_unknown: true, max_iterations: 1000000,
        max_on_approach_iterations: 1000, max_planning_time: 5.0, motion_model_for_search: DUBIN,
        angle_quantization_bins: 72, analytic_expansion_ratio: 3.5,
        analytic_expansion_max_length: 3.0, analytic_expansion_max_cost: 200.0,
        analytic_expansion_max_cost_override: false, minimum_turning_radius: 0.40,
        reverse_penalty: 2.0, change_penalty: 0.0, non_straight_penalty: 1.2, cost_penalty: 2.0,
        retrospective_penalty: 0.015, lookup_table_size: 20.0, cache_obstacle_heuristic: false,
        debug_visualizations: false, use_quadratic_cost_penalty: false,
        downsample_obstacle_heuristic: true, allow_primitive_interpolation: false,
        smooth_path: true, smoother: {max_iterations: 1000, w_smooth: 0.3, w_data: 0.2,
        tolerance: 1.0e-10, do_refinement: true, refinement_num: 2}}
"""
