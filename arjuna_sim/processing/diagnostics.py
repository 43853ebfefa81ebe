"""Diagnostics in a tree: which analyzer takes a status, and what each reports.

Source: diagnostic_aggregator, `GenericAnalyzer`, `AnalyzerGroup` and `StatusItem`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

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


@dataclass
class Analyzer:
    """One node of the tree.

    Attributes:
        path: Its name, with those of the analyzers above it, as `/Robot/Arms`.
        kind: One of `KINDS`.
        startswith, contains, names, expected, regex: What the names of its statuses have.
        prefixes: What is taken off them.
        timeout: Age at which a status is stale [s]; negative for none.
        num_items: How many statuses there must be, if it matters.
        children: The analyzers below a group.
    """

    path: str
    kind: str = GENERIC
    startswith: tuple[str, ...] = ()
    contains: tuple[str, ...] = ()
    names: tuple[str, ...] = ()
    expected: tuple[str, ...] = ()
    regex: tuple[str, ...] = ()
    prefixes: tuple[str, ...] = ()
    timeout: float = 5.0
    num_items: int = -1
    discard_stale: bool = False
    children: tuple[Analyzer, ...] = ()
    items: dict[str, Status] = field(default_factory=dict)

    def matches(self, name: str) -> bool:
        """Return whether it takes a status of a name."""
        if self.kind == GROUP:
            return any(child.matches(name) for child in self.children)
        if name in self.names or name in self.expected:
            return True
        if any(re.search(pattern, name) for pattern in self.regex):
            return True
        return name.startswith(self.startswith or "\0") or any(t in name for t in self.contains)

    def take(self, status: Status) -> bool:
        """Take a status if it matches; return whether it did."""
        if not self.matches(status.name):
            return False
        if self.kind == GROUP:
            return sum(child.take(status) for child in self.children) > 0
        if self.kind == GENERIC:
            self.items[status.name] = status
        return True

    def report(self, now: float) -> list[Status]:
        """Return its status, then those below it."""
        if self.kind in (IGNORE, DISCARD):
            return []
        if self.kind == GROUP:
            below = [child.report(now) for child in self.children]
            return [self._summary([part[0] for part in below if part]), *_flat(below)]
        stale = {n for n, s in self.items.items() if 0.0 <= self.timeout < now - s.at}
        if self.discard_stale:
            kept = {n: s for n, s in self.items.items() if n not in stale and s.level != STALE}
            self.items = kept
        shown = [self._item(s, STALE if s.name in stale else s.level) for s in self.items.values()]
        missing = [name for name in self.expected if name not in self.items]
        shown += [Status(self._below(name), STALE, "Missing") for name in missing]
        head = self._summary(shown)
        if 0 <= self.num_items != len(self.items):
            head.level = max(head.level, ERROR)
            head.message = f"Expected {self.num_items}, found {len(self.items)}"
        return [head, *shown]

    def _item(self, status: Status, level: int) -> Status:
        name = self._below(status.name)
        return Status(name, level, status.message, status.hardware_id, status.values)

    def _below(self, name: str) -> str:
        for prefix in self.prefixes:
            name = name.removeprefix(prefix)
        return f"{self.path}/{name.strip('/ ').replace('/', ' ')}"

    def _summary(self, below: list[Status]) -> Status:
        """Return the worst level below; what is stale is an error unless all is."""
        levels = [status.level for status in below]
        level = max(levels, default=OK if self.discard_stale else STALE)
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


def analyzers(values: Mapping[str, Any], base: str) -> tuple[Analyzer, ...]:
    """Return the analyzers that dotted parameters name, each `NAME.type`, below a path.

    Those of a group, and all of them, may stand below `analyzers` or not.
    """
    if "analyzers.type" not in values:
        values = {key.removeprefix("analyzers."): value for key, value in values.items()}
    names = dict.fromkeys(key.partition(".")[0] for key in values if "." in key)
    found = []
    for name in names:
        own = {k[len(name) + 1 :]: v for k, v in values.items() if k.startswith(f"{name}.")}
        if own.get("type") in KINDS:
            found.append(_analyzer(name, own, base))
    return tuple(found)


def _analyzer(name: str, own: Mapping[str, Any], base: str) -> Analyzer:
    def texts(key: str) -> tuple[str, ...]:
        value = own.get(key, ())
        return (value,) if isinstance(value, str) else tuple(value)

    path = f"{base}/{str(own.get('path') or name).strip('/')}"
    removed = (*texts("find_and_remove_prefix"), *texts("remove_prefix"))
    return Analyzer(
        path,
        own["type"],
        startswith=(*texts("startswith"), *texts("find_and_remove_prefix")),
        contains=texts("contains"),
        names=texts("name"),
        expected=texts("expected"),
        regex=texts("regex"),
        prefixes=removed,
        timeout=float(own.get("timeout", 5.0)),
        num_items=int(own.get("num_items", -1)),
        discard_stale=bool(own.get("discard_stale", False)),
        children=analyzers({key: own[key] for key in own if "." in key}, path),
    )
