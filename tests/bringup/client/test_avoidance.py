"""Obstacle avoidance: what is decided where something is near, whatever the lidar's convention."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from bringup.client.avoidance import Decision, decide


def scan(near: dict[int, float], start_deg: int = -180, sensor: SE2 | None = None) -> Scan:
    """Return a scan of one beam a degree, 5 m but where something is near, by bearing [deg]."""
    ranges = np.full(360, 5.0)
    for bearing, distance in near.items():
        ranges[(bearing - start_deg) % 360] = distance
    step = math.radians(1.0)
    return Scan(
        ranges, math.radians(start_deg), step, 0.1, 12.0, T_base_sensor=sensor or SE2(0, 0, 0)
    )


def choose(seen: Scan) -> Decision:
    return decide(seen, distance=0.7, speed=0.3, turn=0.5)


@pytest.mark.parametrize("start_deg", [-180, 0])
@pytest.mark.parametrize(
    ("near", "word", "v", "w"),
    [
        ({}, "FORWARD", 0.3, 0.0),
        ({0: 0.71}, "FORWARD", 0.3, 0.0),
        ({20: 0.2, -20: 0.2, 180: 0.2}, "FORWARD", 0.3, 0.0),
        ({14: 0.5}, "TURN LEFT", 0.0, 0.5),
        ({0: 0.5, 60: 1.0}, "TURN RIGHT", 0.0, -0.5),
        ({-3: 0.5, -60: 1.0}, "TURN LEFT", 0.0, 0.5),
    ],
)
def test_it_turns_to_the_side_with_more_room(
    near: dict[int, float], word: str, v: float, w: float, start_deg: int
) -> None:
    decision = choose(scan(near, start_deg))
    assert (decision.word, decision.v, decision.w) == (word, v, w)


def test_what_is_no_range_is_passed_over() -> None:
    decision = choose(scan({0: math.nan, 1: math.inf, 2: 0.005, 3: 0.4}))
    assert decision.front == 0.4


def test_nothing_seen_is_clear() -> None:
    ahead = dict.fromkeys(range(-180, 180), math.inf)
    assert choose(scan(ahead)) == Decision("FORWARD", 0.3, 0.0, 10.0, 10.0, 10.0)


def test_a_lidar_that_looks_back_is_turned() -> None:
    assert choose(scan({180: 0.5}, sensor=SE2(0.0, 0.0, math.pi))).front == 0.5


def test_the_line_reads_as_in_the_guide() -> None:
    line = str(Decision("TURN RIGHT", 0.0, -0.5, 0.55, 1.2, 3.4))
    assert line == "[TURN RIGHT] Front: 0.55m Left: 1.20m Right: 3.40m"
    assert str(Decision("FORWARD", 0.3, 0.0, 3.45, 4.2, 3.8)).startswith("[FORWARD ] Front: 3.45m")
