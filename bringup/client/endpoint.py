"""One end of a topic."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Endpoint:
    """A publisher or subscription."""

    node: str  # full name of its node, `/amcl`
    topic: str
    type: str
    publishes: bool
    reliable: bool = True  # whether its reliability is reliable, not best effort
    latched: bool = False  # whether its durability is transient local, not volatile
