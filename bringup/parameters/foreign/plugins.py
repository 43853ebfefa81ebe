"""Plug-ins of a file whose classes are somebody's C++, and what takes their place."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from arjuna_core.errors import ConfigError, edits
from arjuna_core.param import info_of, key_of
from arjuna_core.plugins import PluginTypes, canonical, names_in
from bringup.parameters.foreign import nav2
from bringup.parameters.remarks import Kind, Remark

_PRIMARY = "primary_controller"
_CONTROLLERS = "controller_server"
_NAMED_BY_NAV2 = ("goal_checker", "simple_smoother", "wait_at_waypoint")
"""Names of which Nav2 knows the class, beside our own defaults."""
_OURS = "in Python: docs/plugins.md"


class PluginList(NamedTuple):
    """A parameter that lists plug-ins, or is one's class.

    Attributes:
        key: Its name, with those of the plug-ins that it is below.
        default: Its default names, in a list or in a text.
        is_class: Whether its value is a class's name.
    """

    key: str
    default: tuple[str, ...] | str
    kind: PluginTypes
    is_class: bool = False

    @property
    def prefix(self) -> str:
        """The prefix of its plug-ins' parameters."""
        return self.key[: self.key.rfind(".") + 1]


def plugin_lists(
    config: type[Any], values: Mapping[str, Any], prefix: str = ""
) -> Iterator[PluginList]:
    """Yield the lists of plug-ins of a node, and those of each plug-in after the list it is in.

    A parameter that is the class of the one plug-in is one of them.

    Args:
        values: The node's; those of a list that are changed before the next is taken count.
    """
    for item in dataclasses.fields(config):
        info = info_of(item) if item.metadata else None
        kind = info and (info.plugins or info.class_of)
        if info is None or not isinstance(kind, PluginTypes):
            continue
        default: Any = item.default
        found = PluginList(prefix + key_of(item), default, kind, info.class_of is kind)
        yield found
        if found.is_class:
            continue
        for name in names_in(values.get(found.key, default), default):
            own = f"{prefix}{name}."
            below = {k.removeprefix(own): v for k, v in values.items() if k.startswith(own)}
            try:
                inner = kind.config_of(_class_of(name, found, values), below)
            except ConfigError:  # the node's own check names it
                continue
            yield from plugin_lists(inner, values, own)


@dataclass
class ForeignPlugins:
    """The plug-ins of a node whose classes cannot be loaded, for they are somebody's C++.

    One that a class of ours stands in for has that, any other is left out of its list; where none
    is left, the list's default holds.

    Attributes:
        changed: The values that differ from the file's.
        left_out: The plug-ins that are in no list any more, each with those that it is below.
        replaced: Those of which another class stands in, the same way.
    """

    node: str
    changed: dict[str, Any] = field(default_factory=dict)
    left_out: set[str] = field(default_factory=set)
    replaced: set[str] = field(default_factory=set)
    remarks: list[Remark] = field(default_factory=list)

    def take(self, config: type[Any], values: dict[str, Any]) -> None:
        """Look through a node's values, which have the changes afterwards."""
        for one in plugin_lists(config, values):
            given = values.get(one.key, one.default)
            if not isinstance(given, str if isinstance(one.default, str) else (list, tuple)):
                continue
            if one.is_class:
                cls = canonical(str(given))
                if one.kind.stands_in and _is_foreign(cls, one.kind):
                    self._replace(one.key, one.key, cls, _stand_in(cls, one.kind), values)
                continue
            names = names_in(given, one.default)
            kept = [name for name in names if self._is_kept(name, one, values)]
            self._stand_in_for_primaries(kept, one, values)
            if len(kept) == len(names):
                continue
            if not kept and one.default:
                kept = list(names_in(one.default, one.default))
                text = f"nothing of it loads; its default holds: {', '.join(kept)}"
                self._remark(one.key, text, True)
            in_text = isinstance(one.default, str)
            values[one.key] = self.changed[one.key] = " ".join(kept) if in_text else kept

    def _is_kept(self, name: str, listed: PluginList, values: dict[str, Any]) -> bool:
        cls, kind, whole = _class_of(name, listed, values), listed.kind, listed.prefix + name
        if not _is_foreign(cls, kind):
            self._note_no_class(name, listed, values)
            return True
        ours = _stand_in(cls, kind, name)
        if ours:
            self._replace(whole, f"{whole}.{kind.key}", cls, ours, values)
        else:
            self.left_out.add(whole)
            self._remark(whole, f"{_origin(cls)}; {_OURS}")
        return bool(ours)

    def _note_no_class(self, name: str, listed: PluginList, values: Mapping[str, Any]) -> None:
        """Remark on a plug-in with which Nav2 would not start, for nothing names its class.

        One without any parameter may have them in an earlier file.
        """
        kind, whole = listed.kind, listed.prefix + name
        known = {*names_in(listed.default, listed.default), *kind.by_name, *_NAMED_BY_NAV2}
        given = {key for key in values if key.startswith(f"{whole}.")}
        if kind.stands_in and name not in known and given and f"{whole}.{kind.key}" not in given:
            text = f"{kind.default}, for no '{whole}.{kind.key}' says another class"
            self.remarks.append(Remark(Kind.UNKNOWN, f"{self.node}: {whole}", text))

    def _stand_in_for_primaries(
        self, names: list[str], listed: PluginList, values: dict[str, Any]
    ) -> None:
        """Replace the controllers of others that controllers of ours wrap."""
        for name in names if listed.kind.stands_in else ():
            key = f"{listed.prefix}{name}.{_PRIMARY}"
            cls = canonical(str(values.get(key, listed.kind.default)))
            if _is_foreign(cls, listed.kind):
                ours = _stand_in(cls, listed.kind)
                self._replace(listed.prefix + name, key, cls, ours, values)

    def _replace(self, name: str, key: str, cls: str, ours: str, values: dict[str, Any]) -> None:
        values[key] = self.changed[key] = ours
        self.replaced.add(name)
        limits = "".join(f", {own} {value:g}" for own, value in self._limits(name, values))
        text = f"{_origin(cls)}: {ours} stands in for it, with what it has of the parameters"
        self._remark(name, f"{text}{limits}; {_OURS}", True)

    def _limits(self, name: str, values: dict[str, Any]) -> Iterator[tuple[str, float]]:
        """Give what stands in the limits of other names, in groups too; yield each's value."""
        for ours, theirs in nav2.LIMITS.items() if self.node == _CONTROLLERS else ():
            own = f"{name}.{ours}"
            below = [key for key in values if key.startswith(f"{name}.")]
            found = [values[key] for key in below if key.rpartition(".")[2] in theirs]
            found = [value for value in found if isinstance(value, float | int) and value > 0.0]
            if found and own not in values:
                values[own] = self.changed[own] = float(min(found))
                yield ours, values[own]

    def _remark(self, name: str, reason: str, safety: bool = False) -> None:
        safety = safety or self.node in nav2.COSTMAPS
        self.remarks.append(Remark(Kind.NO_EFFECT, f"{self.node}: {name}", reason, safety))


def _class_of(name: str, listed: PluginList, values: Mapping[str, Any]) -> str:
    """Return a plug-in's class; its name where that is to say it."""
    kind = listed.kind
    default = kind.by_name.get(name, kind.default or ("" if kind.types else name))
    return canonical(str(values.get(f"{listed.prefix}{name}.{kind.key}", default)))


def _origin(cls: str) -> str:
    origin = "of Nav2 after Jazzy" if cls in nav2.LATER_CLASSES else "someone's C++"
    return f"'{cls}' is {origin}"


def _stand_in(cls: str, kind: PluginTypes, name: str = "") -> str:
    """Return what stands in for someone's class: ours of the same name, of which it is a copy.

    Else that of the plug-in's own name, or the default where that can do its work; empty if none.
    """
    if later := nav2.LATER_CLASSES.get(cls):
        return later
    last = cls.rpartition("::")[2]
    copied = [known for known in kind.types if known.rpartition("::")[2] == last]
    own = kind.by_name.get(name) or (kind.default if kind.stands_in else "")
    return copied[0] if copied else own


def _is_foreign(cls: str, kind: PluginTypes) -> bool:
    """Return whether a class is of a package that is not Nav2's, and cannot be loaded.

    A name that differs from one of Nav2's by two characters at most is a misspelt one.
    """
    if cls in nav2.LATER_CLASSES:
        return True
    package = cls.rpartition("::")[0]
    ours = {known.rpartition("::")[0] for known in kind.types}
    if kind.types and (not package or package in ours):
        return False
    if ":" in cls.replace("::", "") or cls in kind.by_name.values():
        return False
    try:
        kind.resolve(cls)
    except ConfigError:
        known = [*kind.types, *kind.by_name, *kind.by_name.values()]
        return all(edits(cls, each) > 2 for each in known)
    return False
