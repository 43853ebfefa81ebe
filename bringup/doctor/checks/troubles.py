"""Nodes that report on /diagnostics that they cannot do their work."""

from __future__ import annotations

from collections.abc import Iterator

from bringup.doctor.snapshot import Finding, Snapshot

RANK = 14


def check(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield what nodes report as an error."""
    for node, trouble in snapshot.robot.troubles:
        yield Finding(f"{node}: {trouble}", "the node's log and /diagnostics say when it is over")
