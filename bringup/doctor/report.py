"""The findings of all checks, as a page and as JSON, and which check finds what guides list."""

from __future__ import annotations

import json
from dataclasses import asdict

from bringup.doctor.checks import CHECKS
from bringup.doctor.snapshot import Finding, Snapshot


def diagnose(snapshot: Snapshot) -> dict[str, list[Finding]]:
    """Return the findings of every check, by its name."""
    return {name: list(check(snapshot)) for name, check in CHECKS.items()}


def page(snapshot: Snapshot, findings: dict[str, list[Finding]]) -> str:
    """Return the findings as one screen: a line each, with its remedy."""
    count = len(snapshot.nodes)
    graph = f"{count} nodes" if count else "no robot runs"
    where = f"domain {snapshot.domain}"
    if snapshot.namespace != "/":
        where += f", {snapshot.namespace}"
    lines = [f"{where}, {graph}, listened for {snapshot.duration:.1f} s"]
    well = [name for name, found in findings.items() if not found]
    lines.append(f"ok        {', '.join(well)}")
    for name, found in findings.items():
        lines += [f"{name}\n  {finding.what}\n    -> {finding.remedy}" for finding in found]
    if snapshot.robot.log:
        lines += ["said lately", *(f"  {node}: {text}" for node, text in snapshot.robot.log)]
    return "\n".join(lines)


def as_json(snapshot: Snapshot, findings: dict[str, list[Finding]]) -> str:
    """Return the findings, and what they were made from, as JSON."""
    rows = [
        {"check": name, **asdict(finding)} for name, found in findings.items() for finding in found
    ]
    return json.dumps({"findings": rows, "snapshot": asdict(snapshot)}, indent=2)


ROWS: dict[str, tuple[str, str]] = {
    "Couldn't find library libgazebo_ros_...": (
        "",
        "no plugin is needed: sim reads its tags itself",
    ),
    "/scan not in rostopic list": (
        "lidar",
        "the nodes that wait for /scan; sim --check FILE names the lidar",
    ),
    "robot visible but does not move": (
        "velocity",
        "the listeners of /cmd_vel, Twist or TwistStamped; teleop needs its terminal in front",
    ),
    "map not building in rviz": ("localization", "/map, and the share of it that is known"),
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
    "Gazebo very slow": ("clock", "the pace of simulated time; resources: load and memory"),
    "Robot sinks into ground": ("body", "the true height of the base"),
    "spins in circles (angle convention)": ("lidar", "a lidar that is upside down, left for right"),
    "bogus screen in a VM": ("graphics", "off-screen OpenGL; sim itself needs no screen"),
    "TF not available": ("transforms", "the frame that is missing, late or has two parents"),
}
"""A guide's words: the check that finds it ("" for none), and what that looks at."""


def guides_page() -> str:
    """Return the table as text."""
    rows = [
        f"  {name}\n      {f'{check}: ' if check else ''}{text}"
        for name, (check, text) in ROWS.items()
    ]
    return "\n".join(["the guides' error tables, and what finds each row here:", *rows])
