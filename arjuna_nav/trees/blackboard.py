"""The blackboard: entries by name that the nodes of a tree read and write."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from arjuna_core.errors import ArjunaError


class TreeError(ArjunaError):
    """A tree cannot be built from its XML, or cannot run; the message says where."""


class Writes:
    """The number of writes to the blackboards of a tree."""

    __slots__ = ("count",)

    def __init__(self) -> None:
        self.count = 0


class Entry:
    """One entry of a blackboard.

    Attributes:
        value: None where there is none.
        written: The number of the last write to it, among all of the tree; 0 before.
    """

    __slots__ = ("_writes", "value", "written")

    def __init__(self, writes: Writes) -> None:
        self.value: Any = None
        self.written = 0
        self._writes = writes

    def set(self, value: Any) -> None:
        """Write the value; None removes it."""
        self.value = value
        self._writes.count = self.written = self._writes.count + 1


class Blackboard:
    """Entries by name; a subtree's entries may be those of the tree above under other names.

    Args:
        renamed: The name above of each entry that is the same there.
        all_shared: Whether every other entry is the same above, under its own name.
        own: Entries that are its own even so, with their values.

    Attributes:
        writes: Of all blackboards of the tree.
    """

    def __init__(
        self,
        above: Blackboard | None = None,
        renamed: Mapping[str, str] | None = None,
        all_shared: bool = False,
        own: Mapping[str, Any] | None = None,
    ) -> None:
        self._above = above
        self._renamed = dict(renamed or {})
        self._all_shared = all_shared
        self.writes: Writes = Writes() if above is None else above.writes
        self._entries = {name: Entry(self.writes) for name in own or {}}
        for name, value in (own or {}).items():
            self._entries[name].set(value)

    def entry(self, name: str) -> Entry:
        """Return an entry, which may have no value yet; '@name' is one of the whole tree."""
        if name.startswith("@"):
            return self._above.entry(name) if self._above is not None else self.entry(name[1:])
        if name in self._entries:
            return self._entries[name]
        if self._above is not None and (name in self._renamed or self._all_shared):
            return self._above.entry(self._renamed.get(name, name))
        return self._entries.setdefault(name, Entry(self.writes))

    def get(self, name: str) -> Any | None:
        """Return an entry's value, None where there is none."""
        return self.entry(name).value

    def set(self, name: str, value: Any) -> None:
        """Write an entry; None removes it."""
        self.entry(name).set(value)
