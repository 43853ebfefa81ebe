"""Joints and robot descriptions."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.model.urdf import Hinge, Joint, Mimic

AT = Pose3.from_rpy((1.0, 2.0, 3.0), (0.3, -0.2, 0.9))
AXIS = (0.36, 0.48, 0.8)


@pytest.mark.parametrize("position", [0.0, 0.5, -2.0])
def test_a_prismatic_joint_slides_along_its_axis(position: float) -> None:
    found = Joint("j", "prismatic", "a", "b", AT, AXIS).at(position)
    expected = np.array(AT.position) + AT.rotation() @ AXIS * position
    assert found.position == pytest.approx(tuple(expected))
    np.testing.assert_allclose(found.rotation(), AT.rotation(), atol=1e-12)


@pytest.mark.parametrize("kind", ["revolute", "continuous"])
@pytest.mark.parametrize("position", [0.0, 0.5, -2.0])
def test_a_joint_turns_about_its_axis(kind: str, position: float) -> None:
    """By Rodrigues' formula."""
    found = Joint("j", kind, "a", "b", AT, AXIS).at(position)
    x, y, z = AXIS
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned = np.eye(3) + math.sin(position) * K + (1.0 - math.cos(position)) * K @ K
    np.testing.assert_allclose(found.rotation(), AT.rotation() @ turned, atol=1e-12)
    assert found.position == pytest.approx(AT.position)


@pytest.mark.parametrize(
    ("kind", "has"),
    [
        *(("fixed", False), ("floating", False), ("planar", False)),
        *(("revolute", True), ("continuous", True), ("prismatic", True)),
    ],
)
def test_one_number_moves_what_turns_or_slides(kind: str, has: bool) -> None:
    assert Joint("j", kind, "a", "b", ORIGIN).has_position == has


def test_joints_and_hinges_neither_brake_nor_end_by_default() -> None:
    joint, hinge = Joint("j", "revolute", "a", "b", ORIGIN), Hinge(False, (1.0, 0.0, 0.0))
    assert (joint.damping, joint.friction, joint.limits) == (0.0, 0.0, None)
    assert (hinge.damping, hinge.friction, hinge.limits) == (0.0, 0.0, None)
    assert hinge.anchor == (0.0, 0.0, 0.0)
    assert joint.axis == (1.0, 0.0, 0.0)  # URDF's own
    assert (Mimic("k").multiplier, Mimic("k").offset) == (1.0, 0.0)
