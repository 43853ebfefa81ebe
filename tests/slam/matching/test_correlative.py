"""The correlative search finds what trying every pose of its window finds."""

from __future__ import annotations

import itertools
import math
from collections.abc import Generator

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_slam.matching.correlative import Window, search, searching
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import score

PRIOR = SE2(0.3, -0.2, 0.4)
Found = tuple[SE2, float] | None


def scene(seed: int) -> tuple[Field, Floats]:
    """Return a field and points that lie in it at a pose near the prior, and clutter."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1.5, 1.5, (24, 2))
    truth = PRIOR @ SE2(*rng.uniform(-0.1, 0.1, 3).tolist())
    field = Field(0.05, 0.05)
    field.add(truth.apply(points[:16]), np.zeros((16, 2)))
    return field, points


def responses(
    field: Field, points: Floats, window: Window
) -> dict[tuple[int, int, int], tuple[SE2, float]]:
    """Return each pose of a window and its response, as the definition has it."""
    reach = np.sort(np.hypot(*points.T))[int(0.9 * (len(points) - 1))]
    step = max(0.05 / reach, math.radians(0.25))
    turns, cells = math.ceil(window.theta / step), math.ceil(window.xy / 0.05)
    found = {}
    for k, i, j in itertools.product(
        range(-turns, turns + 1), range(-cells, cells + 1), range(-cells, cells + 1)
    ):
        pose = SE2(PRIOR.x + 0.05 * j, PRIOR.y + 0.05 * i, PRIOR.theta + k * step)
        gap, turn = 0.05 * math.hypot(i, j), k * step
        distance = max(1.0 - 0.2 * gap**2 / window.distance_penalty, window.floor_xy)
        angle = max(1.0 - 0.2 * turn**2 / window.angle_penalty, window.floor_theta)
        mean = float(field.likelihood(pose.apply(points)).mean())
        found[k, i, j] = pose, mean * distance * angle
    return found


WINDOWS = [
    Window(0.15, 0.12, 2),
    Window(0.15, 0.12, 3, distance_penalty=0.05, angle_penalty=0.02),
    Window(0.2, 0.05, 1, distance_penalty=0.01, angle_penalty=0.001, floor_xy=0.9),
]


@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("seed", range(2))
def test_it_finds_the_pose_of_the_greatest_response(window: Window, seed: int) -> None:
    field, points = scene(seed)
    pose, best = max(responses(field, points, window).values(), key=lambda each: each[1])
    found = search(field, points, PRIOR, window, 0.0)
    assert found is not None
    assert found[1] == pytest.approx(best, abs=1e-6)
    assert best <= 1.0
    assert found[0].array() == pytest.approx(pose.array(), abs=1e-9)
    assert score(field, points, PRIOR, found[0], window) == pytest.approx(best, abs=1e-6)
    assert search(field, points, PRIOR, window, best + 1e-6) is None
    assert search(field, points, PRIOR, window, best - 1e-6) is not None


def test_a_turn_counts_by_its_shorter_side() -> None:
    field, points = scene(0)
    window = Window(0.2, 0.1, 2, angle_penalty=0.05)
    pose = SE2(PRIOR.x, PRIOR.y, PRIOR.theta + 0.1)
    around = SE2(PRIOR.x, PRIOR.y, PRIOR.theta + 0.1 - 2.0 * math.pi)
    assert score(field, points, PRIOR, around, window) == pytest.approx(
        score(field, points, PRIOR, pose, window)
    )


def stepwise(steps: Generator[None, None, Found]) -> tuple[Found, int]:
    """Return what a generator returns, and how many steps it took."""
    count = 0
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value, count
        count += 1


@pytest.mark.parametrize("cells", [1, 2, 3])
@pytest.mark.parametrize("seed", range(3))
def test_poses_near_those_left_out_are_not_found(seed: int, cells: int) -> None:
    field, points = scene(seed)
    window, far = Window(0.2, 0.12, 2), 0.05 * cells
    every = responses(field, points, window)
    best = max(every, key=lambda key: every[key][1])
    left_out = every[best][0]
    allowed = {
        key: each
        for key, each in every.items()
        if max(abs(key[1] - best[1]), abs(key[2] - best[2])) > cells
    }
    least = max(each[1] for each in allowed.values()) - 1e-6  # so the best of them must do
    found, _ = stepwise(searching(field, points, PRIOR, window, least, ([left_out], far)))
    assert found is not None
    off = max(abs(found[0].x - left_out.x), abs(found[0].y - left_out.y))
    assert off > far + 1e-9
    assert found[1] >= least
    assert found[1] == pytest.approx(score(field, points, PRIOR, found[0], window), abs=1e-6)


def test_nothing_is_found_of_nothing_or_in_nothing() -> None:
    field, points = scene(0)
    assert search(field, points[:0], PRIOR, WINDOWS[0], 0.0) is None
    assert search(Field(0.05, 0.05), points, PRIOR, WINDOWS[0], 0.0) is None
    assert stepwise(searching(Field(0.05, 0.05), points, PRIOR, WINDOWS[0], 0.0)) == (None, 0)
    assert stepwise(searching(field, points, PRIOR, WINDOWS[0], 0.0))[1] == 0  # all in one step
    found, steps = stepwise(searching(field, points, PRIOR, WINDOWS[0], 0.0, work=1))
    assert found == search(field, points, PRIOR, WINDOWS[0], 0.0)
    assert steps > 5


def test_points_near_the_middle_are_turned_by_no_less_than_a_quarter_degree() -> None:
    field = Field(0.05, 0.05)
    far = np.array([[0.0, 30.0], [0.0, -30.0]])
    field.add(SE2(0.0, 0.0, 3.0 * math.radians(0.25)).apply(far), np.zeros((2, 2)))
    found = search(field, far, SE2(), Window(0.0, 0.02, 1), 0.0)
    assert found is not None
    assert found[0].theta == pytest.approx(3.0 * math.radians(0.25))
    near = Field(0.05, 0.05)
    near.add(np.array([[0.01, 0.0]]), np.zeros((1, 2)))
    kept = search(near, np.array([[0.01, 0.0]]), SE2(), Window(0.0, 2.5, 1), 0.0)
    assert kept is not None
    assert abs(math.remainder(kept[0].theta, 1.0)) < 1e-9  # steps of a cell at a cell's reach
