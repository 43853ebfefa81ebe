"""The last look before a velocity is driven: slow down or stop for what is seen now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import plugin_names
from arjuna_core.errors import ConfigError
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.safety.base import Action, Zone, inside
from arjuna_nav.safety.zones import ZONES, ZoneConfig


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
    """What may be driven, and why it is not what was asked.

    Attributes:
        velocity: What may be driven.
        action: What was done.
        zone: Because of which zone; empty where nothing was done.
    """

    velocity: Velocity
    action: Action = Action.DO_NOTHING
    zone: str = ""


class CollisionMonitor:
    """Keeps the part of a velocity that every zone allows.

    Args:
        config: The zones, as `load` made them.
        sources: Names of what sees, in the order of the numbers that `judge` is given.

    Attributes:
        zones: Those that count, by name.

    Source: nav2_collision_monitor, CollisionMonitor::process.
    """

    def __init__(self, config: MonitorConfig, sources: Sequence[str] = ()) -> None:
        zones = {name: getattr(config, name) for name in config.polygons}
        used = {name: zone for name, zone in zones.items() if zone.enabled}
        self.zones: dict[str, Zone] = {name: ZONES.make(zone) for name, zone in used.items()}
        self._least = {name: zone.least for name, zone in used.items()}
        self._heeded = {
            name: np.isin(np.array(sources, dtype=object), zone.sources_names)
            for name, zone in used.items()
            if zone.sources_names
        }

    def judge(
        self,
        velocity: Velocity,
        points: NDArray[np.float64],
        footprint: Footprint,
        motions: NDArray[np.float64] | None = None,
        speeds: NDArray[np.float64] | None = None,
        seen_by: NDArray[np.int64] | None = None,
    ) -> Verdict:
        """Return what may be driven.

        Args:
            velocity: What is asked for.
            points: What is seen, `(N, 2) float64` in the base frame [m].
            footprint: The robot.
            motions: Velocities of the points over ground, `(N, 2)` in the base frame [m/s].
            speeds: At which each may turn to the robot, `(N,)` [m/s]; its motion's if None.
            seen_by: Number of the source of each point, `(N,)`; None where zones heed all.
        """
        verdict, least = Verdict(velocity), 1.0
        for name, zone in self.zones.items():
            mine = self._heeded_of(name, seen_by)
            ratio = zone.allowed(
                velocity,
                points[mine],
                footprint,
                None if motions is None else motions[mine],
                None if speeds is None else speeds[mine],
            )
            if zone.action is Action.STOP and ratio == 0.0:
                return Verdict(STILL, Action.STOP, name)
            if ratio < least:
                least = ratio
                left = Velocity(velocity.x * ratio, yaw_rate=velocity.yaw_rate * ratio)
                verdict = Verdict(left, zone.action, name)
        return verdict

    def holding(
        self,
        velocity: Velocity,
        points: NDArray[np.float64],
        footprint: Footprint,
        seen_by: NDArray[np.int64] | None = None,
    ) -> dict[str, bool]:
        """Return of each zone whether it holds as many points as count, by name.

        Args:
            velocity: By which the shape is chosen.
            points: What is seen, `(N, 2) float64` in the base frame [m].
            footprint: The robot.
            seen_by: Number of the source of each point, `(N,)`; None where zones heed all.
        """
        return {
            name: inside(zone.outline(velocity, footprint), points[self._heeded_of(name, seen_by)])
            >= self._least[name]
            for name, zone in self.zones.items()
        }

    def _heeded_of(self, name: str, seen_by: NDArray[np.int64] | None) -> Any:
        """Return which points a zone heeds, as an index."""
        if seen_by is None or name not in self._heeded:
            return slice(None)
        return self._heeded[name][seen_by]
