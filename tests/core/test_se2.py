"""Claims: SE2 is a group, its exponential and logarithm undo each other, and it maps points."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from scipy.linalg import expm

from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import IDENTITY, SE2, wrap, yaw_of

SEEDS = range(20)


def samples(seed: int, count: int) -> Iterator[SE2]:
    rng = np.random.default_rng(seed)
    for _ in range(count):
        yield SE2.from_array(rng.uniform((-10, -10, -7), (10, 10, 7)))


def assert_same(a: SE2, b: SE2) -> None:
    assert a.x == pytest.approx(b.x, abs=1e-9)
    assert a.y == pytest.approx(b.y, abs=1e-9)
    assert wrap(a.theta - b.theta) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_group_axioms(seed: int) -> None:
    a, b, c = samples(seed, 3)
    assert_same((a @ b) @ c, a @ (b @ c))
    assert_same(a @ IDENTITY, a)
    assert_same(IDENTITY @ a, a)
    assert_same(a @ a.inverse(), IDENTITY)
    assert_same(a.inverse() @ a, IDENTITY)
    assert_same((a @ b).inverse(), b.inverse() @ a.inverse())


@pytest.mark.parametrize("seed", SEEDS)
def test_composition_is_the_product_of_matrices(seed: int) -> None:
    a, b = samples(seed, 2)
    np.testing.assert_allclose((a @ b).matrix(), a.matrix() @ b.matrix(), atol=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_apply_maps_points_as_the_matrix_does_and_leaves_them_alone(seed: int) -> None:
    (a,) = samples(seed, 1)
    points = np.random.default_rng(seed).normal(size=(7, 2))
    before = points.copy()
    homogeneous = np.column_stack((points, np.ones(7)))
    np.testing.assert_allclose(a.apply(points), (homogeneous @ a.matrix().T)[:, :2], atol=1e-9)
    np.testing.assert_allclose(a.inverse().apply(a.apply(points)), points, atol=1e-9)
    np.testing.assert_array_equal(points, before)


@pytest.mark.parametrize("seed", SEEDS)
def test_log_undoes_exp_within_half_a_turn(seed: int) -> None:
    rng = np.random.default_rng(seed)
    twist = np.append(rng.uniform(-5, 5, 2), rng.uniform(-3.1, 3.1))
    np.testing.assert_allclose(SE2.exp(twist).log(), twist, atol=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_exp_undoes_log(seed: int) -> None:
    (a,) = samples(seed, 1)
    assert_same(SE2.exp(a.log()), a)


@pytest.mark.parametrize("omega", [0.0, 1e-12, 1e-10, 1e-8, -1e-6, 0.3, -2.9])
def test_exp_is_the_matrix_exponential_also_for_small_turns(omega: float) -> None:
    twist = np.array([1.5, -0.4, omega])
    generator = np.array([[0.0, -omega, 1.5], [omega, 0.0, -0.4], [0.0, 0.0, 0.0]])
    np.testing.assert_allclose(SE2.exp(twist).matrix(), expm(generator), atol=1e-8)
    np.testing.assert_allclose(SE2.exp(twist).log(), twist, atol=1e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_inverse_of_exp_is_exp_of_the_negative(seed: int) -> None:
    twist = np.random.default_rng(seed).uniform(-3, 3, 3)
    assert_same(SE2.exp(twist).inverse(), SE2.exp(-twist))


@pytest.mark.parametrize(
    ("angle", "wrapped"),
    [
        (0.0, 0.0),
        (math.pi, -math.pi),
        (-math.pi, -math.pi),
        (7.0, 7.0 - 2 * math.pi),
        (-3.2, 3.08319),
    ],
)
def test_wrap_lies_in_the_half_open_turn(angle: float, wrapped: float) -> None:
    assert wrap(angle) == pytest.approx(wrapped, abs=1e-5)
    np.testing.assert_allclose(wrap(np.array([angle])), [wrapped], atol=1e-5)


def test_composition_wraps_the_angle() -> None:
    assert (SE2(0.0, 0.0, 3.0) @ SE2(0.0, 0.0, 3.0)).theta == pytest.approx(6.0 - 2.0 * math.pi)
    assert (SE2() @ SE2(0.0, 0.0, 50.0)).theta == pytest.approx(wrap(50.0))


@pytest.mark.parametrize("seed", SEEDS)
def test_interpolation_ends_at_the_ends_and_takes_the_shorter_turn(seed: int) -> None:
    a, b = samples(seed, 2)
    assert_same(a.interpolate(b, 0.0), a)
    assert_same(a.interpolate(b, 1.0), b)
    halfway = a.interpolate(b, 0.5)
    assert abs(wrap(halfway.theta - a.theta)) <= math.pi / 2 + 1e-9
    assert a.distance(halfway) == pytest.approx(a.distance(b) / 2)


def test_arrays_round_trip() -> None:
    pose = SE2(1.0, -2.0, 0.5)
    assert SE2.from_array(pose.array()) == pose


@pytest.mark.parametrize("seed", SEEDS)
def test_the_yaw_of_a_tilted_quaternion_of_any_length(seed: int) -> None:
    rng = np.random.default_rng(seed)
    roll, pitch, yaw = rng.uniform((-3.1, -1.5, -3.1), (3.1, 1.5, 3.1)).tolist()
    scale = float(rng.uniform(0.1, 3.0))
    w, x, y, z = (
        scale * part for part in Pose3.from_rpy((0.0, 0.0, 0.0), (roll, pitch, yaw)).quaternion
    )
    assert yaw_of(x, y, z, w) == pytest.approx(yaw, abs=1e-9)


@pytest.mark.parametrize("quaternion", [(0.0, 0.0, 0.0, 0.0), (0.0, 0.0, math.nan, 1.0)])
def test_what_is_no_rotation_has_no_yaw(quaternion: tuple[float, float, float, float]) -> None:
    with pytest.raises(ValueError, match="is no rotation"):
        yaw_of(*quaternion)
