"""Parameter files as Nav2, slam_toolbox and robots' makers ship them, put together of parts."""

from __future__ import annotations

from pathlib import Path
from textwrap import indent

_PARTS = Path(__file__).with_name("stock")


def _part(name: str) -> str:
    return (_PARTS / f"{name}.yaml").read_text(encoding="utf-8")


def nav2_file(controller: str = "mppi", planner: str = "navfn", checkers: str = "checkers") -> str:
    """Return Jazzy's nav2_params.yaml with a controller and a planner of a choice."""
    of_controller = indent(_part(checkers) + _part(controller), "    ")
    of_planner = 'expected_planner_frequency: 20.0\nplanner_plugins: ["GridBased"]\n'
    return (
        f"{_part('nav2')}controller_server:\n  ros__parameters:\n{of_controller}"
        f"planner_server:\n  ros__parameters:\n{indent(of_planner + _part(planner), '    ')}"
    )


def humble_file() -> str:
    """Return a file of Humble's form, as TurtleBot3's: `/` in classes, singular checkers, DWB."""
    old = nav2_file("dwb", "old_navfn", "old_checkers")
    helpers = ("bt_navigator_navigate_to_pose_rclcpp_node", "amcl_map_client", "amcl_rclcpp_node")
    return old.replace("nav2_behaviors::", "nav2_behaviors/") + "".join(
        f"\n{name}: {{ros__parameters: {{use_sim_time: true}}}}" for name in helpers
    )


FILES = {
    "Jazzy's nav2_params": nav2_file(),
    "TurtleBot3 on Humble": humble_file(),
    "TurtleBot4 with DWB": nav2_file("dwb"),
    "the shim": nav2_file("pure_pursuit_under_shim"),
    "graceful": nav2_file("graceful"),
    "Theta*": nav2_file(planner="theta_star"),
    "Smac 2D": nav2_file(planner="smac_2d"),
    "Smac Hybrid": nav2_file(planner="smac_hybrid"),
    "mapper_params_online_async": _part("slam_async"),
    "a guide's SLAM": _part("guide_slam"),
    "a guide's navigation": _part("guide_nav"),
}
