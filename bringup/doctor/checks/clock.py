"""The robot's time."""

from __future__ import annotations

from bringup.doctor.finding import Finding
from bringup.doctor.snapshot import Snapshot

_SLOW = 0.8  # of real time
_LISTED = 4  # nodes that are named


def check(snapshot: Snapshot) -> list[Finding]:
    """Return what is wrong with /clock."""
    publishers = [end.node for end in snapshot.publishers("/clock")]
    waiting = [end.node for end in snapshot.subscribers("/clock")]
    if not publishers:
        if not waiting:
            return []
        what = f"nobody publishes /clock, and {', '.join(waiting)} wait for it"
        return [Finding(what, "python -m bringup sim; a real robot needs use_sim_time: false")]
    if len(publishers) > 1:
        what = f"{len(publishers)} publish /clock ({', '.join(publishers)}): time leaps"
        return [
            Finding(what, "stop all but one; a player beside a simulator plays without --clock")
        ]
    return [*_pace(snapshot), *_others(snapshot, publishers[0])]


def _others(snapshot: Snapshot, publisher: str) -> list[Finding]:
    """Name the nodes whose time is another than the simulator's."""
    names = snapshot.on_system_time
    if not names:
        return []
    listed = ", ".join(names[:_LISTED])
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    what = f"{publisher} publishes /clock, and {listed}{more} stamp by the system's clock"
    return [Finding(what, "start them with use_sim_time:=true ('nav' and 'slam' take /clock)")]


def _pace(snapshot: Snapshot) -> list[Finding]:
    clock = snapshot.clock
    if clock is None or clock.elapsed == 0.0:
        return [
            Finding("/clock stands still: the simulation is paused", "python -m bringup world play")
        ]
    if clock.set_back:
        what = f"/clock was set back {clock.set_back} times"
        return [Finding(what, "stop what resets the simulation or plays in a loop")]
    if snapshot.pace < _SLOW:
        what = f"the simulation runs at {snapshot.pace:.2f} of real time"
        return [Finding(what, "close other programs, or those that look at the camera")]
    return []
