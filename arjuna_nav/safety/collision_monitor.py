"""The last look before a velocity is driven: slow down or stop for what the lidar sees now."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import plugin_names
from arjuna_core.twist import Velocity
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.safety.base import Action, Zone
from arjuna_nav.safety.zones import ZONES


@dataclass(frozen=True)
class MonitorConfig:
    """Parameters of the collision monitor; below the zones' names stand their own."""

    polygons: tuple[str, ...] = plugin_names(("FootprintApproach",), "The zones in use.", ZONES)


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

    Source: nav2_collision_monitor, CollisionMonitor::process.
    """

    def __init__(self, config: MonitorConfig) -> None:
        zones = {name: getattr(config, name) for name in config.polygons}
        self._zones: dict[str, Zone] = {
            name: ZONES.make(zone) for name, zone in zones.items() if zone.enabled
        }

    def judge(
        self,
        velocity: Velocity,
        points: NDArray[np.float64],
        footprint: Footprint,
        motions: NDArray[np.float64] | None = None,
        speeds: NDArray[np.float64] | None = None,
    ) -> Verdict:
        """Return what may be driven.

        Args:
            velocity: What is asked for.
            points: What is seen, `(N, 2) float64` in the base frame [m].
            footprint: The robot.
            motions: Velocities of the points over ground, `(N, 2)` in the base frame [m/s].
            speeds: At which each may turn to the robot, `(N,)` [m/s]; its motion's if None.
        """
        verdict, least = Verdict(velocity), 1.0
        for name, zone in self._zones.items():
            ratio = zone.allowed(velocity, points, footprint, motions, speeds)
            if ratio < least:
                least = ratio
                left = Velocity(velocity.v * ratio, velocity.w * ratio)
                verdict = Verdict(left, zone.action, name)
        return verdict
