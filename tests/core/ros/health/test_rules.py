"""Claims: each rule of a type accepts what a robot sends, up to its limits, and names the rest."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from arjuna_core.ros.health import rules
from arjuna_core.ros.health.rules import (
    cloud_problem,
    costmap_problem,
    covariance_problem,
    grid_problem,
    imu_problem,
    pose_problem,
    range_problem,
    rotation_problem,
    scan_problem,
    stamp_problem,
    transform_problem,
)

TURN = 2.0 * math.pi


def rotation(x: float = 0.0, y: float = 0.0, z: float = 0.0, w: float = 1.0) -> Any:
    return SimpleNamespace(x=x, y=y, z=z, w=w)


def scan(**changed: Any) -> Any:
    good = {
        "ranges": [1.0, math.inf, math.nan],
        "angle_min": -1.0,
        "angle_increment": 1.0,
        "range_min": 0.1,
        "range_max": 10.0,
        "time_increment": 0.0,
    }
    return SimpleNamespace(**{**good, **changed})


def grid(resolution: float = 0.05, width: int = 4, height: int = 3, cells: int = 12) -> Any:
    info = SimpleNamespace(resolution=resolution, width=width, height=height)
    return SimpleNamespace(info=info, data=range(cells))


def costmap(cells: int) -> Any:
    metadata = SimpleNamespace(resolution=0.05, size_x=4, size_y=3)
    return SimpleNamespace(metadata=metadata, data=range(cells))


def transform(x: float = 1.0, turn: Any = None, **changed: Any) -> Any:
    names = {"frame_id": "odom", "child_frame_id": "base_link", "sec": 5, **changed}
    stamp = SimpleNamespace(sec=names["sec"])
    translation = SimpleNamespace(x=x, y=0.0, z=0.0)
    return SimpleNamespace(
        header=SimpleNamespace(frame_id=names["frame_id"], stamp=stamp),
        child_frame_id=names["child_frame_id"],
        transform=SimpleNamespace(translation=translation, rotation=turn or rotation()),
    )


def sonar(**changed: float) -> Any:
    return SimpleNamespace(**{"field_of_view": 0.4, "min_range": 0.1, "max_range": 2.0, **changed})


def cloud(bytes_given: int, **changed: Any) -> Any:
    """Return two rows of three points, 24 bytes each, x, y and z as float64."""
    fields = [SimpleNamespace(name=n, offset=8 * k, datatype=8) for k, n in enumerate("xyz")]
    layout = {"width": 3, "height": 2, "point_step": 24, "row_step": 72, "fields": fields}
    return SimpleNamespace(data=bytes(bytes_given), **{**layout, **changed})


def position(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Any:
    return SimpleNamespace(position=SimpleNamespace(x=x, y=y, z=z))


def beams(count: int, each: float, **changed: Any) -> Any:
    return scan(ranges=range(count), angle_increment=each, **changed)


def names(parent: int, child: int) -> Any:
    return transform(frame_id="p" * parent, child_frame_id="c" * child)


BOUNDS = [
    (rotation_problem, rotation(w=1e-6), rotation(w=0.99e-6)),
    (rotation_problem, rotation(x=1e6, w=0.0), rotation(x=1.01e6, w=0.0)),
    (rotation_problem, rotation(x=8e5, z=6e5, w=0.0), rotation(x=8e5, z=6.1e5, w=0.0)),
    (rotation_problem, rotation(y=8e5, w=6e5), rotation(y=8.1e5, w=6e5)),
    (scan_problem, beams(rules.BEAMS, 1e-6), beams(rules.BEAMS + 1, 1e-6)),
    (scan_problem, beams(2, 1e-6), beams(2, 0.99e-6)),
    (scan_problem, beams(3, -TURN), beams(2, -1.01 * TURN)),
    (scan_problem, beams(3, TURN), beams(4, 0.7 * TURN)),
    (scan_problem, scan(angle_min=-2.0 * TURN), scan(angle_min=-2.01 * TURN)),
    (scan_problem, scan(range_min=0.0), scan(range_min=-0.01)),
    (scan_problem, scan(range_min=9.9), scan(range_min=10.0)),
    (scan_problem, scan(range_max=rules.FARTHEST), scan(range_max=1.01 * rules.FARTHEST)),
    (scan_problem, scan(time_increment=-10.0 / 3.0), scan(time_increment=-3.4)),
    (range_problem, sonar(field_of_view=TURN), sonar(field_of_view=1.01 * TURN)),
    (range_problem, sonar(field_of_view=1e-9), sonar(field_of_view=0.0)),
    (range_problem, sonar(min_range=0.0), sonar(min_range=-0.01)),
    (range_problem, sonar(min_range=2.0), sonar(min_range=2.01)),
    (range_problem, sonar(max_range=rules.FARTHEST), sonar(max_range=1.01 * rules.FARTHEST)),
    (grid_problem, grid(rules.FINEST), grid(0.99 * rules.FINEST)),
    (grid_problem, grid(rules.COARSEST), grid(1.01 * rules.COARSEST)),
    (grid_problem, grid(0.1, 1, 1, 1), grid(0.1, 0, 1, 0)),
    (
        grid_problem,
        grid(0.1, rules.CELLS, 1, rules.CELLS),
        grid(0.1, rules.CELLS + 1, 1, rules.CELLS + 1),
    ),
    (costmap_problem, costmap(12), costmap(11)),
    (pose_problem, position(x=rules.FARTHEST), position(x=1.01 * rules.FARTHEST)),
    (pose_problem, position(y=-rules.FARTHEST), position(y=-1.01 * rules.FARTHEST)),
    (pose_problem, position(z=-rules.FARTHEST), position(z=-1.01 * rules.FARTHEST)),
    (transform_problem, transform(-rules.FARTHEST), transform(-1.01 * rules.FARTHEST)),
    (transform_problem, transform(sec=0), transform(sec=-1)),
    (transform_problem, names(1, rules.TEXT - 1), names(1, rules.TEXT)),
    (transform_problem, names(2, 1), names(0, 1)),
    (transform_problem, names(1, 2), names(1, 0)),
]


@pytest.mark.parametrize(("problem", "on_it", "beyond"), BOUNDS)
def test_a_limit_is_valid_itself(problem: Any, on_it: Any, beyond: Any) -> None:
    assert problem(on_it) is None
    assert problem(beyond) is not None


def test_a_measurement_is_not_far_ahead_of_a_clock_that_runs() -> None:
    class Imu:
        header = SimpleNamespace(stamp=SimpleNamespace(sec=110))

    class Path(Imu):
        """A message that is no measurement may lie ahead."""

    assert stamp_problem(Imu(), 100.0) is None
    assert stamp_problem(Imu(), 0.0) is None
    assert stamp_problem(Path(), 1.0) is None
    ahead = "its stamp is 11 s ahead of the clock; does its sender use sim time?"
    assert stamp_problem(Imu(), 99.0) == ahead


NAN, INF = math.nan, math.inf
THIN = [SimpleNamespace(name=name, offset=4 * k, datatype=7) for k, name in enumerate("xyz")]
UNKNOWN = [-1.0] + [0.0] * 8  # the covariance of an orientation that is not measured
CORRELATED, NEGATIVE = [0.0] * 36, [0.0] * 36
CORRELATED[1], NEGATIVE[7] = -0.5, -0.5

TAKEN = [
    (range_problem, sonar()),
    (range_problem, sonar(min_range=0.5, max_range=0.5)),
    *[(rotation_problem, rotation(z=0.6 * norm, w=0.8 * norm)) for norm in (1.0, 0.01, 1000.0)],
    (scan_problem, scan()),
    (scan_problem, scan(angle_increment=-1.0)),
    (scan_problem, scan(ranges=[1.0], angle_increment=0.0)),
    (grid_problem, grid(0.05000000074505806)),  # as it comes over the wire
    (cloud_problem, cloud(144)),
    (cloud_problem, cloud(72, point_step=12, row_step=36, fields=THIN)),
    (imu_problem, SimpleNamespace(orientation=rotation(w=0.0), orientation_covariance=UNKNOWN)),
    (covariance_problem, SimpleNamespace(covariance=CORRELATED)),
    (transform_problem, transform()),
]


@pytest.mark.parametrize(("problem", "message"), TAKEN)
def test_what_robots_send_is_taken(problem: Any, message: Any) -> None:
    assert problem(message) is None


REFUSED = [
    (range_problem, sonar(field_of_view=0.0), "field_of_view is 0.0 rad"),
    (range_problem, sonar(field_of_view=NAN), "field_of_view is nan rad"),
    (range_problem, sonar(min_range=3.0), "ranges from 3.0 to 2.0 m"),
    (range_problem, sonar(max_range=INF), "ranges from 0.1 to inf m"),
    *[(rotation_problem, rotation(w=w), "is no rotation") for w in (0.0, NAN, INF, 1e300)],
    (scan_problem, scan(ranges=[]), "0 beams"),
    (scan_problem, scan(ranges=range(rules.BEAMS + 1)), f"{rules.BEAMS + 1} beams"),
    (scan_problem, scan(angle_increment=0.0), "angle_increment is 0.0"),
    (scan_problem, scan(angle_increment=6.2, ranges=range(9)), "9 beams from"),
    (scan_problem, scan(angle_min=1e9), "3 beams from 1000000000.0 rad"),
    (scan_problem, scan(range_max=0.1), "ranges from 0.1 to 0.1"),
    (scan_problem, scan(range_min=-1.0), "ranges from -1.0"),
    (scan_problem, scan(range_max=1e30), "to 1e+30 m"),
    (scan_problem, scan(range_max=NAN), "to nan m"),
    (scan_problem, scan(angle_min=NAN), "from nan rad"),
    (scan_problem, scan(time_increment=100.0), "each 100.0 s on"),
    (scan_problem, scan(time_increment=4.0), "3 beams, each 4.0 s on"),
    (scan_problem, scan(time_increment=NAN), "each nan s on"),
    *[(grid_problem, grid(each), "cells of") for each in (0.0, -0.05, 1e-9, 1e-6, 1e-3, 1e30)],
    (grid_problem, grid(0.05, 4, 3, 11), "for 4 x 3"),
    (grid_problem, grid(0.05, 0, 0, 0), "for 0 x 0"),
    (grid_problem, grid(0.05, 10_000, 10_000, 100_000_000), "for 10000 x 10000"),
    (grid_problem, grid(0.05, 2**32 - 1, 2**32 - 1, 12), "for 4294967295 x 4294967295"),
    (cloud_problem, cloud(144, row_step=71), "71 bytes a row"),
    (cloud_problem, cloud(144, height=3), "144 bytes for 3 rows of 3 points"),
    (cloud_problem, cloud(144, point_step=23), "'z' is no field of a point"),
    (cloud_problem, cloud(144, fields=[]), "'x' is no field of a point"),
    (
        imu_problem,
        SimpleNamespace(orientation=rotation(w=0.0), orientation_covariance=[0.0] * 9),
        "is no rotation",
    ),
    (covariance_problem, SimpleNamespace(covariance=NEGATIVE), "variance is -0.5"),
    (transform_problem, transform(NAN), "translation"),
    (transform_problem, transform(1e300), "translation"),
    (transform_problem, transform(turn=rotation(w=0.0)), "no rotation"),
    (transform_problem, transform(frame_id="base_link"), "valid: two names"),
    (transform_problem, transform(child_frame_id="/"), "valid: two names"),
    (transform_problem, transform(sec=-1), "-1 s"),
    (transform_problem, transform(frame_id="x" * 100_000), "names of 100009 characters"),
]


@pytest.mark.parametrize(("problem", "message", "words"), REFUSED)
def test_what_cannot_be_is_refused_with_its_reason(problem: Any, message: Any, words: str) -> None:
    assert words in str(problem(message))
