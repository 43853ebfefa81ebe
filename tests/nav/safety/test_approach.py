"""The approach zone against its definition: what meets the outline when, and what can be braked."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.safety.approach import Approach, ApproachConfig
from arjuna_nav.safety.sight import Sight, Touching

CONFIG = ApproachConfig(
    leave_obstacles=True,
    time_before_collision=1.0,
    simulation_time_step=0.1,
    moving_time=1.5,
    deceleration=2.0,
    angular_deceleration=3.0,
)
LEAST = 2  # points that are a collision
CIRCLE = Footprint.circle(0.3)
BOX = Footprint.polygon(np.array([[0.4, 0.2], [0.4, -0.2], [-0.2, -0.2], [-0.2, 0.2]]))
Points = NDArray[np.float64]


def inside(points: Points, outline: Footprint, grown: float = 0.0) -> NDArray[np.bool_]:
    """Return which points lie in an outline that is grown about its middle by a share."""
    if outline is CIRCLE:
        return np.asarray(np.hypot(*points.T) <= 0.3 * (1.0 + grown))
    x, y = (points - (0.1, 0.0)).T / (1.0 + grown)
    return np.asarray((np.abs(x) <= 0.3) & (np.abs(y) <= 0.2))


def seen_after(velocity: Velocity, points: Points, time: float) -> Points:
    """Return points as the robot sees them after a time [s]."""
    return (
        SE2.exp((velocity.x * time, velocity.y * time, velocity.yaw_rate * time))
        .inverse()
        .apply(points)
    )


@pytest.mark.parametrize("outline", [CIRCLE, BOX])
@pytest.mark.parametrize("seed", range(10))
def test_as_long_as_nothing_that_stands_is_met(outline: Footprint, seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1.2, 1.2, (12, 2))
    points = points[~inside(points, outline)]  # its own parts are another test's
    x, y, turn = (rng.uniform((-0.6, -0.6, -1.5), (0.8, 0.6, 1.5)) * (1.0, seed % 2, 1.0)).tolist()
    velocity, free = Velocity(x, y=y, yaw_rate=turn), 1.0
    for k in range(1, 10):
        if inside(seen_after(velocity, points, 0.1 * k), outline).sum() >= 2:
            free = 0.1 * (k - 1)
            break
    allowed = Approach(CONFIG, LEAST).allowed(velocity, Sight.of(points), outline)
    assert allowed == pytest.approx(free)


@pytest.mark.parametrize("axle", [-0.5, 0.2])
@pytest.mark.parametrize("seed", range(4))
def test_a_base_off_its_axle_is_slowed_as_one_at_it(axle: float, seed: int) -> None:
    rng, ahead = np.random.default_rng(seed), np.array([axle, 0.0])
    points = rng.uniform(-1.2, 1.2, (12, 2))
    points = points[~inside(points, BOX)]
    velocity = Velocity(float(rng.uniform(-0.6, 0.8)), yaw_rate=float(rng.uniform(-1.5, 1.5)))
    outline = Footprint.polygon(BOX.points + ahead).driven_at(axle)
    zone = Approach(CONFIG, LEAST)
    allowed = zone.allowed(velocity, Sight.of(points + ahead), outline)
    assert allowed == pytest.approx(zone.allowed(velocity, Sight.of(points), BOX))


@pytest.mark.parametrize(("x", "allowed"), [(0.39, 0.0), (0.41, 0.1), (1.19, 0.8), (1.21, 1.0)])
def test_the_last_step_looked_at_is_before_the_time_is_over(x: float, allowed: float) -> None:
    ahead = np.array([[x, 0.0], [x, 0.001]])
    assert Approach(CONFIG, LEAST).allowed(Velocity(1.0), Sight.of(ahead), CIRCLE) == pytest.approx(
        allowed
    )
    assert Approach(CONFIG, LEAST).allowed(Velocity(1.0), Sight.of(ahead[:1]), CIRCLE) == 1.0, (
        "noise"
    )
    assert Approach(CONFIG, LEAST).allowed(Velocity(), Sight.of(0.0 * ahead), CIRCLE) == 1.0, (
        "it stands"
    )


def test_a_robot_that_brakes_slowly_is_slowed_as_much_sooner() -> None:
    """At 1 m/s and 0.4 m/s^2 it takes 1.25 m to stand: 1.35 s with the reaction."""
    ahead = np.array([[1.45, 0.0], [1.45, 0.001]])
    slow = Approach(replace(CONFIG, deceleration=0.4), LEAST)
    assert Approach(CONFIG, LEAST).allowed(Velocity(1.0), Sight.of(ahead), CIRCLE) == 1.0
    assert slow.allowed(Velocity(1.0), Sight.of(ahead), CIRCLE) == pytest.approx(1.1 / 1.35)


@pytest.mark.parametrize("config", [CONFIG, replace(CONFIG, leave_obstacles=False)])
def test_no_velocity_is_looked_ahead_at_for_long(
    config: ApproachConfig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A robot of 1e9 m/s brakes for years: a client's message held up all of navigation."""
    looked: list[Points] = []
    holds = Footprint.holds

    def counted(outline: Footprint, points: Points) -> NDArray[np.bool_]:
        looked.append(points)
        assert len(looked) < 3000
        return holds(outline, points)

    monkeypatch.setattr(Footprint, "holds", counted)
    behind = Sight.of(np.tile([-0.6, 0.0], (LEAST, 1)))
    for velocity in (Velocity(1e9), Velocity(0.1, yaw_rate=1e9)):
        for finest in (config.simulation_time_step, 0.001):
            zone = replace(config, simulation_time_step=finest, moving_time=0.0)
            Approach(zone, LEAST).allowed(velocity, behind, BOX)


@pytest.mark.parametrize(
    ("touching", "ahead", "allowed"),
    [
        (0.28, 0.64, 0.3),  # the outline is taken a little smaller
        (0.16, 0.64, 0.4),  # or half as large
        (0.1, 0.64, 0.3),  # or what is within left away
        (0.28, 3.0, 0.0),  # towards what touches it
    ],
)
def test_touching_obstacles_release_it(touching: float, ahead: float, allowed: float) -> None:
    side = 1.0 if ahead > 1.0 else -1.0
    points = np.array(
        [[side * touching, 0.0], [side * touching, 0.001], [ahead, 0.0], [ahead, 0.001]]
    )
    assert Approach(CONFIG, LEAST).allowed(
        Velocity(1.0), Sight.of(points), CIRCLE
    ) == pytest.approx(allowed)


BRAKES_ALONE = replace(CONFIG, simulation_time_step=10.0)  # by the one time looked at, all are far


def moving(
    velocity: Velocity,
    at: tuple[float, float],
    motion: tuple[float, float],
    outline: Footprint = CIRCLE,
    config: ApproachConfig = CONFIG,
) -> float:
    """Return what is allowed before one point that moves."""
    zone = Approach(config, LEAST)
    return zone.allowed(velocity, Sight.of(np.array([at]), np.array([motion])), outline)


@pytest.mark.parametrize("speed", [0.3, 0.9])
@pytest.mark.parametrize("gap", [0.25, 0.35, 0.5])
def test_it_can_be_at_rest_before_who_walks_past_turns_to_it(speed: float, gap: float) -> None:
    part = moving(Velocity(0.8), (0.3 + gap, 0.0), (0.0, speed), config=BRAKES_ALONE)
    braking = part * 0.8 / 2.0  # [s]
    driven = 0.5 * part * 0.8 * braking  # the robot's
    walked = speed * (0.1 + braking)  # a tenth of a second passes before it brakes
    room = gap - 0.1 - driven - walked
    assert room == pytest.approx(0.0, abs=1e-9) if part < 1.0 else room >= 0.0


def test_it_can_stop_turning_before_who_walks_past_turns_to_it() -> None:
    part = moving(Velocity(yaw_rate=1.5), (0.0, 0.5), (0.6, 0.0), config=BRAKES_ALONE)
    braking = part * 1.5 / 3.0
    assert 0.5 * part * 1.5 * 0.3 * braking + 0.6 * (0.1 + braking) == pytest.approx(0.1)


@pytest.mark.parametrize("away", [1.0, 0.9, 0.5, 0.7, 0.0, -1.0])
def test_who_walks_away_may_come_back_as_fast(away: float) -> None:
    motion = (0.6 * away, 0.6 * math.sqrt(1.0 - away**2))
    part = moving(Velocity(0.8), (0.65, 0.0), motion, config=BRAKES_ALONE)
    braking = part * 0.8 / 2.0
    met = 0.5 * part * 0.8 * braking + 0.6 * (0.1 + braking)
    assert met == pytest.approx(0.25)


@pytest.mark.parametrize("seed", range(40))
def test_the_first_part_of_the_velocity_that_meets_nobody_is_kept(seed: int) -> None:
    rng = np.random.default_rng(seed)
    outline = (CIRCLE, BOX)[seed % 2]
    x, y, turn = rng.uniform((-0.4, -0.6, -1.0), (0.8, 0.6, 1.0)).tolist()
    velocity = Velocity(x, y=y * (seed % 4 > 1), yaw_rate=turn)
    at = rng.uniform(-1.5, 1.5, 2)
    motion = rng.uniform(-0.8, 0.8, 2)
    gap = float(outline.gaps(at[None])[0][0])
    if gap <= 0.1:
        return
    parts, met = (1.0, 0.7, 0.4, 0.2, 0.0), []
    for part in parts:
        slower = velocity.scaled(part)
        times = [
            0.1 * k
            for k in range(1, 16)
            if inside(
                seen_after(slower, (at + 0.1 * k * motion)[None], 0.1 * k),
                outline,
                grown=0.1 / outline.inscribed_radius,
            ).any()
        ]
        met.append(times[0] if times else math.inf)
    free = next((p for p, time in zip(parts, met, strict=True) if time == math.inf), None)
    if free is None:  # met at rest too: it goes on where that is no sooner
        free = 1.0 if met[0] >= met[-1] else 0.0
    brakes = replace(CONFIG, deceleration=1e4, angular_deceleration=1e4)  # so the paths alone count
    allowed = moving(velocity, (at[0], at[1]), (motion[0], motion[1]), outline, brakes)
    assert allowed == pytest.approx(free)


@pytest.mark.parametrize(
    ("at", "motion", "later"),
    [
        ((1.0, 0.0), (-0.5, 0.5), (0.95, 0.05)),  # comes nearer
        ((1.0, 0.0), (0.5, 0.5), (1.0, 0.0)),  # goes away, and may have turned about since
        ((0.0, -1.0), (0.0, 0.5), (0.0, -0.95)),
        ((0.0, -1.0), (0.5, 0.0), (0.0, -1.0)),
    ],
)
def test_a_moment_later_nobody_is_taken_for_farther_than_he_was_seen(
    at: tuple[float, float], motion: tuple[float, float], later: tuple[float, float]
) -> None:
    sight = Sight.of(np.array([at]), np.array([motion])).later(0.1)
    assert sight.points[0] == pytest.approx(later)
    assert sight.motions[0] == pytest.approx(motion)


def test_who_touches_it_is_not_pressed_on_and_may_be_left() -> None:
    assert moving(Velocity(0.5), (0.29, 0.0), (0.0, 0.5)) == 0.0
    assert moving(Velocity(-0.5), (0.29, 0.0), (0.0, 0.5)) == 1.0


def test_who_came_into_the_outline_moves_for_a_while_though_nothing_is_seen_to() -> None:
    points = np.array([[0.1, 0.2], [0.0, 0.4]])
    comes = Sight.of(points, speeds=np.array([0.6, 0.8]))
    stands, touching = Sight.of(points), Touching()
    assert not touching.keep(stands, CIRCLE, 0.0).speeds.any(), "nobody has come"
    assert touching.keep(comes, CIRCLE, 1.0).speeds == pytest.approx((0.6, 0.8))
    for now, speed in ((1.1, 0.6), (2.4, 0.6), (2.6, 0.0)):
        assert touching.keep(stands, CIRCLE, now).speeds == pytest.approx((speed, 0.0))


def test_what_cannot_come_near_in_time_and_what_stands_is_not_looked_at() -> None:
    reach = 1.5 * (0.6 + 0.5) + 0.1
    assert moving(Velocity(0.5), (0.3 + reach + 0.01, 0.0), (-0.6, 0.0)) == 1.0
    assert moving(Velocity(0.5), (0.3 + reach - 0.01, 0.0), (-0.6, 0.0)) == 0.7
    assert moving(Velocity(0.5), (0.6, 0.0), (0.0, 0.0)) == 1.0
    assert (
        moving(Velocity(0.5), (0.6, 0.0), (-0.6, 0.0), config=replace(CONFIG, moving_time=0.0))
        == 1.0
    )
