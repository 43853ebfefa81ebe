"""Managed nodes that do not work."""

from __future__ import annotations

from bringup.doctor.finding import Finding
from bringup.doctor.snapshot import Snapshot

_ACTIVE = "active"


def check(snapshot: Snapshot) -> list[Finding]:
    """Return the nodes that are not active."""
    found = []
    for node, state in sorted(snapshot.states.items()):
        if not state:
            what = f"{node} does not say what state it is in"
            found.append(
                Finding(what, "it starts, hangs or has no time: look again, then at its lines")
            )
        elif state != _ACTIVE:
            cure = "its lines say why; navigation is started by its lifecycle manager's"
            cure += " manage_nodes (STARTUP)"
            found.append(Finding(f"{node} is {state}, not active", cure))
    return found
