"""Poses and velocities: group axioms, exponentials, frames in space."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import expm

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_core.se2 import IDENTITY, SE2, wrap, yaw_of
from arjuna_core.twist import STILL, RecentVelocities, Velocity

SEEDS = range(6)


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
def test_poses_are_composed_and_applied_as_their_matrices(seed: int) -> None:
    a, b = samples(seed, 2)
    np.testing.assert_allclose((a @ b).matrix(), a.matrix() @ b.matrix(), atol=1e-9)
    points = np.random.default_rng(seed).normal(size=(7, 2))
    before = points.copy()
    homogeneous = np.column_stack((points, np.ones(7)))
    np.testing.assert_allclose(a.apply(points), (homogeneous @ a.matrix().T)[:, :2], atol=1e-9)
    np.testing.assert_allclose(a.inverse().apply(a.apply(points)), points, atol=1e-9)
    np.testing.assert_array_equal(points, before)


@pytest.mark.parametrize("seed", SEEDS)
def test_log_and_exp_undo_each_other_within_half_a_turn(seed: int) -> None:
    rng = np.random.default_rng(seed)
    twist = np.append(rng.uniform(-5, 5, 2), rng.uniform(-3.1, 3.1))
    np.testing.assert_allclose(SE2.exp(twist).log(), twist, atol=1e-9)
    assert_same(SE2.exp(twist).inverse(), SE2.exp(-twist))
    (a,) = samples(seed, 1)
    assert_same(SE2.exp(a.log()), a)


@pytest.mark.parametrize("omega", [0.0, 1e-12, 1e-10, 1e-8, -1e-6, 0.3, -2.9])
def test_exp_is_the_matrix_exponential_also_for_small_turns(omega: float) -> None:
    twist = np.array([1.5, -0.4, omega])
    generator = np.array([[0.0, -omega, 1.5], [omega, 0.0, -0.4], [0.0, 0.0, 0.0]])
    np.testing.assert_allclose(SE2.exp(twist).matrix(), expm(generator), atol=1e-8)
    np.testing.assert_allclose(SE2.exp(twist).log(), twist, atol=1e-6)


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


def test_composition_wraps_the_angle_and_arrays_keep_it() -> None:
    assert (SE2(0.0, 0.0, 3.0) @ SE2(0.0, 0.0, 3.0)).theta == pytest.approx(6.0 - 2.0 * math.pi)
    assert (SE2() @ SE2(0.0, 0.0, 50.0)).theta == pytest.approx(wrap(50.0))
    pose = SE2(1.0, -2.0, 0.5)
    assert SE2.from_array(pose.array()) == pose


@pytest.mark.parametrize("seed", SEEDS)
def test_interpolation_ends_at_the_ends_and_takes_the_shorter_turn(seed: int) -> None:
    a, b = samples(seed, 2)
    assert_same(a.interpolate(b, 0.0), a)
    assert_same(a.interpolate(b, 1.0), b)
    halfway = a.interpolate(b, 0.5)
    assert abs(wrap(halfway.theta - a.theta)) <= math.pi / 2 + 1e-9
    assert a.distance(halfway) == pytest.approx(a.distance(b) / 2)


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


@pytest.mark.parametrize(("duration", "mean"), [(0.0, 0.4), (0.125, 0.3), (0.25, 0.2), (9.0, 0.15)])
def test_the_mean_is_of_what_was_measured_within_the_duration(duration: float, mean: float) -> None:
    recent = RecentVelocities(duration)
    assert (recent.mean(), recent.newest) == (STILL, (0.0, STILL))
    for k, x in enumerate((0.0, 0.0, 0.2, 0.4)):
        recent.add(Velocity(x, y=-x, yaw_rate=2.0 * x), 0.125 * k)
    velocity = recent.mean()
    parts = velocity.x, velocity.y, velocity.yaw_rate
    assert parts == pytest.approx((mean, -mean, 2.0 * mean))
    assert recent.newest == (0.375, Velocity(0.4, y=-0.4, yaw_rate=0.8))


def test_a_time_before_is_another_run() -> None:
    recent = RecentVelocities(1.0)
    recent.add(Velocity(0.4), 5.0)
    recent.add(Velocity(0.1), 0.0)
    assert recent.mean() == Velocity(0.1)
    assert recent.newest == (0.0, Velocity(0.1))


POSES = [
    Pose3.from_rpy((*position, 0.5), tuple(angles))
    for position, angles in zip(
        np.random.default_rng(3).uniform(-2, 2, (6, 2)).tolist(),
        np.random.default_rng(4).uniform(-1.4, 1.4, (6, 3)).tolist(),
        strict=True,
    )
]
POINTS = np.random.default_rng(5).uniform(-3, 3, (5, 3))


@pytest.mark.parametrize(("a", "b"), list(pairwise(POSES)))
def test_compositions_move_points_in_turn_and_inverses_move_them_back(a: Pose3, b: Pose3) -> None:
    np.testing.assert_allclose((a @ b).apply(POINTS), a.apply(b.apply(POINTS)))
    np.testing.assert_allclose(a.inverse().apply(a.apply(POINTS)), POINTS)
    assert (a @ a.inverse()).position == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    np.testing.assert_allclose((a @ b @ b.inverse()).rotation(), a.rotation(), atol=1e-12)


@pytest.mark.parametrize(("a", "b"), list(pairwise(POSES)))
@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 1.0])
def test_a_pose_between_goes_straight_and_turns_evenly(a: Pose3, b: Pose3, share: float) -> None:
    def angle(c: Pose3, d: Pose3) -> float:
        return 2.0 * math.acos(min(1.0, abs((c.inverse() @ d).quaternion[0])))

    between = a.interpolate(b, share)
    np.testing.assert_allclose(
        np.subtract(between.position, a.position), share * np.subtract(b.position, a.position)
    )
    assert np.linalg.norm(between.quaternion) == pytest.approx(1.0)
    assert angle(a, between) == pytest.approx(share * angle(a, b), abs=1e-7)
    assert angle(between, b) == pytest.approx((1.0 - share) * angle(a, b), abs=1e-7)


def test_a_pose_between_takes_the_shorter_turn_and_none_between_equal_ones() -> None:
    near, w = Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), ORIGIN.quaternion
    same = Pose3((2.0, 0.0, 0.0), (-w[0], -w[1], -w[2], -w[3]))  # the same rotation, written so
    assert same.interpolate(near, 0.5).rpy()[2] == pytest.approx(0.5)
    assert ORIGIN.interpolate(same, 0.5).planar() == SE2(1.0, 0.0, 0.0)


@pytest.mark.parametrize("rpy", [(0.3, -0.4, 2.0), (-3.0, 1.2, -0.1), (0.0, 0.0, 0.0)])
def test_roll_pitch_and_yaw_come_back(rpy: tuple[float, float, float]) -> None:
    pose = Pose3.from_rpy((1.0, 2.0, 3.0), rpy)
    assert pose.rpy() == pytest.approx(rpy)
    assert pose.planar().array() == pytest.approx((1.0, 2.0, rpy[2]))


@pytest.mark.parametrize(
    ("rpy", "ahead"),
    [
        ((0.0, 0.0, math.pi / 2), (0.0, 1.0, 0.0)),
        ((0.0, math.pi / 2, 0.0), (0.0, 0.0, -1.0)),  # the nose goes down
        ((math.pi / 2, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ((math.pi / 2, 0.0, math.pi / 2), (0.0, 1.0, 0.0)),
    ],
)
def test_angles_turn_about_fixed_axes(
    rpy: tuple[float, float, float], ahead: tuple[float, float, float]
) -> None:
    turned = Pose3.from_rpy((0.0, 0.0, 0.0), rpy).apply(np.array([[1.0, 0.0, 0.0]]))[0]
    assert turned == pytest.approx(ahead, abs=1e-12)
