"""The last look before a velocity is driven: slow down or stop for what is seen now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from arjuna_core.config import plugin_names
from arjuna_core.errors import ConfigError
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.safety.sight import Sight
from arjuna_nav.safety.zones import ZONES, Action, Zone, ZoneConfig


@dataclass(frozen=True)
class MonitorConfig:
    """Parameters of the collision monitor; below the zones' names stand their own.

    Raises:
        ConfigError: A zone has no shape.
    """

    polygons: tuple[str, ...] = plugin_names((), "The zones in use.", ZONES)

    def __post_init__(self) -> None:
        found = {name: getattr(self, name, None) for name in self.polygons}
        problems = {n: zone.problem() for n, zone in found.items() if isinstance(zone, ZoneConfig)}
        if any(problems.values()):
            raise ConfigError(*(f"'{n}': {problem}" for n, problem in problems.items() if problem))


@dataclass(frozen=True)
class Verdict:
    """The velocity that may be driven, and why it is not the commanded one.

    Attributes:
        zone: Because of which zone; empty where nothing was done.
    """

    velocity: Velocity
    action: Action = Action.DO_NOTHING
    zone: str = ""


class CollisionMonitor:
    """Keeps the part of a velocity that every zone allows.

    Args:
        config: The zones, as `load` made them.
        sources: Names of what sees, in the order of the numbers in a `Sight`.

    Attributes:
        zones: Those that count, by name.

    Source: nav2_collision_monitor, CollisionMonitor::process.
    """

    def __init__(self, config: MonitorConfig, sources: Sequence[str] = ()) -> None:
        used = {n: one for n in config.polygons if (one := getattr(config, n)).enabled}
        self.zones: dict[str, Zone] = {name: ZONES.make(one) for name, one in used.items()}
        self._sources = {
            name: np.isin(np.array(sources, dtype=object), one.sources_names)
            for name, one in used.items()
            if one.sources_names
        }

    def judge(self, velocity: Velocity, sight: Sight, footprint: Footprint) -> Verdict:
        """Return what may be driven of a velocity by a robot that has a footprint."""
        verdict, least = Verdict(velocity), 1.0
        for name, zone in self.zones.items():
            ratio = zone.allowed(velocity, self._of_sources(name, sight), footprint)
            if zone.action is Action.STOP and ratio == 0.0:
                return Verdict(STILL, Action.STOP, name)
            if ratio < least:
                least = ratio
                verdict = Verdict(velocity.scaled(ratio), zone.action, name)
        return verdict

    def holding(self, velocity: Velocity, sight: Sight, footprint: Footprint) -> dict[str, bool]:
        """Return of each zone whether it holds as many points as count, by name.

        The velocity chooses the shape of those that have several.
        """
        return {
            name: zone.counts(velocity, self._of_sources(name, sight), footprint)
            for name, zone in self.zones.items()
        }

    def _of_sources(self, name: str, sight: Sight) -> Sight:
        """Return what the sources that a zone names see."""
        return sight.at(self._sources[name][sight.sources]) if name in self._sources else sight
