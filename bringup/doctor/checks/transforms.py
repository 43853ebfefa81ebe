"""The tree of frames: gaps, twins, late ones."""

from __future__ import annotations

from collections.abc import Iterator

from bringup.doctor.snapshot import Finding, Snapshot
from bringup.viewing.frame_tree import chain, loops, roots

RANK = 8
_BASES = ("base_footprint", "base_link")


def check(snapshot: Snapshot, late: float = 0.5, ahead: float = 2.0) -> Iterator[Finding]:
    """Yield frames whose transforms are late [s] (Nav2 tolerates 0.1 to 0.3) or far ahead [s]."""
    frames = snapshot.frames
    if not snapshot.publishers("/tf") and not frames:
        return
    yield from _gaps(snapshot)
    scan = snapshot.robot.scan
    if scan is not None and "base_link" not in chain(frames, scan.frame):
        remedy = "robot_state_publisher needs the URDF with that link, or a static transform"
        yield Finding(f"the scan's frame {scan.frame} is not below base_link", remedy)
    if looped := loops(frames):
        what = f"the frames {', '.join(looped)} are their own ancestors"
        yield Finding(what, "one of their publishers has parent and child mixed up")
    for name, frame in frames.items():
        if len(frame.parents) > 1:
            what = f"frame {name} has {len(frame.parents)} parents: {', '.join(frame.parents)}"
            yield Finding(what, "stop one of its publishers (tf says which frames)")
        if not frame.static and not -ahead <= frame.age <= late:
            when = "late" if frame.age > 0.0 else "ahead: another clock stamps it"
            what = f"{frame.parent} -> {name} is {abs(frame.age):.1f} s {when}"
            remedy = "its publisher is stuck, or stamps by another clock"
            if frame.of_another_clock:
                remedy = "start its publisher with use_sim_time:=true ('clock' names the node)"
            yield Finding(what, remedy)
        if frame.static and frame.variants > 1:
            nodes = ", ".join(end.node for end in snapshot.publishers("/tf_static"))
            what = f"static {frame.parent} -> {name} is published {frame.variants} times, each"
            what += f" different (/tf_static: {nodes}): which one counts is chance"
            yield Finding(what, "stop one of its publishers; fixed joints of the URDF are some")


def _gaps(snapshot: Snapshot) -> Iterator[Finding]:
    frames = snapshot.frames
    base = next((name for name in _BASES if name in {*frames, *roots(frames)}), None)
    if base is None:
        remedy = "python -m bringup sim, or robot_state_publisher with your URDF"
        yield Finding(f"no frame {' or '.join(_BASES)} in the tree", remedy)
        return
    if "odom" not in chain(frames, base):
        remedy = "start odometry: python -m bringup sim, or the robot's driver"
        yield Finding(f"no transform odom -> {base}", remedy)
    needs_map = snapshot.runs("amcl", "slam_toolbox", "bt_navigator", "planner_server")
    if needs_map and "map" not in chain(frames, "odom"):
        remedy = (
            "give AMCL its pose (initial-pose X Y YAW), or start a localization:"
            " python -m bringup nav --map FILE, or slam"
        )
        yield Finding("no transform map -> odom", remedy)
