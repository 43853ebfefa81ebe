"""Managed nodes that do not work."""

from __future__ import annotations

from collections.abc import Iterator

from bringup.doctor.snapshot import Finding, Snapshot

RANK = 5


def check(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield the nodes that are not active."""
    for node, state in sorted(snapshot.states.items()):
        if not state:
            remedy = "it starts, is stuck or has no time: look again, then at its lines"
            yield Finding(f"{node} does not say what state it is in", remedy)
        elif state != "active":
            remedy = (
                "its lines say why; navigation is started by its lifecycle manager's"
                " manage_nodes (STARTUP)"
            )
            yield Finding(f"{node} is {state}, not active", remedy)
