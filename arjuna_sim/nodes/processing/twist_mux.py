"""twist_mux: of several sources of velocities the one of the highest priority passes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from std_msgs.msg import Bool

from arjuna_core.config import duration_param, fixed, param
from arjuna_core.plugins import names_below, with_configs
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.velocity import VelocityInput


@dataclass(frozen=True)
class SourceConfig:
    """Parameters of a source of velocities, or of a lock."""

    topic: str = fixed("", "Its topic.")
    timeout: float = duration_param(0.0, "Age at which its message counts no more; 0 for none.")
    priority: int = param(0, "Its priority; 0 never passes.", minimum=0, maximum=255)
    short_desc: str = param("", "What it is.")


@dataclass(frozen=True)
class Sources:
    """Sources by their names."""

    def named(self) -> Mapping[str, SourceConfig]:
        """Return the sources by name."""
        return {item.name: getattr(self, item.name) for item in fields(self)}


@dataclass(frozen=True)
class TwistMuxConfig:
    """Parameters of `twist_mux`; each source and each lock adds its own."""

    use_stamped: bool = fixed(
        True,
        "Whether velocities are TwistStamped; a source that publishes the other type alone is taken"
        " as that.",
    )
    topics: Sources = field(default_factory=Sources)
    locks: Sources = field(default_factory=Sources)

    @classmethod
    def config_for(cls, values: Mapping[str, Any]) -> type[TwistMuxConfig]:
        """Return the class with the sources and locks that values name."""

        def named(part: str) -> Any:
            names = names_below(values, part)
            return with_configs(Sources, tuple((name, SourceConfig) for name in names))

        parts = ("topics", "locks")
        return with_configs(cls, tuple((part, named(part)) for part in parts))


class _Source:
    """A source, its last message and when that came [s]."""

    def __init__(self, config: SourceConfig) -> None:
        self.config = config
        self.message: Any = None
        self.came = -math.inf

    def expired(self, now: float) -> bool:
        """Return whether its message is too old, or none came."""
        return 0.0 < self.config.timeout < now - self.came


class TwistMuxNode(ManagedNode):
    """Publishes on `cmd_vel_out`; a lock that is true or silent masks lower priorities.

    Source: twist_mux, `TwistMux::hasPriority` and its README.
    """

    Config = TwistMuxConfig
    DEFAULT_NAME = "twist_mux"

    def configure(self) -> None:
        """Create the topics."""
        config: TwistMuxConfig = self.config
        kind = TwistStamped if config.use_stamped else Twist
        self._out = self.publisher(kind, "cmd_vel_out", qos.LATEST)
        self._sources = _of(config.topics)
        self._locks = _of(config.locks)
        for source in self._sources.values():
            take = self._taking(source, self._pass)
            VelocityInput(self, source.config.topic, config.use_stamped, take, qos.DEFAULT)
        for lock in self._locks.values():
            take = self._taking(lock, lambda source: None)
            self.subscribe(Bool, lock.config.topic, take, qos.DEFAULT)
        if not self._sources:
            self.get_logger().warning("no source: topics.NAME.topic, .timeout, .priority name them")

    def on_config(self, config: Any) -> None:
        """Take new priorities and time-outs."""
        for part in ("topics", "locks"):
            known = getattr(self, "_sources" if part == "topics" else "_locks", {})
            for name, own in getattr(config, part).named().items():
                known[name].config = own

    def _taking(self, source: _Source, then: Callable[[_Source], None]) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            source.message, source.came = message, self.now
            then(source)

        return take

    def _pass(self, source: _Source) -> None:
        if source is self._first():
            self._out.publish(self._of_output(source.message))

    def _of_output(self, message: Any) -> Any:
        """Return a command as the type that is published."""
        is_stamped = isinstance(message, TwistStamped)
        if is_stamped == self.config.use_stamped:
            return message
        if is_stamped:
            return message.twist
        return TwistStamped(header=header("", self.now), twist=message)

    def _first(self) -> _Source | None:
        """Return the source that passes now."""
        locks = (
            one.config.priority
            for one in self._locks.values()
            if one.expired(self.now) or (one.message is not None and bool(one.message.data))
        )
        least = max((1, *locks))
        open_ = [
            one
            for one in self._sources.values()
            if not one.expired(self.now) and one.config.priority >= least
        ]
        return max(open_, key=lambda one: one.config.priority, default=None)


def _of(sources: Sources) -> dict[str, _Source]:
    return {name: _Source(config) for name, config in sources.named().items()}
