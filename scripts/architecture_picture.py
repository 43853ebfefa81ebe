"""Draws docs/architecture.png: `python -m scripts.architecture_picture`.

Boxes are nodes, arrows topics, actions and transforms; below, the cores that the nodes convert for.
"""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "architecture.png"
_SIZE = (12.0, 7.6)
_COLOURS = {"sim": "#dbeafe", "where": "#dcfce7", "nav": "#fef3c7", "you": "#f3e8ff"}
_GROUPS = (  # x, y, width, height, title, colour
    (0.2, 2.3, 2.6, 4.5, "sim, or a robot's drivers", "sim"),
    (3.9, 2.3, 2.6, 4.5, "slam, or nav's localization", "where"),
    (7.6, 2.3, 4.2, 4.5, "nav", "nav"),
    (0.2, 7.2, 11.6, 0.8, "", "you"),
)
_NODES = (  # x, y, width, text
    (0.4, 5.5, 2.2, "sim\nphysics, sensors, drive"),
    (0.4, 4.1, 2.2, "ekf_filter_node\nwheels and gyro"),
    (0.4, 2.7, 2.2, "robot_state_publisher"),
    (4.1, 5.5, 2.2, "slam_toolbox\nmap and pose at once"),
    (4.1, 4.1, 2.2, "map_server, map_saver"),
    (4.1, 2.7, 2.2, "amcl\npose on a map"),
    (7.8, 5.5, 1.8, "bt_navigator\nwhat when"),
    (9.8, 5.5, 1.8, "waypoint_follower\ndocking, explorer"),
    (7.8, 4.1, 1.8, "planner_server\nglobal_costmap"),
    (9.8, 4.1, 1.8, "behavior_server\nspin, back up, wait"),
    (7.8, 2.7, 1.8, "controller_server\nlocal_costmap"),
    (9.8, 2.7, 1.8, "velocity_smoother\ncollision_monitor"),
)
_ARROWS = (  # from, to, text, where the text stands
    ((2.85, 5.9), (3.85, 5.9), "/scan", (3.35, 6.05)),
    ((2.85, 4.55), (3.85, 4.55), "odom → base", (3.35, 4.7)),
    ((2.85, 3.1), (3.85, 3.1), "base → lidar", (3.35, 3.25)),
    ((6.55, 5.2), (7.55, 5.2), "/map", (7.05, 5.35)),
    ((6.55, 3.6), (7.55, 3.6), "map → odom", (7.05, 3.75)),
    ((8.7, 5.45), (8.7, 5.0), "", (0.0, 0.0)),
    ((8.7, 4.05), (8.7, 3.6), "path", (8.95, 3.83)),
    ((9.62, 5.6), (10.2, 4.95), "", (0.0, 0.0)),
    ((9.0, 7.15), (8.8, 6.4), "navigate_to_pose", (9.65, 6.95)),
    ((1.5, 6.85), (1.5, 7.15), "camera, /tf, every topic", (2.55, 6.98)),
)
_CORES = (  # x, width, text
    (0.2, 2.8, "arjuna_sim\nstep(command) → observation"),
    (3.1, 3.4, "arjuna_slam\nprocess(scan, odometry) → pose, map"),
    (6.6, 5.2, "arjuna_nav\ntick(state) → command; planners, controllers, costmaps"),
)


def draw() -> Figure:
    """Return the picture."""
    figure = Figure(figsize=_SIZE, layout="constrained")
    axes = figure.add_subplot()
    axes.set(xlim=(0.0, 12.0), ylim=(0.0, 8.2))
    axes.axis("off")
    for x, y, width, height, title, colour in _GROUPS:
        _box(axes, (x, y), (width, height), _COLOURS[colour])
        axes.text(x + width / 2, y + height - 0.2, title, ha="center", va="center", weight="bold")
    you = "you: view, RViz, Foxglove, ros2, goto, tour, teleop, from arjuna import Robot"
    axes.text(6.0, 7.6, you, ha="center", va="center", weight="bold")
    for x, y, width, text in _NODES:
        _box(axes, (x, y), (width, 0.85), "white")
        axes.text(x + width / 2, y + 0.42, text, ha="center", va="center", fontsize=8.5)
    for start, end, text, at in _ARROWS:
        axes.annotate("", end, start, arrowprops={"arrowstyle": "->", "lw": 1.4})
        axes.text(*at, text, ha="center", va="center", fontsize=8.5, style="italic")
    _draw_command(axes)
    _draw_cores(axes)
    return figure


def _draw_command(axes: Axes) -> None:
    axes.annotate("", (9.75, 3.1), (9.65, 3.1), arrowprops={"arrowstyle": "->", "color": "tab:red"})
    axes.plot([10.7, 10.7, 0.3, 0.3], [2.65, 2.05, 2.05, 5.9], color="tab:red", lw=1.4)
    axes.annotate("", (0.42, 5.9), (0.25, 5.9), arrowprops={"arrowstyle": "->", "color": "tab:red"})
    axes.text(5.0, 2.17, "/cmd_vel", color="tab:red", ha="center", fontsize=8.5, style="italic")


def _draw_cores(axes: Axes) -> None:
    for x, width, text in _CORES:
        _box(axes, (x, 0.95), (width, 0.85), "#f1f5f9")
        axes.text(x + width / 2, 1.37, text, ha="center", va="center", fontsize=8.5)
    _box(axes, (0.2, 0.1), (11.6, 0.65), "#f1f5f9")
    below = "arjuna_core: geometry, grids, scans, map files, configuration; ros/: nodes, transforms"
    axes.text(6.0, 0.42, below, ha="center", va="center", fontsize=8.5)


def _box(axes: Axes, corner: tuple[float, float], size: tuple[float, float], colour: str) -> None:
    style = "round,pad=0,rounding_size=0.08"
    axes.add_patch(FancyBboxPatch(corner, *size, boxstyle=style, fc=colour, ec="#475569"))


if __name__ == "__main__":
    draw().savefig(PICTURE, dpi=90, metadata={"Software": ""})
