"""Random scenes: two lidars, zones, speed limits, and a collision monitor with one source."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from typing import Any

from tests.helpers.nav import scenes
from tests.helpers.nav.monitored import KINDS
from tests.helpers.nav.scenes import Outcome

_KINDS: dict[str, tuple[int, Callable[[int], Outcome]]] = {
    "lidars": (30, scenes.two_lidars),
    "one_lidar": (30, lambda seed: scenes.two_lidars(seed, both=False)),
    "keepout": (50, scenes.keepout),
    "speed": (50, scenes.speed_limits),
    **{f"monitor_{kind}": (20, partial(scenes.monitored, kind)) for kind in KINDS},
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument(
        "--kinds", nargs="*", choices=_KINDS, default=list(_KINDS), help="of scenes (all)"
    )
    parser.add_argument("--count", type=int, help="of each kind (20 to 50)")
    parser.add_argument("--seed", type=int, default=0, help="of the first scene (%(default)s)")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Drive to a goal in each scene; `one_lidar` is the same robot with its second lidar ignored.

    Returns:
        Of each kind the `count` of scenes, how many goals were `reached`, and in how many scenes
        something went `wrong`: a touch, a zone entered, a limit exceeded by 5 %, no stop before
        an obstacle that one source of the collision monitor alone sees. Of speed limits also
        for how many ticks one `held` and the `worst` share of it.
    """
    from rclpy.logging import LoggingSeverity, set_logger_level

    set_logger_level("", LoggingSeverity.FATAL)
    result = {}
    for kind in arguments.kinds:
        count, scene = _KINDS[kind]
        seeds = range(arguments.seed, arguments.seed + (arguments.count or count))
        found = [scene(seed) for seed in seeds]
        result[kind] = {
            "count": len(found),
            "reached": sum(one.reached for one in found),
            "wrong": sum(one.wrong > 0 for one in found),
            "held": sum(one.held for one in found),
            "worst": max(one.worst for one in found),
        }
        print(f"{kind:20}{result[kind]}", flush=True)
    return result
