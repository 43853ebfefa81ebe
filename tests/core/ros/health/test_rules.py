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


@pytest.mark.parametrize(
    ("changed", "problem"),
    [
        ({}, None),
        ({"min_range": 0.5, "max_range": 0.5}, None),
        ({"field_of_view": 0.0}, "field_of_view is 0.0 rad"),
        ({"field_of_view": math.nan}, "field_of_view is nan rad"),
        ({"min_range": 3.0}, "ranges from 3.0 to 2.0 m"),
        ({"max_range": math.inf}, "ranges from 0.1 to inf m"),
    ],
)
def test_a_sonar_has_a_cone(changed: dict[str, float], problem: str | None) -> None:
    good = {"field_of_view": 0.4, "min_range": 0.1, "max_range": 2.0}
    found = range_problem(SimpleNamespace(**{**good, **changed}))
    assert found is None if problem is None else problem in str(found)


@pytest.mark.parametrize("norm", [1.0, 0.01, 1000.0])
def test_a_rotation_need_not_be_normalised(norm: float) -> None:
    assert rotation_problem(rotation(z=0.6 * norm, w=0.8 * norm)) is None


@pytest.mark.parametrize("value", [0.0, math.nan, math.inf, 1e300])
def test_what_is_no_rotation_is_refused(value: float) -> None:
    assert "is no rotation" in str(rotation_problem(rotation(w=value)))


@pytest.mark.parametrize(
    "good",
    [scan(), scan(angle_increment=-1.0), scan(ranges=[1.0], angle_increment=0.0)],
    ids=["inf and NaN", "clockwise", "one beam"],
)
def test_scans_of_lidars_are_taken(good: Any) -> None:
    assert scan_problem(good) is None


@pytest.mark.parametrize(
    ("changed", "problem"),
    [
        ({"ranges": []}, "0 beams"),
        ({"ranges": range(rules.BEAMS + 1)}, f"{rules.BEAMS + 1} beams"),
        ({"angle_increment": 0.0}, "angle_increment is 0.0"),
        ({"angle_increment": 6.2, "ranges": range(9)}, "9 beams from"),
        ({"angle_min": 1e9}, "3 beams from 1000000000.0 rad"),
        ({"range_max": 0.1}, "ranges from 0.1 to 0.1"),
        ({"range_min": -1.0}, "ranges from -1.0"),
        ({"range_max": 1e30}, "to 1e+30 m"),
        ({"range_max": math.nan}, "to nan m"),
        ({"angle_min": math.nan}, "from nan rad"),
        ({"time_increment": 100.0}, "each 100.0 s on"),
        ({"time_increment": 4.0}, "3 beams, each 4.0 s on"),
        ({"time_increment": math.nan}, "each nan s on"),
    ],
)
def test_scans_that_cannot_be_are_refused(changed: dict[str, Any], problem: str) -> None:
    assert problem in str(scan_problem(scan(**changed)))


def test_a_map_as_it_comes_over_the_wire_is_taken() -> None:
    assert grid_problem(grid(0.05000000074505806)) is None
    assert grid_problem(grid(0.05, rules.CELLS, 1, rules.CELLS)) is None
    assert grid_problem(grid(rules.FINEST, 1, 1, 1)) is None
    assert grid_problem(grid(rules.COARSEST, 1, 1, 1)) is None


@pytest.mark.parametrize("resolution", [0.0, -0.05, 1e-9, 1e-6, 1e-3, 1e30])
def test_maps_of_cells_that_cannot_be_are_refused(resolution: float) -> None:
    assert "cells of" in str(grid_problem(grid(resolution)))


@pytest.mark.parametrize(
    ("width", "height", "cells"),
    [(4, 3, 11), (0, 0, 0), (10_000, 10_000, 100_000_000), (2**32 - 1, 2**32 - 1, 12)],
)
def test_maps_of_sizes_that_cannot_be_are_refused(width: int, height: int, cells: int) -> None:
    assert f"for {width} x {height}" in str(grid_problem(grid(0.05, width, height, cells)))


def cloud(bytes_given: int, **changed: Any) -> Any:
    """Return two rows of three points, 24 bytes each, x, y and z as float64."""
    fields = [SimpleNamespace(name=n, offset=8 * k, datatype=8) for k, n in enumerate("xyz")]
    layout = {"width": 3, "height": 2, "point_step": 24, "row_step": 72, "fields": fields}
    return SimpleNamespace(data=bytes(bytes_given), **{**layout, **changed})


def test_a_cloud_that_fills_its_bytes_is_taken() -> None:
    assert cloud_problem(cloud(144)) is None
    thin = [SimpleNamespace(name=n, offset=4 * k, datatype=7) for k, n in enumerate("xyz")]
    assert cloud_problem(cloud(72, point_step=12, row_step=36, fields=thin)) is None


@pytest.mark.parametrize(
    ("changed", "problem"),
    [
        ({"row_step": 71}, "71 bytes a row"),
        ({"height": 3}, "144 bytes for 3 rows of 3 points"),
        ({"point_step": 23, "row_step": 72}, "'z' is no field of a point"),
        ({"fields": []}, "'x' is no field of a point"),
    ],
)
def test_clouds_that_cannot_be_are_refused(changed: dict[str, Any], problem: str) -> None:
    assert problem in str(cloud_problem(cloud(144, **changed)))


def test_an_imu_without_orientation_says_so_by_its_covariance() -> None:
    zero = rotation(w=0.0)
    covariance = [-1.0] + [0.0] * 8
    absent = SimpleNamespace(orientation=zero, orientation_covariance=covariance)
    assert imu_problem(absent) is None
    broken = SimpleNamespace(orientation=zero, orientation_covariance=[0.0] * 9)
    assert "is no rotation" in str(imu_problem(broken))


def test_a_variance_is_not_negative() -> None:
    covariance = [0.0] * 36
    covariance[1] = -0.5  # off the diagonal
    assert covariance_problem(SimpleNamespace(covariance=covariance)) is None
    covariance[7] = -0.5
    assert "variance is -0.5" in str(covariance_problem(SimpleNamespace(covariance=covariance)))


@pytest.mark.parametrize(
    ("broken", "problem"),
    [
        (transform(math.nan), "translation"),
        (transform(1e300), "translation"),
        (transform(turn=rotation(w=0.0)), "no rotation"),
        (transform(frame_id="base_link"), "valid: two names"),
        (transform(child_frame_id="/"), "valid: two names"),
        (transform(sec=-1), "-1 s"),
        (transform(frame_id="x" * 100_000), "names of 100009 characters"),
    ],
)
def test_transforms_that_cannot_be_are_refused(broken: Any, problem: str) -> None:
    assert transform_problem(transform()) is None
    assert problem in str(transform_problem(broken))
