"""Things that move in scans: found with their speed, apart from what only seems to move."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame
from arjuna_core.scan import Cloud
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import LETHAL, LayeredCostmap, PlacedCloud, PlacedScan
from arjuna_nav.costmap.layers.voxel import VoxelLayer
from arjuna_nav.costmap.moving.sightings import free_standing
from arjuna_nav.costmap.moving.tracker import REACH, Moving, Tracker
from arjuna_nav.costmap.moving.trails import path_costs
from tests.helpers.nav.layers import SCAN, clouds, costmap_config, scans, see
from tests.helpers.nav.played import scan_of

ROOM = np.array([[-4.0, -4, 4, -4], [4, -4, 4, 4], [4, 4, -4, 4], [-4, 4, -4, -4]])
BOX = np.array([[1.5, -0.3], [2.1, -0.3], [2.1, 0.3], [1.5, 0.3]])


def post(x: float, y: float, radius: float = 0.2) -> NDArray[np.float64]:
    """Return the edges of a round thing."""
    turns = np.arange(12) * math.pi / 6.0
    corners = np.array([x, y]) + radius * np.column_stack((np.cos(turns), np.sin(turns)))
    return edges(corners)


def edges(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.hstack((corners, np.roll(corners, -1, axis=0)))


def watch(
    things: Callable[[float], NDArray[np.float64]],
    pose: Callable[[float], SE2],
    duration: float = 1.0,
    every: Callable[[Moving], None] = lambda moving: None,
) -> Moving:
    """Return what moves at the end, seen ten times a second with noise of 1 cm."""
    tracker, rng, moving = Tracker(REACH), np.random.default_rng(1), Moving.nothing()
    for k in range(round(duration * 10) + 1):
        now = 0.1 * k
        walls = np.vstack((ROOM, things(now)))
        moving = tracker.update(scan_of(walls, pose(now), rng, 0.01, now), pose(now))
        every(moving)
    return moving


@pytest.mark.parametrize("drives", [0.0, 0.5])
def test_who_walks_is_found_with_the_speed_and_what_stands_is_not(drives: float) -> None:
    moving = watch(
        lambda t: np.vstack((post(1.5, -0.8 + 0.8 * t), post(-1.5, 0.0))),
        lambda t: SE2(-0.4 + drives * t, 0.0, 0.2 * t),
    )
    flagged = moving.velocities.any(axis=1)
    assert flagged.sum() >= 4
    spots = moving.points[flagged]
    assert np.hypot(spots[:, 0] - 1.5, spots[:, 1]).max() < 0.3
    assert moving.velocities[flagged].mean(axis=0) == pytest.approx((0.0, 0.8), abs=0.2)


def test_a_scan_of_one_beam_is_seen_and_nothing_in_it_moves() -> None:
    """Its increment is 0, as a range finder's."""
    tracker, rng = Tracker(REACH), np.random.default_rng(1)
    for k in range(12):
        scan = scan_of(
            np.vstack((ROOM, post(-1.2, 0.0))), SE2(-0.01 * k, 0.0, 0.0), rng, 0.01, 0.1 * k
        )
        beam = replace(scan, ranges=scan.ranges[:1], angle_increment=0.0)
        moving = tracker.update(beam, SE2(-0.01 * k, 0.0, 0.0))
    assert len(moving.points) == 1
    assert not moving.velocities.any()


def pass_by(every: Callable[[Moving], None]) -> None:
    """Drive past things that stand."""
    things = np.vstack((edges(BOX), post(0.5, 1.2, 0.08), post(1.4, -1.0)))
    watch(lambda t: things, lambda t: SE2(-1.5 + 0.8 * t, -0.2, 0.3 * math.sin(t)), 3.0, every)


def test_what_a_robot_passes_by_does_not_move() -> None:
    flags: list[int] = []
    pass_by(lambda moving: flags.append(int(moving.velocities.any(axis=1).sum())))
    assert max(flags) == 0


@pytest.mark.parametrize(("drives", "turns"), [(0.0, 0.0), (0.4, 0.0), (0.0, 0.8), (0.4, 0.8)])
def test_what_stands_on_the_robot_does_not_move_and_who_comes_to_it_does(
    drives: float, turns: float
) -> None:
    def pose(t: float) -> SE2:
        return SE2(drives * t - 1.5, 0.0, turns * t)

    def around(t: float) -> NDArray[np.float64]:
        T, own = pose(t), post(0.1, 0.15, 0.03)
        who = T.apply(np.array([[0.0, 0.1 * min(t, 2.0) * 7.0 - 2.0]]))[0]
        own = np.hstack((T.apply(own[:, :2]), T.apply(own[:, 2:])))
        return np.vstack((own, post(*who)))

    def keep(moving: Moving) -> None:
        seen = pose(moving.stamp).inverse().apply(moving.points)
        own = np.hypot(*(seen - (0.1, 0.15)).T) < 0.05
        flags.append(int((moving.speeds[own] > 0.0).sum()))
        near = np.hypot(seen[:, 0], seen[:, 1] + 0.6) < 0.25
        comes.append(bool(moving.speeds[near].any()))

    flags: list[int] = []
    comes: list[bool] = []
    watch(around, pose, 2.2, keep)
    assert max(flags) <= 2  # noisy edges
    assert comes[-1]


def test_what_is_seen_between_two_things_does_not_move() -> None:
    flags: list[int] = []
    gap = np.vstack((post(1.0, 0.35, 0.25), post(1.0, -0.35, 0.25)))
    watch(
        lambda t: gap,
        lambda t: SE2(0.0, -0.5 + 0.5 * t),
        2.0,
        lambda moving: flags.append(int(moving.velocities.any(axis=1).sum())),
    )
    assert max(flags) == 0


@pytest.mark.parametrize("seed", [3, 4, 6])
def test_what_comes_in_sight_among_many_things_does_not_move(seed: int) -> None:
    rng = np.random.default_rng(seed)
    spots = rng.uniform(-3.5, 3.5, (60, 2))
    thicket = np.vstack([post(x, y, 0.075) for x, y in spots if abs(y) > 0.5])
    flags: list[int] = []
    watch(
        lambda t: thicket,
        lambda t: SE2(-3.0 + 1.5 * t, 0.0, 0.5 * math.sin(2.0 * t)),
        4.0,
        lambda moving: flags.append(int(moving.velocities.any(axis=1).sum())),
    )
    assert max(flags) == 0


def test_time_that_was_set_back_ends_every_track() -> None:
    tracker, rng = Tracker(REACH), np.random.default_rng(1)
    for k in range(8):
        walls = np.vstack((ROOM, post(1.5, -0.5 + 0.1 * k)))
        moving = tracker.update(scan_of(walls, SE2(), rng, 0.01, 0.1 * k), SE2())
    assert moving.velocities.any()
    moving = tracker.update(scan_of(walls, SE2(), rng, 0.01, 0.0), SE2())
    assert not moving.velocities.any()


def test_who_turns_about_or_is_half_hidden_is_not_lost() -> None:
    tracker, rng = Tracker(REACH), np.random.default_rng(2)
    flags, x = [], 2.0
    for k in range(40):
        x += 0.08 if k >= 20 else -0.08
        hides = post(0.6, -0.35, 0.15) if 12 <= k < 15 else np.zeros((0, 4))
        walls = np.vstack((ROOM, post(x, -0.9), hides))
        moving = tracker.update(scan_of(walls, SE2(), rng, 0.01, 0.1 * k), SE2())
        near = np.hypot(moving.points[:, 0] - x, moving.points[:, 1] + 0.9) < 0.3
        flags.append(moving.velocities[near].any(axis=1).mean() if near.any() else 1.0)
    assert min(flags[6:]) > 0.5


def test_who_turns_about_may_come_as_fast_as_before() -> None:
    tracker, rng = Tracker(REACH), np.random.default_rng(2)
    slowest, least = math.inf, math.inf
    for k in range(24):
        x = 2.2 - 0.1 * min(k, 24 - k)
        walls = np.vstack((ROOM, post(x, -0.9)))
        moving = tracker.update(scan_of(walls, SE2(), rng, 0.01, 0.1 * k), SE2())
        near = np.hypot(moving.points[:, 0] - x, moving.points[:, 1] + 0.9) < 0.3
        if k >= 8:
            slowest = min(slowest, np.hypot(*moving.velocities[near].T).min())
            least = min(least, moving.speeds[near].min())
    assert slowest < 0.5
    assert least > 0.8


def test_a_person_who_stops_may_continue_at_their_pace_for_a_while() -> None:
    paces: list[float] = []

    def keep(moving: Moving) -> None:
        near = np.hypot(moving.points[:, 0] - 1.5, moving.points[:, 1] + 0.9) < 0.3
        paces.append(float(moving.speeds[near].mean()) if near.any() else 0.0)
        things.append(len(moving.things))

    things: list[int] = []
    watch(lambda t: post(max(3.0 - 0.8 * t, 1.5), -0.9), lambda t: SE2(), 7.0, keep)
    assert things[30:] == [0] * 41  # it stands
    assert min(paces[20:45]) > 0.4  # as it slowed down
    assert max(paces[60:]) == 0.0


def test_things_have_their_middle_velocity_and_size() -> None:
    moving = watch(lambda t: post(1.5, -0.8 + 0.8 * t), lambda t: SE2())
    assert moving.things.shape == (1, 5)
    x, y, vx, vy, radius = moving.things[0]
    assert (x, y) == pytest.approx((1.45, 0.0), abs=0.1)
    assert (vx, vy) == pytest.approx((0.0, 0.8), abs=0.2)
    assert radius == pytest.approx(0.2, abs=0.05)


@pytest.mark.parametrize("first", [20, 37])
def test_a_thing_stands_free_where_the_beams_beside_it_reach_farther(first: int) -> None:
    ranges = np.full(40, 3.0)
    ranges[first : first + 3] = 1.0
    angles = np.arange(40) * (2.0 * math.pi / 40)
    points = ranges[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    found = [first, first + 2]
    assert free_standing(points, ranges, True).tolist() == [found]
    assert free_standing(points, ranges, False).tolist() == ([found] if first == 20 else [])
    ranges[first - 1] = 1.1
    assert not len(free_standing(points, ranges, True)), "it may be hidden"


def test_who_steps_out_from_behind_is_known_before_the_speed_is() -> None:
    hides = edges(np.array([[0.8, -1.6], [1.4, -1.6], [1.4, -0.4], [0.8, -0.4]]))
    tracker, rng = Tracker(REACH), np.random.default_rng(3)
    first: dict[str, float] = {}
    for k in range(20):
        y = -1.6 + 0.1 * k
        walls = np.vstack((ROOM, hides, post(2.0, y, 0.25)))
        moving = tracker.update(scan_of(walls, SE2(), rng, 0.01, 0.1 * k), SE2())
        about = np.hypot(moving.points[:, 0] - 2.0, moving.points[:, 1] - y) < 0.35
        for kind, flags in (("come", moving.come), ("speed", moving.velocities.any(axis=1))):
            if (flags & about).any():
                first.setdefault(kind, 0.1 * k)
        assert not moving.come[~about].any()
        assert (moving.speeds[about & moving.come] > 0.5).all()
    assert first["come"] <= first["speed"] - 0.2


def test_nothing_has_come_where_a_robot_passes_what_stands() -> None:
    flags: list[int] = []
    pass_by(lambda moving: flags.append(int(moving.come.sum())))
    assert max(flags) == 0


def test_what_is_too_near_to_be_measured_was_not_seen_to_be_free() -> None:
    tracker, rng = Tracker(REACH), np.random.default_rng(4)
    for k in range(6):
        scan = scan_of(np.vstack((ROOM, post(1.0, 0.0))), SE2(), rng, 0.01, 0.1 * k)
        ranges = np.full_like(scan.ranges, 0.05) if k < 5 else scan.ranges
        moving = tracker.update(replace(scan, ranges=ranges), SE2())
    assert len(moving.points) == len(scan.ranges)
    assert not moving.come.any()


def test_who_walks_on_behind_another_is_predicted_along_that_course() -> None:
    tracker, rng = Tracker(REACH), np.random.default_rng(5)
    hides = edges(np.array([[0.7, 0.1], [1.0, 0.1], [1.0, 1.4], [0.7, 1.4]]))
    hidden = []
    for k in range(24):
        y = -1.2 + 0.08 * k
        walls = np.vstack((ROOM, hides, post(1.6, y)))
        moving = tracker.update(scan_of(walls, SE2(), rng, 0.01, 0.1 * k), SE2())
        beyond = np.hypot(moving.points[:, 0] - 1.6, moving.points[:, 1] - y) < 0.4
        if y > 0.5:
            hidden.append(int((beyond & (moving.velocities[:, 1] > 0.4)).sum()))
    assert min(hidden) > 0


def person(x: float, y: float) -> NDArray[np.float64]:
    turns = np.arange(12) * math.pi / 6.0
    corners = np.array([x, y]) + 0.25 * np.column_stack((np.cos(turns), np.sin(turns)))
    return np.hstack((corners, np.roll(corners, -1, axis=0)))


class Watched:
    """A costmap of a robot that stands in a room where somebody walks."""

    def __init__(self, moving_time: float = 1.5, rolling: bool = False) -> None:
        source = {"obstacle_max_range": 3.0, "raytrace_max_range": 4.0}
        self.layered = LayeredCostmap(
            costmap_config(
                rolling_window=rolling,
                width=8,
                height=8,
                origin_x=-4.0,
                origin_y=-4.0,
                resolution=0.05,
                robot_radius=0.25,
                plugins=("obstacle_layer", "voxel_layer", "inflation_layer"),
                obstacle_layer={
                    **scans(source, moving_time=moving_time),
                    "observation_sources": "scan other",
                    "other": SCAN,
                },
                voxel_layer=clouds(),
            )
        )
        self.time, self.pose = 0.0, SE2()
        self._rng = np.random.default_rng(3)

    def see(self, *people: tuple[float, float], blind: bool = False) -> None:
        """Look round; blind where what is ahead is not seen."""
        walls = np.vstack([ROOM, *(person(*one) for one in people)])
        scan = scan_of(walls, self.pose, self._rng, 0.01, self.time)
        if blind:
            ranges = np.where(np.abs(scan.angles) < 1.3, np.nan, scan.ranges)
            scan = replace(scan, ranges=ranges)
        see(self.layered, self.pose, self.time, [PlacedScan(scan, self.pose)])
        self.time += 0.1

    def see_depth(self, x: float, y: float) -> None:
        """See one point high above the lidar."""
        cloud = Cloud(np.array([[x, y, 1.0]]), np.array([0.0, 0.0, 0.4]), self.time)
        see(self.layered, self.pose, self.time, [PlacedCloud(cloud, self.pose)])

    def cost(self, x: float, y: float) -> int:
        cost = self.layered.costmap.cost_at(x, y)
        assert cost is not None
        return cost

    def lethal_about(self, x: float, y: float) -> int:
        return len(self.layered.costmap.obstacles(x, y, 0.4))


@pytest.mark.parametrize("rolling", [False, True])
@pytest.mark.parametrize(("moving_time", "stays"), [(1.5, False), (0.0, True)])
def test_marks_of_departed_people_fade(rolling: bool, moving_time: float, stays: bool) -> None:
    watched = Watched(moving_time, rolling)
    for k in range(12):
        watched.see((0.8, -0.9 + 0.1 * k))
    assert bool(watched.lethal_about(0.8, 0.2)) is (rolling or stays)
    watched.pose = SE2(0.02, 0.06, 0.0)
    for _ in range(3):
        watched.see((0.8, 3.0), blind=True)
    assert bool(watched.lethal_about(0.8, 0.2)) is stays


def test_who_walks_is_not_marked_again_where_another_source_brings_news() -> None:
    watched = Watched()
    for k in range(12):
        watched.see((0.8, -0.9 + 0.1 * k))
    scan = scan_of(ROOM, watched.pose, np.random.default_rng(0), 0.01, watched.time - 0.05)
    watched.layered.receive("obstacle_layer", "other", PlacedScan(scan, watched.pose))
    watched.layered.update(watched.pose, watched.time - 0.05)
    assert not watched.lethal_about(0.8, 0.2)


def test_marks_of_what_stands_stay_unseen() -> None:
    watched = Watched()
    for _ in range(12):
        watched.see((0.8, 0.2))
    for _ in range(12):
        watched.see(blind=True)
    assert watched.lethal_about(0.8, 0.2)


def test_what_a_camera_marked_of_who_walks_fades_and_a_table_beside_stays() -> None:
    watched = Watched()
    for k in range(12):
        watched.see((0.9, -0.9 + 0.1 * k))
    watched.see_depth(0.9, 0.3)
    watched.see_depth(1.8, 0.0)
    assert watched.lethal_about(0.9, 0.3)
    for k in range(12, 25):
        watched.see((0.9, -0.9 + 0.1 * k))
    assert not watched.lethal_about(0.9, 0.3)
    assert watched.lethal_about(1.8, 0.0)
    (layer,) = (one for one in watched.layered.group.in_use if isinstance(one, VoxelLayer))
    assert np.argwhere(layer.voxels).tolist() == [[80, 115]]


def test_it_costs_to_be_where_somebody_will_be_and_less_the_later() -> None:
    watched = Watched()
    for k in range(12):
        watched.see((1.6, -1.6 + 0.08 * k))
    here, soon, later, never, behind = (watched.cost(1.6, y) for y in (-0.7, -0.2, 0.2, 1.2, -1.7))
    assert LETHAL > here > soon > later > 0
    assert never == behind == 0


@pytest.mark.parametrize(
    ("rolling", "distance", "lethal"), [(True, 0.7, True), (True, 1.8, False), (False, 0.7, False)]
)
def test_far_people_are_no_obstacle_to_plans(rolling: bool, distance: float, lethal: bool) -> None:
    watched = Watched(rolling=rolling)
    for k in range(12):
        watched.see((distance, -0.5 + 0.06 * k))
    assert bool(watched.lethal_about(distance, 0.16)) is lethal


@pytest.mark.parametrize("T_map_odom", [SE2(), SE2(3.0, -2.0, 1.1)])
def test_moves_within_is_true_where_anything_moves_near_a_point(T_map_odom: SE2) -> None:
    watched = Watched()
    for k in range(12):
        watched.see((1.6, -1.6 + 0.08 * k), (-1.0, 0.0))
    costmap = watched.layered.costmap.seen_from(T_map_odom)
    (x, y), (beside_x, beside_y) = T_map_odom.apply(np.array([[1.6, -0.2], [-1.0, -0.8]]))
    assert costmap.moves_within(x, y, 0.4)
    assert not costmap.moves_within(x, y, 0.1)
    assert not costmap.moves_within(beside_x, beside_y, 1.0), "who stands does not move"


def test_what_is_laid_over_the_costs_is_taken_off_again() -> None:
    watched, untouched = Watched(), Watched()
    known = watched.layered.costmap.data.copy()
    for k in range(40):
        watched.see((1.6, -2.5 + 0.12 * k))
        untouched.see()
        data, changed = watched.layered.costmap.data, watched.layered.take_changed()
        if changed is not None:
            known[changed] = data[changed]
        np.testing.assert_array_equal(known, data, "nothing has changed elsewhere")
        if k == 14:
            assert (watched.layered.costmap.data != untouched.layered.costmap.data).any()
    watched.layered.take_changed()
    for _ in range(20):
        watched.see()
        untouched.see()
    assert watched.layered.take_changed() is not None
    near = (slice(40, 120), slice(80, 136))  # the walls are noisy
    assert not watched.layered.costmap.data[near].any()


@pytest.mark.parametrize("origin", [SE2(), SE2(-3.0, 2.0, 0.6)])
def test_path_costs_lie_where_things_move_on_any_grid(origin: SE2) -> None:
    frame = GridFrame(0.05, 120, 100, origin)
    at, to = (origin.apply(np.array([end]))[0] for end in ([2.0, 2.0], [4.0, 2.0]))
    thing = np.array([[*at, *(to - at), 0.2]])
    patch = path_costs(thing, 0.0, 1.0, 0.25, frame)
    assert patch is not None
    costs = np.zeros(frame.shape, np.uint8)
    costs[patch.window] = patch.costs
    first, middle, last = costs[40, 40], costs[40, 60], costs[40, 78]
    assert first > middle > last > 0
    assert (first, costs[52, 40]) == (29, 12)  # 6 cells wide is the edge
    assert costs[40, 30] > 0
    assert not costs[[40, 62, 40], [20, 60, 100]].any()
    moved = path_costs(thing, 0.5, 1.0, 0.25, frame)
    assert moved is not None
    assert moved.window[1].start == pytest.approx(patch.window[1].start + 20, abs=1)


def test_paths_off_the_grid_cost_nothing() -> None:
    thing = np.array([[20.0, 20.0, 1.0, 0.0, 0.2]])
    assert path_costs(thing, 0.0, 1.5, 0.25, GridFrame(0.05, 40, 40, SE2())) is None
