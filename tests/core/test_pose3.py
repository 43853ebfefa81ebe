"""Motions of space: composed, undone, and partly from one to another."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_core.se2 import SE2

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
def test_composing_maps_points_one_after_the_other_and_inverse_maps_them_back(
    a: Pose3, b: Pose3
) -> None:
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
    assert Pose3.from_rpy((0.0, 0.0, 0.0), rpy).rpy() == pytest.approx(rpy)


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
