"""Names of ROS 1's planners, global and local, and ours."""

from __future__ import annotations

_FOLLOW = "controller_server:FollowPath"
_GOAL = "controller_server:general_goal_checker"
_AHEAD = f"{_FOLLOW}.PathAlign.forward_point_distance {_FOLLOW}.GoalAlign.forward_point_distance"
_DYNAMIC_WINDOW = f"""
max_vel_x {_FOLLOW}.max_vel_x {_FOLLOW}.max_speed_xy
min_vel_x {_FOLLOW}.min_vel_x
max_vel_theta {_FOLLOW}.max_vel_theta
acc_lim_x {_FOLLOW}.acc_lim_x
acc_lim_theta {_FOLLOW}.acc_lim_theta
xy_goal_tolerance {_GOAL}.xy_goal_tolerance
yaw_goal_tolerance {_GOAL}.yaw_goal_tolerance
latch_xy_goal_tolerance {_GOAL}.stateful
sim_time {_FOLLOW}.sim_time
sim_granularity {_FOLLOW}.linear_granularity
angular_sim_granularity {_FOLLOW}.angular_granularity
vx_samples {_FOLLOW}.vx_samples
vtheta_samples {_FOLLOW}.vtheta_samples
vth_samples {_FOLLOW}.vtheta_samples
occdist_scale {_FOLLOW}.BaseObstacle.scale
oscillation_reset_dist {_FOLLOW}.Oscillation.oscillation_reset_dist
trans_stopped_vel {_FOLLOW}.trans_stopped_velocity
min_vel_theta behavior_server:min_rotational_vel
- acc_lim_y max_vel_y min_vel_y vy_samples rot_stopped_vel theta_stopped_vel
- prune_plan publish_cost_grid publish_cost_grid_pc publish_traj_pc global_frame_id restore_defaults
"""
PLANNERS = {
    "DWAPlannerROS": f"""
{_DYNAMIC_WINDOW}
max_vel_trans {_FOLLOW}.max_speed_xy
max_trans_vel {_FOLLOW}.max_speed_xy
min_vel_trans {_FOLLOW}.min_speed_xy
min_trans_vel {_FOLLOW}.min_speed_xy
max_rot_vel {_FOLLOW}.max_vel_theta
path_distance_bias {_FOLLOW}.PathDist.scale {_FOLLOW}.PathAlign.scale
goal_distance_bias {_FOLLOW}.GoalDist.scale {_FOLLOW}.GoalAlign.scale
min_rot_vel behavior_server:min_rotational_vel
forward_point_distance {_AHEAD}
oscillation_reset_angle {_FOLLOW}.Oscillation.oscillation_reset_angle
twirling_scale {_FOLLOW}.Twirling.scale
- acc_limit_trans acc_lim_trans penalize_negative_x stop_time_buffer scaling_speed
- max_scaling_factor use_dwa
""",
    "TrajectoryPlannerROS": f"""
{_DYNAMIC_WINDOW}
max_rotational_vel {_FOLLOW}.max_vel_theta
acc_lim_th {_FOLLOW}.acc_lim_theta
pdist_scale {_FOLLOW}.PathDist.scale {_FOLLOW}.PathAlign.scale
path_distance_bias {_FOLLOW}.PathDist.scale {_FOLLOW}.PathAlign.scale
gdist_scale {_FOLLOW}.GoalDist.scale {_FOLLOW}.GoalAlign.scale
goal_distance_bias {_FOLLOW}.GoalDist.scale {_FOLLOW}.GoalAlign.scale
min_in_place_vel_theta behavior_server:min_rotational_vel
min_in_place_rotational_vel behavior_server:min_rotational_vel
escape_vel bt_navigator:backup_speed
heading_lookahead {_AHEAD}
- escape_reset_dist escape_reset_theta holonomic_robot y_vels meter_scoring heading_scoring
- heading_scoring_timestep dwa simple_attractor controller_frequency
""",
    "NavfnROS": """
allow_unknown planner_server:GridBased.allow_unknown
default_tolerance planner_server:GridBased.tolerance
- visualize_potential planner_window_x planner_window_y
""",
    "GlobalPlanner": """
allow_unknown planner_server:GridBased.allow_unknown
default_tolerance planner_server:GridBased.tolerance
use_dijkstra planner_server:GridBased.use_astar
- old_navfn_behavior use_quadratic use_grid_path cost_factor neutral_cost lethal_cost outline_map
- orientation_mode orientation_window_size publish_potential publish_scale visualize_potential
- planner_window_x planner_window_y restore_defaults
""",
}
"""A table for each planner that has a counterpart here, in the form of `ros1_names`."""
