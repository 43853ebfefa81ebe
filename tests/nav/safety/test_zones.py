"""Zones as Nav2 has them: cases worked out by hand from its published sources."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.config import load
from arjuna_core.errors import ConfigError
from arjuna_core.twist import Velocity
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.safety.collision_monitor import CollisionMonitor, MonitorConfig, Verdict
from arjuna_nav.safety.sight import Sight, along_edges, on_arc
from arjuna_nav.safety.zones import Action

ROBOT = Footprint.polygon(np.array([[0.3, 0.2], [0.3, -0.2], [-0.3, -0.2], [-0.3, 0.2]]))
SQUARE = "[[0.5, 0.5], [0.5, -0.5], [-0.5, -0.5], [-0.5, 0.5]]"
APPROACH = {"action_type": "approach", "footprint_topic": "", "min_points": 1}


def judge(
    velocity: Velocity,
    points: Any,
    zones: dict[str, dict[str, Any]],
    sources: tuple[str, ...] = (),
    source: int = 0,
) -> Verdict:
    config = load(MonitorConfig, {"polygons": list(zones), **zones})
    sight = Sight.of(np.array(points, dtype=np.float64), source=source)
    return CollisionMonitor(config, sources).judge(velocity, sight, ROBOT)


def four(x: float, y: float) -> NDArray[np.float64]:
    return np.full((4, 2), (x, y))


def test_by_default_there_are_no_zones_and_four_points_count() -> None:
    assert judge(Velocity(1.0), four(0.0, 0.0), {}) == Verdict(Velocity(1.0))
    zone = {"Near": {"points": SQUARE}}
    assert judge(Velocity(1.0), four(0.4, 0.0)[:3], zone).action is Action.DO_NOTHING
    assert judge(Velocity(1.0), four(0.4, 0.0), zone) == Verdict(Velocity(), Action.STOP, "Near")


@pytest.mark.parametrize(
    ("zone", "velocity", "left"),
    [
        ({"action_type": "slowdown"}, Velocity(0.4, yaw_rate=0.2), Velocity(0.2, yaw_rate=0.1)),
        ({"action_type": "slowdown", "slowdown_ratio": 0.3}, Velocity(-1.0), Velocity(-0.3)),
        ({"action_type": "limit"}, Velocity(0.4, yaw_rate=0.2), Velocity(0.4, yaw_rate=0.2)),
        ({"action_type": "limit"}, Velocity(2.0, yaw_rate=0.2), Velocity(0.5, yaw_rate=0.05)),
        (
            {"action_type": "limit", "angular_limit": 0.1},
            Velocity(0.4, yaw_rate=0.2),
            Velocity(0.2, yaw_rate=0.1),
        ),
        ({"action_type": "slowdown"}, Velocity(0.4, y=-0.2), Velocity(0.2, y=-0.1)),
        ({"action_type": "limit"}, Velocity(0.6, y=0.8), Velocity(0.3, y=0.4)),
        ({"action_type": "none"}, Velocity(0.4, yaw_rate=0.2), Velocity(0.4, yaw_rate=0.2)),
        ({"max_points": 3}, Velocity(0.4), Velocity()),
        ({"max_points": 4}, Velocity(0.4), Velocity(0.4)),
        ({"enabled": False}, Velocity(0.4), Velocity(0.4)),
    ],
)
def test_what_a_zone_leaves(zone: dict[str, Any], velocity: Velocity, left: Velocity) -> None:
    verdict = judge(velocity, four(0.4, 0.4), {"Zone": {"points": SQUARE, **zone}})
    parts = [(each.x, each.y, each.yaw_rate) for each in (verdict.velocity, left)]
    assert parts[0] == pytest.approx(parts[1])


@pytest.mark.parametrize(
    ("velocity", "point", "kept", "part"),
    [
        # 0.54 m ahead at 0.05 m a step: the 11th collides, which the loop reaches at 1.0 s
        (Velocity(0.5), (0.84, 0.0), 2.0, 0.5),
        (Velocity(0.5), (0.34, 0.0), 2.0, 0.0),  # the first step collides, at 0.0 s
        (Velocity(0.5), (0.29, 0.0), 2.0, 0.0),  # it is inside
        (Velocity(-0.5), (0.29, 0.0), 2.0, 0.0),  # and may not leave
        (Velocity(y=0.5), (0.0, 0.74), 2.0, 0.5),  # sideways the same
        # the loop looks one step beyond the time that is kept: at 2.0 s it has driven 1.05 m
        (Velocity(0.5), (1.34, 0.0), 2.0, 1.0),
        (Velocity(0.5), (1.29, 0.0), 2.0, 0.95),
        (Velocity(0.5), (0.84, 0.21), 2.0, 1.0),  # beside its path
        # 0.35 m off, it is inside from 0.541 to 0.608 rad aside: turned by 0.5 rad, the 5th step
        (Velocity(yaw_rate=1.0), (0.35 * math.cos(1.05), 0.35 * math.sin(1.05)), 1.0, 0.4),
    ],
)
def test_it_approaches_by_the_time_of_the_first_step_that_collides(
    velocity: Velocity, point: tuple[float, float], kept: float, part: float
) -> None:
    zone = {"Foot": {**APPROACH, "time_before_collision": kept}}
    verdict = judge(velocity, [point], zone)
    left, expected = verdict.velocity, velocity.scaled(part)
    assert (left.x, left.y) == pytest.approx((expected.x, expected.y), abs=1e-9)
    assert left.yaw_rate == pytest.approx(expected.yaw_rate, abs=1e-9)


def test_it_approaches_with_its_own_points_or_radius() -> None:
    for own in ({"points": SQUARE}, {"type": "circle", "radius": 0.5}):
        zone = {"action_type": "approach", "min_points": 1, **own}
        verdict = judge(Velocity(0.5), [(0.94, 0.0)], {"Zone": zone})
        assert verdict.velocity.x == pytest.approx(0.5 * 0.8 / 2.0)  # 0.44 m: the ninth step


MOVING = {
    "type": "velocity_polygon",
    "velocity_polygons": ["turning", "ahead", "back"],
    "min_points": 1,
    "turning": {"points": "[[0.4, 0.4], [0.4, -0.4], [-0.4, -0.4], [-0.4, 0.4]]",
                "linear_min": 0.0, "linear_max": 0.05, "theta_min": -1.0, "theta_max": 1.0},
    "ahead": {"points": "[[1.0, 0.3], [1.0, -0.3], [-0.3, -0.3], [-0.3, 0.3]]",
              "linear_min": 0.0, "linear_max": 1.0, "theta_min": -1.0, "theta_max": 1.0},
    "back": {"points": "[[0.3, 0.3], [0.3, -0.3], [-1.0, -0.3], [-1.0, 0.3]]",
             "linear_min": -1.0, "linear_max": 0.0, "theta_min": -1.0, "theta_max": 1.0},
}  # fmt: skip


@pytest.mark.parametrize(
    ("velocity", "stops"),
    [
        (Velocity(0.5), {"ahead"}),
        (Velocity(0.05), {"beside"}),  # the first that holds it counts
        (Velocity(0.06), {"ahead"}),
        (Velocity(-0.5), {"behind"}),
        (Velocity(yaw_rate=0.5), {"beside"}),
        (Velocity(0.5, yaw_rate=1.5), set()),  # none holds it, and none did before
    ],
)
def test_a_velocity_polygon_is_chosen_by_the_velocity(velocity: Velocity, stops: set[str]) -> None:
    points = {"ahead": (0.9, 0.0), "behind": (-0.9, 0.0), "beside": (0.0, 0.38)}
    found = {k for k, p in points.items() if judge(velocity, [p], {"It": MOVING}).zone == "It"}
    assert found == stops


def test_a_velocity_that_no_shape_holds_keeps_the_last() -> None:
    config = load(MonitorConfig, {"polygons": ["It"], "It": MOVING})
    monitor, ahead = CollisionMonitor(config), Sight.of(np.array([(0.9, 0.0)]))
    assert monitor.judge(Velocity(2.0), ahead, ROBOT).action is Action.DO_NOTHING
    assert monitor.judge(Velocity(0.5), ahead, ROBOT).action is Action.STOP
    assert monitor.judge(Velocity(2.0), ahead, ROBOT).action is Action.STOP


@pytest.mark.parametrize(
    ("start", "end", "ahead", "back"),
    [(-1.0, 1.0, True, False), (2.0, -2.0, False, True), (-math.pi, math.pi, True, True)],
)
def test_holonomic_directions_count(start: float, end: float, ahead: bool, back: bool) -> None:
    limits = {"linear_min": -1.0, "linear_max": 1.0, "theta_min": -1.0, "theta_max": 1.0}
    between = {"direction_start_angle": start, "direction_end_angle": end}
    part = {"points": SQUARE, **limits, **between}
    zone = {"type": "velocity_polygon", "velocity_polygons": ["all"], "holonomic": True,
            "min_points": 1, "all": part}  # fmt: skip
    for v, held in ((0.5, ahead), (-0.5, back)):
        verdict = judge(Velocity(v), [(0.4, 0.0)], {"It": zone})
        assert (verdict.action is Action.STOP) is held


@pytest.mark.parametrize(("holonomic", "x", "y", "held"), [
    (True, 0.0, 0.5, True), (True, 0.3, -0.4, True), (True, 0.0, 0.1, False),
    (True, 0.9, 0.9, False), (False, 0.0, 0.5, False), (False, 0.5, 0.9, True),
])  # fmt: skip
def test_holonomic_speeds_count_everywhere(holonomic: bool, x: float, y: float, held: bool) -> None:
    part = {"points": SQUARE, "linear_min": 0.2, "linear_max": 1.0, "theta_max": 1.0}
    zone = {"type": "velocity_polygon", "velocity_polygons": ["all"], "holonomic": holonomic,
            "min_points": 1, "all": part}  # fmt: skip
    verdict = judge(Velocity(x, y=y), [(0.4, 0.0)], {"It": zone})
    assert (verdict.action is Action.STOP) is held


def test_a_zone_heeds_the_sources_that_it_names() -> None:
    zone = {"Near": {"points": SQUARE, "min_points": 1, "sources_names": ["rear"]}}
    for number, stops in ((0, False), (1, True)):
        verdict = judge(Velocity(0.5), [(0.4, 0.0)], zone, ("front", "rear"), number)
        assert (verdict.action is Action.STOP) is stops


def test_a_stop_comes_before_what_else_leaves_nothing() -> None:
    zones = {"Foot": {**APPROACH}, "Near": {"points": SQUARE, "min_points": 1}}
    assert judge(Velocity(0.5), [(0.2, 0.0)], zones).zone == "Near"


def test_a_shape_that_has_not_come_holds_nothing() -> None:
    zone = {"Far": {"polygon_sub_topic": "shape"}, "Foot": {"action_type": "approach"}}
    assert judge(Velocity(0.5), four(0.0, 0.0), zone) == Verdict(Velocity(0.5))


def test_what_a_zone_names_must_be_there() -> None:
    part = {"points": "[[0, 0]]"}
    zone = {"type": "velocity_polygon", "velocity_polygons": ["one"], "one": part}
    with pytest.raises(ConfigError, match=r"'It': 'one\.points': .*three corners"):
        load(MonitorConfig, {"polygons": ["It"], "It": zone})


def test_points_of_a_cone_and_of_edges() -> None:
    arc = on_arc(2.0, 0.1, 0.04)
    assert np.arctan2(arc[:, 1], arc[:, 0]) == pytest.approx([-0.05, -0.01, 0.03, 0.05])
    assert np.hypot(*arc.T) == pytest.approx(2.0)
    edges = along_edges(np.array([(0.0, 0.0), (0.25, 0.0), (0.25, 0.1)]), 0.1)
    assert len(edges) == 4 + 2 + 4  # both corners of each edge, as Nav2 has them
    assert edges[:4, 0] == pytest.approx([0.0, 0.25 / 3, 0.5 / 3, 0.25])
