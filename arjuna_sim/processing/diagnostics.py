"""Diagnostics in a tree: which analyzer takes a status, and what each reports.

Source: diagnostic_aggregator, `GenericAnalyzer`, `AnalyzerGroup` and `StatusItem`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from arjuna_core.config import fixed, param
from arjuna_core.param import key_of

OK, WARN, ERROR, STALE = range(4)
_TEXTS = ("OK", "Warning", "Error", "Stale")
GENERIC, GROUP, IGNORE, DISCARD = (
    f"diagnostic_aggregator/{name}"
    for name in ("GenericAnalyzer", "AnalyzerGroup", "IgnoreAnalyzer", "DiscardAnalyzer")
)
KINDS = (GENERIC, GROUP, IGNORE, DISCARD)


@dataclass
class Status:
    """A status of a component.

    Attributes:
        level: One of `OK`, `WARN`, `ERROR`, `STALE`.
        values: Keys and values.
        at: When it came [s].
    """

    name: str
    level: int
    message: str = ""
    hardware_id: str = ""
    values: tuple[tuple[str, str], ...] = ()
    at: float = 0.0


def _names(what: str) -> Any:
    return fixed((), f"{what} of the statuses that it takes.")


@dataclass(frozen=True)
class AnalyzerConfig:
    """Parameters of an analyzer; those of a group's stand below it, or below `analyzers` there."""

    type: str = fixed(GENERIC, "Its class.", choices=KINDS)
    path: str = fixed("", "Its name in the tree; empty for its parameters'.")
    startswith: tuple[str, ...] = _names("Beginnings of the names")
    contains: tuple[str, ...] = _names("Parts of the names")
    name: tuple[str, ...] = _names("Names")
    expected: tuple[str, ...] = _names("Names, missed where they do not come,")
    regex: tuple[str, ...] = _names("Regular expressions within the names")
    find_and_remove_prefix: tuple[str, ...] = _names("Beginnings, taken off, of the names")
    remove_prefix: tuple[str, ...] = _names("Beginnings, to be taken off, of the names")
    timeout: float = param(
        5.0, "Age at which a status is stale; negative for none.", unit="s", minimum=-1e9
    )
    num_items: int = param(-1, "How many statuses there must be; -1 for any.", minimum=-1)
    discard_stale: bool = fixed(False, "Whether stale ones are removed.")


class Analyzer:
    """One node of the tree.

    Attributes:
        path: Its name, with those of the analyzers above it, as `/Robot/Arms`.
        children: The analyzers below a group.
        items: The last statuses that it took, by name.
    """

    def __init__(self, config: AnalyzerConfig, path: str) -> None:
        self._config, self.path = config, path
        self.children = tuple(analyzers(config, path))
        self.items: dict[str, Status] = {}

    def _texts(self, *keys: str) -> tuple[str, ...]:
        """Return the texts of some parameters, each one or several."""
        values = [getattr(self._config, key) for key in keys]
        return tuple(t for each in values for t in ((each,) if isinstance(each, str) else each))

    def matches(self, name: str) -> bool:
        """Return whether it takes a status of a name."""
        if self._config.type == GROUP:
            return any(child.matches(name) for child in self.children)
        if name in self._texts("name", "expected"):
            return True
        if any(re.search(pattern, name) for pattern in self._texts("regex")):
            return True
        begins = name.startswith(self._texts("startswith", "find_and_remove_prefix"))
        return begins or any(text in name for text in self._texts("contains"))

    def take(self, status: Status) -> bool:
        """Take a status if it matches; return whether it did."""
        if not self.matches(status.name):
            return False
        if self._config.type == GROUP:
            return sum(child.take(status) for child in self.children) > 0
        if self._config.type == GENERIC:
            self.items[status.name] = status
        return True

    def report(self, now: float) -> list[Status]:
        """Return its status, then those below it."""
        if self._config.type in (IGNORE, DISCARD):
            return []
        if self._config.type == GROUP:
            below = [child.report(now) for child in self.children]
            return [self._summary([part[0] for part in below if part]), *_flat(below)]
        stale = {n for n, s in self.items.items() if 0.0 <= self._config.timeout < now - s.at}
        if self._config.discard_stale:
            kept = {n: s for n, s in self.items.items() if n not in stale and s.level != STALE}
            self.items = kept
        shown = [self._item(s, STALE if s.name in stale else s.level) for s in self.items.values()]
        missing = [name for name in self._texts("expected") if name not in self.items]
        shown += [Status(self._below(name), STALE, "Missing") for name in missing]
        head = self._summary(shown)
        if 0 <= self._config.num_items != len(self.items):
            head.level = max(head.level, ERROR)
            head.message = f"Expected {self._config.num_items}, found {len(self.items)}"
        return [head, *shown]

    def _item(self, status: Status, level: int) -> Status:
        name = self._below(status.name)
        return Status(name, level, status.message, status.hardware_id, status.values)

    def _below(self, name: str) -> str:
        for prefix in self._texts("find_and_remove_prefix", "remove_prefix"):
            name = name.removeprefix(prefix)
        return f"{self.path}/{name.strip('/ ').replace('/', ' ')}"

    def _summary(self, below: list[Status]) -> Status:
        """Return the worst level below; what is stale is an error unless all is."""
        levels = [status.level for status in below]
        level = max(levels, default=OK if self._config.discard_stale else STALE)
        if level == STALE and min(levels, default=STALE) < STALE:
            level = ERROR
        values = [(s.name.rpartition("/")[2], s.message or _TEXTS[s.level]) for s in below]
        return Status(self.path, level, _TEXTS[level], values=tuple(values))


def _flat(parts: Iterable[list[Status]]) -> Iterator[Status]:
    return (status for part in parts for status in part)


@dataclass
class Aggregator:
    """The analyzers of a robot, and one for what none of them takes."""

    analyzers: tuple[Analyzer, ...]
    other: Analyzer
    other_as_errors: bool = False

    def take(self, status: Status) -> None:
        """Take a status."""
        if not sum(analyzer.take(status) for analyzer in self.analyzers):
            self.other.items[status.name] = status

    def report(self, now: float) -> tuple[list[Status], int]:
        """Return all statuses, and the level of the whole."""
        found = list(_flat(analyzer.report(now) for analyzer in self.analyzers))
        if self.other.items:
            rest = self.other.report(now)
            if self.other_as_errors:
                rest[0].level, rest[0].message = ERROR, 'Unanalyzed items found in "Other"'
            found += rest
        levels = [status.level for status in found]
        level = max(levels, default=STALE)
        return found, ERROR if level > ERROR and min(levels, default=STALE) <= ERROR else level


def analyzers(config: Any, base: str) -> Iterator[Analyzer]:
    """Yield the analyzers that a configuration holds, below a path, or below `analyzers` in it."""
    for item in fields(config):
        own = getattr(config, item.name)
        if isinstance(own, AnalyzerConfig):
            yield Analyzer(own, f"{base}/{(own.path or key_of(item)).strip('/')}")
        elif is_dataclass(own):
            yield from analyzers(own, base)
