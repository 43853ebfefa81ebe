"""The tree of frames: gaps, twins, late ones."""

from __future__ import annotations

from bringup.doctor.finding import Finding
from bringup.doctor.snapshot import Snapshot
from bringup.viewing.frame_tree import chain, loops, roots

_LATE = 0.5  # [s] Nav2's transform_tolerance is 0.1 to 0.3
_AHEAD = 2.0  # [s] localization dates map -> odom a little ahead
_SOURCES = {
    ("map", "odom"): "a localization: python -m bringup nav --map FILE, or slam",
    ("odom", "base"): "odometry: python -m bringup sim, or the robot's driver",
}
_BASES = ("base_footprint", "base_link")


def check(snapshot: Snapshot) -> list[Finding]:
    """Return what is wrong with the tree of frames."""
    frames = snapshot.frames
    if not snapshot.publishers("/tf") and not frames:
        return []
    found = [*_gaps(snapshot), *_sensor(snapshot)]
    if looped := loops(frames):
        what = f"the frames {', '.join(looped)} are their own ancestors"
        found.append(Finding(what, "one of their publishers has parent and child mixed up"))
    for name, frame in frames.items():
        if len(frame.parents) > 1:
            what = f"frame {name} has {len(frame.parents)} parents: {', '.join(frame.parents)}"
            found.append(Finding(what, "stop one of its publishers (tf says which frames)"))
        if not frame.static and not -_AHEAD <= frame.age <= _LATE:
            what = f"{frame.parent} -> {name} is {abs(frame.age):.1f} s "
            what += "late" if frame.age > 0.0 else "ahead: another clock stamps it"
            found.append(Finding(what, "its publisher hangs, or stamps by another clock"))
    return found


def _gaps(snapshot: Snapshot) -> list[Finding]:
    """Name what is missing between map, odom and base."""
    frames = snapshot.frames
    base = next((name for name in _BASES if name in {*frames, *roots(frames)}), None)
    needs_map = snapshot.runs("amcl", "slam_toolbox", "bt_navigator", "planner_server")
    found = []
    if base is None:
        cure = "python -m bringup sim, or robot_state_publisher with your URDF"
        return [Finding(f"no frame {' or '.join(_BASES)} in the tree", cure)]
    if "odom" not in chain(frames, base):
        what = f"no transform odom -> {base}"
        found.append(Finding(what, f"start {_SOURCES['odom', 'base']}"))
    if needs_map and "map" not in chain(frames, "odom"):
        cure = f"give AMCL its pose (initial-pose X Y YAW), or start {_SOURCES['map', 'odom']}"
        found.append(Finding("no transform map -> odom", cure))
    return found


def _sensor(snapshot: Snapshot) -> list[Finding]:
    scan = snapshot.robot.scan
    if scan is None or "base_link" in chain(snapshot.frames, scan.frame):
        return []
    what = f"the scan's frame {scan.frame} does not hang on base_link"
    cure = "robot_state_publisher needs the URDF with that link, or a static transform"
    return [Finding(what, cure)]
