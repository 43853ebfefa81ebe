"""Tells of another process whose nodes have our names: both answer, and time runs twice."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

from bringup.ros2.discovery import any_dead

_PERIOD = 1.0  # [s]
_LEASE = 25.0  # [s] a participant that died without a word is forgotten by then


class Twins:
    """Looks for names that the graph has twice, and says so once.

    Args:
        node: Whose graph and log are used.
        names: Full names of this process's nodes.
    """

    def __init__(self, node: Any, names: Iterable[str]) -> None:
        self._node = node
        self._names = set(names)
        self._due = 0.0
        self._since: float | None = None
        self._told = False

    def look(self, now: float) -> None:
        """Look, if that is due by a time on a steady clock [s]."""
        if now < self._due:
            return
        self._due = now + _PERIOD
        twice = self._twice()
        if not twice:
            self._since, self._told = None, False
            return
        self._since = now if self._since is None else self._since
        patience = _LEASE if any_dead(self._node) else 0.0
        if not self._told and now >= self._since + patience:
            self._told = True
            self._node.get_logger().warning(
                f"another process has {', '.join(twice)} too: end one of the two, or give one a"
                f" --namespace or another --domain-id (here {os.environ.get('ROS_DOMAIN_ID', '0')})"
            )

    def _twice(self) -> list[str]:
        """Return those of the names that the graph has more than once."""
        pairs = self._node.get_node_names_and_namespaces()
        every = [f"{space.rstrip('/')}/{name}" for name, space in pairs]
        return sorted(name for name in self._names if every.count(name) > 1)
