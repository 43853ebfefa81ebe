"""The robot's time."""

from __future__ import annotations

from collections.abc import Iterator

from bringup.doctor.snapshot import Finding, Snapshot

RANK = 4


def check(snapshot: Snapshot, slowest: float = 0.8, listed: int = 4) -> Iterator[Finding]:
    """Yield faults of /clock: the slowest pace, of real time; so many nodes are listed."""
    publishers = [end.node for end in snapshot.publishers("/clock")]
    waiting = ", ".join(end.node for end in snapshot.subscribers("/clock"))
    if not publishers and waiting:
        what = f"nobody publishes /clock, and {waiting} wait for it"
        yield Finding(what, "python -m bringup sim; a real robot needs use_sim_time: false")
    if len(publishers) > 1:
        what = f"{len(publishers)} publish /clock ({', '.join(publishers)}): time leaps"
        remedy = "stop all but one; a player beside a simulator plays without --clock"
        yield Finding(what, remedy)
    if len(publishers) != 1:
        return
    clock, names = snapshot.clock, snapshot.on_system_time
    if clock is None or clock.elapsed == 0.0:
        what = "/clock stands still: the simulation is paused"
        yield Finding(what, "python -m bringup world play")
    elif clock.set_back:
        what = f"/clock was set back {clock.set_back} times"
        yield Finding(what, "stop what resets the simulation or plays in a loop")
    elif snapshot.pace < slowest:
        what = f"the simulation runs at {snapshot.pace:.2f} of real time"
        yield Finding(what, "close other programs, or those that look at the camera")
    if names:
        some = ", ".join(names[:listed])
        some += f" and {len(names) - listed} more" if len(names) > listed else ""
        what = f"{publishers[0]} publishes /clock, and {some} stamp by the system's clock"
        yield Finding(what, "start them with use_sim_time:=true ('nav' and 'slam' take /clock)")
