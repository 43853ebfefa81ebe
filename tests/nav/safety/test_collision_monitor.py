"""The collision monitor: what each zone leaves of a velocity."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.config import load
from arjuna_core.errors import ConfigError
from arjuna_core.twist import Velocity
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.safety.approach import ApproachConfig
from arjuna_nav.safety.collision_monitor import CollisionMonitor, MonitorConfig, Verdict
from arjuna_nav.safety.sight import Sight
from arjuna_nav.safety.zones import Action
from tests.helpers.nav.played import shipped_zones

ROBOT = Footprint.circle(0.25)
BOX = "[[0.5, 0.3], [0.5, -0.3], [-0.3, -0.3], [-0.3, 0.3]]"
FORWARD = Velocity(0.4)


def cluster(x: float, y: float, count: int = 8) -> NDArray[np.float64]:
    """Return points close together."""
    points: NDArray[np.float64] = np.array([x, y]) + 0.001 * np.arange(count)[:, None]
    return points


LATER = {"FootprintApproach.time_before_collision": 1.2}


OURS = shipped_zones()
SLOW = {"type": "circle", "action_type": "slowdown", "radius": 0.5}


def made(parameters: dict[str, Any]) -> CollisionMonitor:
    """Return a monitor of the shipped zones, or of those that the parameters list."""
    below = {} if "polygons" in parameters else OURS
    return CollisionMonitor(load(MonitorConfig, {**below, **parameters}))


def judge(velocity: Velocity, points: Any, **parameters: Any) -> Verdict:
    return made(parameters).judge(velocity, Sight.of(points), ROBOT)


def test_free_space_leaves_a_velocity_as_it_is() -> None:
    for points in (np.empty((0, 2)), cluster(3.0, 0.0), cluster(-0.4, 0.0), cluster(0.5, 0.5)):
        assert judge(FORWARD, points) == Verdict(FORWARD)


@pytest.mark.parametrize(("gap", "seconds"), [(0.4, 1.0), (0.2, 0.5), (0.01, 0.0)])
def test_the_speed_falls_with_the_time_before_a_collision(gap: float, seconds: float) -> None:
    verdict = judge(FORWARD, cluster(0.25 + gap, 0.0), **LATER)
    assert verdict.action is Action.APPROACH
    assert verdict.zone == "FootprintApproach"
    assert verdict.velocity.x == pytest.approx(0.4 * seconds / 1.2, abs=0.4 * 0.11 / 1.2)


@pytest.mark.parametrize("gap", np.arange(0.02, 1.5, 0.18).tolist())
def test_nobody_is_made_faster_and_who_comes_nearer_is_no_faster_than_before(gap: float) -> None:
    nearer, farther = (
        judge(Velocity(0.4, yaw_rate=0.1), cluster(0.25 + each, 0.0), **LATER).velocity
        for each in (gap, gap + 0.06)
    )
    assert 0.0 <= nearer.x <= farther.x + 1e-9 <= 0.4 + 2e-9
    assert nearer.yaw_rate == pytest.approx(0.25 * nearer.x)


def test_a_turn_is_slowed_where_a_corner_would_hit() -> None:
    long = Footprint.polygon(np.array([[0.4, 0.1], [0.4, -0.1], [-0.4, -0.1], [-0.4, 0.1]]))
    monitor = made(LATER)
    beside = cluster(0.25, 0.25)
    assert monitor.judge(Velocity(yaw_rate=1.0), Sight.of(beside), long).action is Action.APPROACH
    assert (
        monitor.judge(Velocity(yaw_rate=-0.1), Sight.of(beside), long).action is Action.DO_NOTHING
    )
    slowed = monitor.judge(Velocity(0.2, yaw_rate=1.0), Sight.of(beside), long).velocity
    assert slowed.yaw_rate / slowed.x == pytest.approx(5.0)  # the arc stays


def test_by_default_a_robot_that_can_still_stop_is_not_slowed() -> None:
    assert judge(FORWARD, cluster(0.25 + 0.21, 0.0)) == Verdict(FORWARD)
    assert judge(FORWARD, cluster(0.25 + 0.11, 0.0)).velocity.x == pytest.approx(0.4 * 2 / 5)


@pytest.mark.parametrize("footprint", [ROBOT, Footprint.polygon(np.array(
    [[0.25, 0.2], [0.25, -0.2], [-0.25, -0.2], [-0.25, 0.2]]))])  # fmt: skip
def test_a_robot_in_contact_may_move_where_it_gets_no_nearer(footprint: Footprint) -> None:
    monitor = made({})
    touched = cluster(0.23, 0.0)
    assert monitor.judge(FORWARD, Sight.of(touched), footprint).velocity == Velocity()
    back = Velocity(-0.3)
    assert monitor.judge(back, Sight.of(touched), footprint) == Verdict(back)
    wall = np.array([(x, 0.195) for x in np.arange(-1.0, 1.0, 0.01)])
    assert monitor.judge(FORWARD, Sight.of(wall), footprint) == Verdict(FORWARD)


def test_the_robots_own_parts_do_not_hold_it() -> None:
    parts = np.vstack([cluster(0.1, 0.1), cluster(-0.1, 0.05)])
    assert judge(FORWARD, parts) == Verdict(FORWARD)
    assert judge(FORWARD, np.vstack([parts, cluster(0.3, 0.0)])).action is Action.APPROACH


def test_few_points_are_noise() -> None:
    assert judge(FORWARD, cluster(0.3, 0.0, count=5)).action is Action.DO_NOTHING
    assert judge(FORWARD, cluster(0.3, 0.0, count=6)).action is Action.APPROACH


def test_a_stop_zone_stops_whatever_the_direction() -> None:
    zone = {"polygons": ("PolygonStop",), "PolygonStop": {"action_type": "stop", "points": BOX}}
    for velocity in (FORWARD, Velocity(-0.4), Velocity(yaw_rate=1.0)):
        verdict = judge(velocity, cluster(0.4, 0.0), **zone)
        assert verdict == Verdict(Velocity(), Action.STOP, "PolygonStop")
    assert judge(FORWARD, cluster(0.6, 0.0), **zone) == Verdict(FORWARD)
    assert judge(FORWARD, cluster(-0.25, 0.28), **zone).action is Action.STOP
    assert judge(FORWARD, cluster(-0.35, 0.0), **zone).action is Action.DO_NOTHING


def test_the_strictest_zone_decides() -> None:
    zones = {
        "polygons": ("PolygonSlow", "PolygonStop"),
        "PolygonSlow": SLOW,
        "PolygonStop": {**SLOW, "action_type": "stop", "radius": 0.3},
    }
    assert judge(FORWARD, cluster(0.4, 0.0), **zones).action is Action.SLOWDOWN
    assert judge(FORWARD, cluster(0.2, 0.0), **zones).action is Action.STOP
    assert judge(FORWARD, cluster(0.2, 0.0), **zones, **{"PolygonStop.enabled": False}).zone == (
        "PolygonSlow"
    )


def test_a_robot_that_stands_is_left_alone() -> None:
    assert judge(Velocity(), cluster(0.1, 0.0)) == Verdict(Velocity())


def test_points_that_are_no_zone_are_refused() -> None:
    with pytest.raises(ConfigError, match="at least three corners"):
        load(
            MonitorConfig,
            {"polygons": ["PolygonStop"], "PolygonStop.points": "[[0.0, 1.0], [1.0, 0.0]]"},
        )


def test_zones_have_any_names_and_several_may_do_the_same() -> None:
    zones = {
        "polygons": ["Near", "Far", "PolygonSlow"],
        "Near": {"action_type": "stop", "type": "circle", "radius": 0.4},
        "Far": {"action_type": "slowdown", "type": "polygon", "points": BOX, "slowdown_ratio": 0.3},
        "PolygonSlow": {**SLOW, "radius": 1.0, "slowdown_ratio": 0.6},
    }
    for x, zone, left in ((0.35, "Near", 0.0), (0.45, "Far", 0.12), (0.9, "PolygonSlow", 0.24)):
        verdict = judge(FORWARD, cluster(x, 0.0), **zones)
        assert verdict.zone == zone
        assert verdict.velocity.x == pytest.approx(left)


@pytest.mark.parametrize(
    ("zone", "message"),
    [
        ({"type": "square"}, "no zone 'square'; valid: circle, polygon, velocity_polygon"),
        ({"action_type": "halt"}, "'Near.action_type' is 'halt'; valid: stop, slowdown, limit"),
        ({"type": "polygon"}, "'Near': a zone of type polygon needs points"),
        ({"type": "circle"}, "'Near': a zone of type circle needs a radius or polygon_sub_topic"),
        ({"type": "velocity_polygon"}, "'Near': a zone of type velocity_polygon needs velocity_p"),
        ({"type": "velocity_polygon", "velocity_polygons": ["ahead"]}, "'ahead.points': "),
    ],
)
def test_an_unknown_zone_is_refused(zone: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        load(MonitorConfig, {"polygons": ["Near"], "Near": zone})


CROSSING = np.full((8, 2), (0.0, 0.8))  # velocities of what comes from the right


def judge_moving(velocity: Velocity, points: Any, motions: Any, **parameters: Any) -> Verdict:
    return made(parameters).judge(velocity, Sight.of(points, motions), ROBOT)


def test_it_slows_down_for_what_will_cross_its_path() -> None:
    someone = cluster(0.6, -0.9)
    assert judge_moving(FORWARD, someone, np.zeros((8, 2))) == Verdict(FORWARD)
    verdict = judge_moving(FORWARD, someone, CROSSING)
    assert verdict.action is Action.APPROACH
    assert verdict.velocity.x < 0.3


def test_it_drives_on_where_what_moves_goes_away_or_behind_it() -> None:
    for at, motion in (((0.6, -0.9), -CROSSING), ((-1.2, -0.9), CROSSING)):
        assert judge_moving(FORWARD, cluster(*at), motion) == Verdict(FORWARD)


def test_it_drives_away_from_what_comes_after_it_and_stands_before_what_comes_at_it() -> None:
    after = np.full((8, 2), (0.6, 0.0))
    assert judge_moving(FORWARD, cluster(-0.9, 0.0), after) == Verdict(FORWARD)
    assert judge_moving(FORWARD, cluster(1.2, 0.0), -after).velocity == Velocity()


@pytest.mark.parametrize(("v", "x", "y"), [(0.0, 0.3, 0.6), (0.3, 0.7, 0.5)])
def test_a_long_nose_turns_away_from_who_comes_and_not_to_him(v: float, x: float, y: float) -> None:
    nose = Footprint.polygon(np.array([[0.6, 0.1], [0.6, -0.1], [-0.2, -0.1], [-0.2, 0.1]]))
    monitor, coming = made({}), np.full((8, 2), (0.0, -0.3))
    to_him, away = Velocity(v, yaw_rate=0.8), Velocity(v, yaw_rate=-0.8)
    assert monitor.judge(to_him, Sight.of(cluster(x, y), coming), nose).velocity == Velocity()
    assert monitor.judge(away, Sight.of(cluster(x, y), coming), nose) == Verdict(away)


@pytest.mark.parametrize("w", [1.2, -1.2])
def test_a_long_nose_is_not_swung_into_who_strolls_beside_it(w: float) -> None:
    nose = Footprint.polygon(np.array([[0.9, 0.1], [0.9, -0.1], [-0.2, -0.1], [-0.2, 0.1]]))
    beside = cluster(0.6, 0.7 if w > 0.0 else -0.7)
    strolling = np.full((8, 2), (0.2, 0.0))
    monitor, turning = made({}), Velocity(yaw_rate=w)
    assert abs(monitor.judge(turning, Sight.of(beside, strolling), nose).velocity.yaw_rate) < abs(w)
    assert monitor.judge(turning, Sight.of(2.0 * beside, strolling), nose) == Verdict(turning)


def test_what_moves_counts_as_standing_where_it_is_not_to_be_looked_ahead() -> None:
    off = {"FootprintApproach.moving_time": 0.0}
    assert judge_moving(FORWARD, cluster(0.6, -0.9), CROSSING, **off) == Verdict(FORWARD)
    near = {"FootprintApproach.moving_time": 0.9}
    assert judge_moving(FORWARD, cluster(0.5, -0.6), CROSSING, **near) != Verdict(FORWARD)


BRAKES = ApproachConfig()  # as the shipped zone brakes
STRAY = np.full((8, 2), (0.0, 1.0))  # who walks past, and may turn


@pytest.mark.parametrize("gap", [0.12, 0.3, 0.5, 0.8])
def test_it_can_be_at_rest_before_who_walks_past_turns_to_it(gap: float) -> None:
    verdict = judge_moving(FORWARD, cluster(0.25 + gap, 0.0), STRAY)
    speed = verdict.velocity.x
    assert gap >= speed / BRAKES.deceleration * (1.0 + 0.5 * speed)
    assert speed == pytest.approx(0.4) or speed > 0.4 * (gap - 0.2)


def test_who_turns_about_is_reckoned_with_as_fast_as_before() -> None:
    monitor, turning = made({}), Velocity(yaw_rate=1.0)
    points, slow = cluster(0.0, 0.55), np.full((8, 2), (0.0, 0.1))
    allowed = [
        monitor.judge(turning, Sight.of(points, slow, np.full(8, speed)), ROBOT).velocity.yaw_rate
        for speed in (0.1, 1.2)
    ]
    assert allowed[0] == 1.0
    assert allowed[1] < 0.5


@pytest.mark.parametrize(("gap", "turns"), [(0.05, False), (0.3, False), (1.6, True)])
def test_it_turns_no_faster_than_it_can_stop_beside_people(gap: float, turns: bool) -> None:
    turning = Velocity(yaw_rate=1.6)
    verdict = judge_moving(turning, cluster(0.0, 0.25 + gap), -STRAY)
    assert (verdict == Verdict(turning)) is turns
    seconds = verdict.velocity.yaw_rate / BRAKES.angular_deceleration
    assert 1.0 * seconds <= max(gap - 0.1, 0.0) or turns


@pytest.mark.parametrize("velocity", [Velocity(5e-324), Velocity(yaw_rate=-1e-310)])
def test_next_to_no_velocity_is_allowed(velocity: Velocity) -> None:
    assert judge_moving(velocity, cluster(0.35, 0.0), STRAY) == Verdict(velocity)


def test_it_leaves_who_touches_it_and_presses_on_nobody() -> None:
    touching = cluster(0.24, 0.0)
    assert judge_moving(FORWARD, touching, STRAY).velocity == Velocity()
    assert judge_moving(Velocity(yaw_rate=0.5), touching, STRAY).velocity == Velocity()
    back = Velocity(-0.3)
    assert judge_moving(back, touching, STRAY) == Verdict(back)


def test_it_turns_on_while_somebody_yet_far_walks_up_to_it() -> None:
    turning, someone = Velocity(yaw_rate=0.3), cluster(1.2, 0.0)
    verdict = judge_moving(turning, someone, np.full((8, 2), (-0.9, 0.0)))
    assert verdict == Verdict(turning)


@pytest.mark.parametrize(("speed", "held"), [(0.0, False), (1.0, True)])
def test_it_turns_slowly_beside_newcomers_of_unknown_motion(speed: float, held: bool) -> None:
    turning, someone = Velocity(yaw_rate=1.6), cluster(0.0, 0.6)
    monitor = made({})
    unknown = np.zeros((8, 2))
    verdict = monitor.judge(turning, Sight.of(someone, unknown, np.full(8, speed)), ROBOT)
    assert (verdict.velocity.yaw_rate < 0.8) is held


def test_it_reckons_that_who_walks_away_may_turn_about() -> None:
    turning, someone = Velocity(yaw_rate=1.6), cluster(0.0, 0.45)
    away, far = np.full((8, 2), (0.0, 1.0)), cluster(0.0, 1.2)
    assert judge_moving(turning, someone, away).velocity.yaw_rate < 0.8
    assert judge_moving(turning, far, away) == Verdict(turning)
