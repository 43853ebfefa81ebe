"""One end of a topic."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Endpoint:
    """A publisher or subscription.

    Attributes:
        node: Full name of its node, `/amcl`.
        reliable: Whether its reliability is reliable, not best effort.
        latched: Whether its durability is transient local, not volatile.
    """

    node: str
    topic: str
    type: str
    publishes: bool
    reliable: bool = True
    latched: bool = False
