"""The rows of the guides' error tables, and what says them here; text only, for `--help`."""

from __future__ import annotations

ROWS: dict[str, tuple[str, str]] = {
    "Couldn't find library libgazebo_ros_...": (
        "",
        "no plugin is needed: sim reads its tags itself",
    ),
    "/scan not in rostopic list": (
        "lidar",
        "who waits for /scan; sim --check FILE names the lidar",
    ),
    "robot visible but does not move": (
        "velocity",
        "who listens on /cmd_vel, Twist or TwistStamped; teleop needs its terminal in front",
    ),
    "map not building in rviz": ("localization", "whether /map comes, and how much of it is known"),
    "map file not found": (
        "",
        "nav --map FILE refuses at once and names the file; save-map NAME first",
    ),
    "GOAL FAILED during navigation": (
        "said lately",
        "the planner's own words, as goto prints them",
    ),
    "AMCL: no laser scan received": ("rates", "the rate of /scan, and its frame in transforms"),
    "Robot spins but does not localise": (
        "localization",
        "share of the scan on the map's walls; initial-pose X Y YAW",
    ),
    "catkin_make fails": ("installation", "modules that are missing; make setup"),
    "Gazebo very slow": ("clock", "how fast simulated time passes; resources: load and memory"),
    "Robot sinks into ground": ("body", "the true height of the base"),
    "spins in circles (angle convention)": (
        "lidar",
        "a lidar that hangs upside down, left for right",
    ),
    "bogus screen in a VM": ("graphics", "off-screen OpenGL; sim itself needs no screen"),
    "TF not available": ("transforms", "which frame is missing, late or has two parents"),
}
"""What a guide calls it: the check that says it ("" for none), and what that looks at."""


def page() -> str:
    """Return the table as text."""
    rows = [
        f"  {name}\n      {f'{check}: ' if check else ''}{text}"
        for name, (check, text) in ROWS.items()
    ]
    return "\n".join(["what the guides' error tables call it, and what says it here:", *rows])
