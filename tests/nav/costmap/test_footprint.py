"""Footprints, windows of costmaps and the rays that clear them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.config import load
from arjuna_core.errors import ConfigError
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.motion import rollout
from arjuna_nav.costmap.collision import collides, first_collision
from arjuna_nav.costmap.config import CostmapConfig
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.raytrace import enter_scan
from arjuna_nav.costmap.window import Window, clipped, grown, joined, seen_in, whole, within
from tests.nav.worlds import block, costmap_of, empty_grid, grid_of

BODY = np.array([[0.225, 0.19], [-0.225, 0.19], [-0.225, -0.19], [0.225, -0.19]])


def test_radii_of_a_polygon_with_padding() -> None:
    footprint = Footprint.polygon(BODY, padding=0.01)
    assert footprint.inscribed_radius == pytest.approx(0.20)
    assert footprint.circumscribed_radius == pytest.approx(math.hypot(0.235, 0.20))


def test_a_circle_s_corners_lie_all_round_it() -> None:
    points = Footprint.circle(0.25).points
    assert np.hypot(*points.T) == pytest.approx(np.full(len(points), 0.25))
    assert points.mean(axis=0) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert len(np.unique(points.round(6), axis=0)) == len(points)


def test_a_bent_outline_holds_what_lies_in_it() -> None:
    bent = Footprint.polygon(np.array([[1, 1], [-1, 1], [-1, -1], [0, -1], [0, 0], [1, 0]], float))
    points = np.random.default_rng(3).uniform(-1.5, 1.5, (500, 2))
    x, y = points.T
    inside = (np.abs(x) < 1.0) & (np.abs(y) < 1.0) & ~((x > 0.0) & (y < 0.0))
    assert (bent.holds(points) == inside).all()


def test_padding_leaves_a_corner_on_an_axis_there() -> None:
    kite = np.array([[0.4, 0.0], [0.0, 0.2], [-0.3, 0.0], [0.0, -0.2]])
    padded = Footprint.polygon(kite, padding=0.05).points
    assert padded == pytest.approx(np.array([[0.45, 0.0], [0.0, 0.25], [-0.35, 0.0], [0.0, -0.25]]))


def test_parses_nav2s_parameters() -> None:
    circle = Footprint.parse("[]", 0.25, 0.03)
    assert circle.circular
    assert circle.inscribed_radius == pytest.approx(0.28)
    square = Footprint.parse("[[0.1, 0.1], [-0.1, 0.1], [-0.1, -0.1], [0.1, -0.1]]", 9.0, 0.0)
    assert not square.circular
    assert square.inscribed_radius == pytest.approx(0.1)
    assert Footprint.parse("[]", 0.0, -0.01).inscribed_radius == pytest.approx(1e-3)


@pytest.mark.parametrize(
    "text",
    ["[[0.1,0.1][-.1,0.1][-1e-1,-0.1][0.1,-0.1],]", "[ [.1 .1]\n [-.1 .1] [-.1 -.1] [.1 -.1] ]"],
)
def test_commas_may_be_left_out(text: str) -> None:
    corners = [[0.1, 0.1], [-0.1, 0.1], [-0.1, -0.1], [0.1, -0.1]]
    assert Footprint.parse(text, 9.0, 0.0).points.tolist() == corners


@pytest.mark.parametrize("text", ["[[0.1, 0.1], [0.2]]", "[[a, b]]", "[", "[[0, 0], [1, 1]]"])
def test_refuses_what_is_no_footprint(text: str) -> None:
    with pytest.raises(ConfigError, match=r"valid: '\[\[x, y\]|at least three corners"):
        Footprint.parse(text, 0.25, 0.0)
    with pytest.raises(ConfigError, match=r"valid: '\[\[x, y\]|at least three corners"):
        load(CostmapConfig, {"body": text})
    with pytest.raises(ConfigError, match="at least three corners"):
        Footprint.polygon(np.ones((4, 3)))


@pytest.mark.parametrize(("x", "padding"), [(20.01, 0.0), (-1e7, 0.0), (19.9, 0.2)])
def test_refuses_an_outline_that_no_robot_has(x: float, padding: float) -> None:
    corners = np.array([[x, 0.0], [0.0, 1.0], [0.0, -1.0]])
    with pytest.raises(ConfigError, match=r"a footprint reaches .* m; valid: up to 20 m"):
        Footprint.polygon(corners, padding)
    Footprint.polygon(np.array([[20.0, 0.0], [0.0, 1.0], [0.0, -1.0]]))


def test_refuses_a_robot_without_size() -> None:
    with pytest.raises(ConfigError, match="must be positive, got 0"):
        Footprint.circle(0.0)


def test_a_polygon_fits_lengthwise_where_it_does_not_fit_across() -> None:
    grid = empty_grid(3.0, 3.0)
    block(grid, 0.0, 1.75, 3.0, 0.1)
    block(grid, 0.0, 1.15, 3.0, 0.1)  # a corridor 0.5 m wide about y = 1.5
    text = "[[0.4, 0.15], [-0.4, 0.15], [-0.4, -0.15], [0.4, -0.15]]"
    slim, costmap = Footprint.parse(text, 0.0, 0.0), costmap_of(grid, footprint=text)
    assert not collides(costmap, slim, SE2(1.5, 1.5, 0.0))
    assert collides(costmap, slim, SE2(1.5, 1.5, math.pi / 2))


@pytest.mark.parametrize("origin", [SE2(), SE2(-3.0, 2.0, 0.6)])
def test_leaving_the_grid_collides_wherever_the_grid_lies(origin: SE2) -> None:
    costmap = costmap_of(empty_grid(3.0, 3.0, origin))
    footprint = Footprint.circle(0.25)
    assert not collides(costmap, footprint, origin @ SE2(1.5, 1.5))
    assert collides(costmap, footprint, origin @ SE2(3.2, 1.5))


def test_a_robot_too_near_to_a_wall_may_leave_but_not_press_on() -> None:
    costmap, footprint = costmap_of(grid_of(3.0, 3.0, (2.0, 0.0, 0.1, 3.0))), Footprint.circle(0.25)
    pose = SE2(1.85, 1.5, 0.0)
    assert collides(costmap, footprint, pose)
    back = rollout(pose, Velocity(-0.2), 3.0, 0.05)
    ahead = rollout(pose, Velocity(0.2), 1.0, 0.05)
    turn = rollout(pose, Velocity(yaw_rate=0.5), 3.0, 0.05)
    assert first_collision(costmap, footprint, back) is None
    assert first_collision(costmap, footprint, turn) is None
    assert first_collision(costmap, footprint, ahead) == 1


def test_a_robot_that_left_an_obstacle_may_not_come_back() -> None:
    grid = grid_of(4.0, 3.0, (2.0, 0.0, 0.1, 3.0), (0.2, 0.0, 0.1, 3.0))
    costmap, footprint = costmap_of(grid), Footprint.circle(0.25)
    through = rollout(SE2(1.85, 1.5, 0.0), Velocity(-0.5), 4.0, 0.05)
    hit = first_collision(costmap, footprint, through)
    assert hit is not None
    assert through[hit, 0] == pytest.approx(0.275 + 0.25, abs=0.06)


def test_rollout_is_exact() -> None:
    arc = rollout(SE2(1.0, 2.0, 0.3), Velocity(0.4, yaw_rate=0.5), 2.0, 0.05)
    exact = SE2(1.0, 2.0, 0.3) @ SE2.exp(np.array([0.8, 0.0, 1.0]))
    np.testing.assert_allclose(arc[-1], exact.array(), atol=1e-12)
    assert np.hypot(*np.diff(arc[:, :2], axis=0).T).max() <= 0.05


@pytest.mark.parametrize(
    "velocity", [Velocity(yaw_rate=1e9), Velocity(1e9), Velocity(1e9, yaw_rate=-1e9)]
)
def test_rollout_is_no_longer_than_a_round_however_fast(velocity: Velocity) -> None:
    arc = rollout(SE2(), velocity, 1e3, 0.05)
    assert 1 < len(arc) <= 10_001
    assert abs(arc[-1, 2]) <= 2.0 * math.pi + 1e-6


@pytest.mark.parametrize("outline", [Footprint.circle(0.3), Footprint.polygon(BODY)])
def test_gaps_and_directions_lead_from_the_outline_to_points(outline: Footprint) -> None:
    points = np.array([[1.0, 0.1], [-0.5, -0.9], [0.1, 0.05], [0.0, 0.4]])
    gaps, away = outline.gaps(points)
    assert (gaps > 0.0).tolist() == [True, True, False, True]
    assert np.hypot(*away.T) == pytest.approx(1.0)
    nudge = 1e-4 * away
    assert outline.gaps(points + nudge)[0] == pytest.approx(gaps + 1e-4, abs=1e-7)
    on_it = points - (gaps + 1e-6)[:, None] * away
    assert outline.holds(on_it).all()
    assert not outline.holds(on_it + 4e-6 * away).any() or outline.circular


def test_a_body_stands_out_of_an_outline_by_its_corners() -> None:
    body = Footprint.polygon(BODY)
    assert Footprint.polygon(BODY, 0.02).outreach(body) == 0.0
    assert body.outreach(body) == 0.0
    out = body.circumscribed_radius - 0.2
    assert Footprint.circle(0.2).outreach(body) == pytest.approx(out)
    assert Footprint.circle(body.circumscribed_radius).outreach(body) == 0.0


def test_a_body_larger_than_a_costmap_s_outline_is_traced_all_the_same() -> None:
    costmap, pose = costmap_of(grid_of(4.0, 4.0, (2.2, 1.0, 0.2, 2.0)), radius=0.15), SE2(2.0, 2.0)
    assert not collides(costmap, Footprint.circle(0.15), pose)
    assert not collides(costmap, Footprint.polygon(BODY), pose @ SE2(theta=0.5 * math.pi))
    assert collides(costmap, Footprint.polygon(BODY), pose)


def test_a_robot_may_be_a_triangle_and_no_line() -> None:
    wedge = Footprint.polygon(np.array([[0.4, 0.0], [-0.2, 0.3], [-0.2, -0.3]]))
    assert wedge.inscribed_radius == pytest.approx(0.4 * 0.3 / math.hypot(0.6, 0.3))
    assert (len(wedge.points), wedge.circumscribed_radius) == (3, 0.4)
    with pytest.raises(ConfigError, match="at least three corners"):
        Footprint.polygon(wedge.points[:2])


@pytest.mark.parametrize("outline", [Footprint.circle(0.3, 0.02), Footprint.polygon(BODY, 0.02)])
def test_padding_is_taken_off_again_and_a_size_is_scaled(outline: Footprint) -> None:
    bare, twice = outline.without(0.02), outline.scaled(2.0)
    plain = Footprint.circle(0.3) if outline.circular else Footprint.polygon(BODY)
    assert bare.points == pytest.approx(plain.points)
    assert bare.circular is twice.circular is outline.circular
    assert bare.inscribed_radius == pytest.approx(plain.inscribed_radius)
    assert twice.points == pytest.approx(2.0 * outline.points)
    assert twice.inscribed_radius == 2.0 * outline.inscribed_radius
    assert twice.circumscribed_radius == 2.0 * outline.circumscribed_radius
    assert Footprint.circle(0.02).without(0.05).inscribed_radius == 1e-3, "never nothing"


BOX = [[0.5, 0.25], [0.5, -0.25], [-0.5, -0.25], [-0.5, 0.25]]
SHAPE = (5, 7)
ALL = {(r, c) for r in range(5) for c in range(7)}


def cells(window: Window | None) -> set[tuple[int, int]]:
    if window is None:
        return set()
    rows, columns = window
    return {
        (r, c) for r in range(rows.start, rows.stop) for c in range(columns.start, columns.stop)
    }


def test_clipping_and_growing_keep_to_the_grid() -> None:
    for seed in range(60):
        r0, r1, c0, c1, by = (int(n) for n in np.random.default_rng(seed).integers(-3, 11, 5))
        window = clipped(r0, r1, c0, c1, SHAPE)
        assert cells(window) == {(r, c) for r, c in ALL if r0 <= r < r1 and c0 <= c < c1}
        rows, columns = window  # not below 0, from where numpy counts from the end
        assert all(0 <= n <= 5 for n in (rows.start, rows.stop))
        assert all(0 <= n <= 7 for n in (columns.start, columns.stop))
        if by >= 0 and cells(window):
            inside = {
                (r, c)
                for r, c in ALL
                if rows.start - by <= r < rows.stop + by
                and columns.start - by <= c < columns.stop + by
            }
            assert cells(grown(window, by, SHAPE)) == inside
    assert cells(whole(SHAPE)) == ALL


A, B = (slice(1, 3), slice(2, 6)), (slice(2, 5), slice(0, 3))


def test_two_windows_join_to_the_least_that_holds_both() -> None:
    assert joined(A, B) == joined(B, A) == (slice(1, 5), slice(0, 6))
    assert joined(A, None) == joined(None, A) == A
    assert joined(None, None) is None


def test_a_window_is_seen_in_another() -> None:
    grid = np.arange(35).reshape(SHAPE)
    outer = (slice(1, 5), slice(1, 7))
    np.testing.assert_array_equal(grid[outer][seen_in(A, outer)], grid[A])


@pytest.mark.parametrize("seed", range(6))
def test_the_least_window_of_what_has_changed(seed: int) -> None:
    changed = np.random.default_rng(seed).random((3, 4)) < 0.15
    found = within((slice(1, 4), slice(2, 6)), changed)
    cells = {(1 + int(r), 2 + int(c)) for r, c in np.argwhere(changed)}
    assert (found is None) == (not cells)
    if found is not None:
        rows, columns = [r for r, _ in cells], [c for _, c in cells]
        assert found == (
            slice(min(rows), max(rows) + 1),
            slice(min(columns), max(columns) + 1),
        )


@pytest.mark.parametrize("seed", range(4))
def test_a_part_of_a_grid_is_cleared_and_marked_as_in_the_whole(seed: int) -> None:
    rng = np.random.default_rng(seed)
    whole = rng.integers(1, 255, (160, 180)).astype(np.uint8)
    part = whole[50:110, 60:140].copy()
    hits, hits_part = np.zeros(whole.shape, np.uint32), np.zeros(part.shape, np.uint32)
    sensor = np.array([rng.uniform(62.0, 138.0), rng.uniform(52.0, 108.0), rng.uniform(-3.0, 3.0)])
    ranges = rng.uniform(1.0, 48.0, 200)
    ranges[::17], ranges[::29] = math.inf, math.nan
    bearings = np.linspace(-math.pi, math.pi, 200)
    limits = np.array([2.0, 50.0, float(seed % 2), 40.0, 45.0, 0.0, 44.0])
    enter_scan(whole, hits, sensor, ranges, bearings, limits, True, True)
    moved = sensor - (60.0, 50.0, 0.0)
    enter_scan(part, hits_part, moved, ranges, bearings, limits, True, True)
    np.testing.assert_array_equal(part, whole[50:110, 60:140])
    np.testing.assert_array_equal(hits_part > 0, hits[50:110, 60:140] > 0)
    assert (part == 0).any()


@pytest.mark.parametrize("axle", [-0.3, 0.1, 1.0])
@pytest.mark.parametrize("text", ["[[0.4, 0.15], [-0.4, 0.15], [-0.4, -0.15], [0.4, -0.15]]", "[]"])
def test_an_outline_driven_at_another_point_holds_for_both(text: str, axle: float) -> None:
    own = Footprint.parse(text, 0.3, 0.0)
    for driven in (own.driven_at(axle), own.driven_at(axle).scaled(2.0).scaled(0.5)):
        seen, pose = driven.of_axle, SE2(1.0, 2.0, 0.5)
        assert (driven.axle, seen.axle) == (axle, 0.0)
        assert (pose @ SE2(axle)).apply(seen.points) == pytest.approx(pose.apply(own.points))
        for outline in (driven, seen):
            far = np.hypot(*outline.points.T).max()
            assert far <= outline.circumscribed_radius + 1e-9
            assert outline.inscribed_radius <= own.inscribed_radius + 1e-9
    bare = Footprint.parse(text, 0.3, 0.05, axle).without(0.05)
    assert bare.axle == axle
    assert own.circular or bare.points == pytest.approx(own.points)


@pytest.mark.parametrize("axle", [0.0, -0.48])
@pytest.mark.parametrize("middle", [0.0, 0.3, 0.5, 2.0])
@pytest.mark.parametrize("margin", [-0.1, -0.03, 0.0, 0.05])
def test_an_outline_is_widened_about_its_own_middle(
    margin: float, middle: float, axle: float
) -> None:
    """Of a car driven at its rear axle the cells below the bonnet stayed: it saw it, and stood."""
    outline = Footprint.polygon(np.add(BOX, (middle, 0.0))).driven_at(axle)
    wide = outline.widened(margin)
    (x, y), (low, _) = wide.points.max(axis=0), wide.points.min(axis=0)
    assert y - 0.25 == pytest.approx(margin)
    assert (x + low) / 2.0 == pytest.approx(middle)
    assert (x - low) / 2.0 - 0.5 == pytest.approx(2.0 * margin), "as much of its length"
    assert wide.axle == axle
    least = outline.widened(-9.0, least=0.5)
    assert np.ptp(least.points, axis=0) == pytest.approx((0.5, 0.25))
    assert Footprint.circle(0.3).widened(-0.1).inscribed_radius == pytest.approx(0.2)
