"""How a part of a world swings: about which axis, how far, and how hard it rubs."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from arjuna_core.errors import WorldError
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.files.sdf.model_tags import SdfJoint, SdfLink
from arjuna_sim.files.sdf.rigid_groups import read_hinge
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.urdf import Hinge

QUARTER = math.pi / 2
LEAF = Pose3.from_rpy((1.0, 0.0, 0.0), (0.0, 0.0, QUARTER))


def hinge(
    axis: str, kind: str = "revolute", T_axis: Pose3 = ORIGIN, own: str = "leaf", link: Pose3 = LEAF
) -> Hinge:
    """Return the hinge of a leaf on a frame, at (1, 2, 3) of the world."""
    text = f"<sdf><joint name='j' type='{kind}'>{axis}</joint></sdf>"
    xml = XmlFile(Path("w"), "sdf", WorldError, text.encode())
    at = Pose3((1.0, 2.0, 3.0))
    joint = SdfJoint(xml.root[0], xml, "", kind, "frame", "leaf", at, T_axis)
    return read_hinge(joint, SdfLink(xml.root, xml, "leaf", link, False, False, None), {own})


def test_axis_and_anchor_are_told_in_what_swings() -> None:
    found = hinge("<axis><xyz>0 0 2</xyz></axis>")
    assert found.axis == pytest.approx((0.0, 0.0, 1.0))
    assert found.anchor == pytest.approx((2.0, 0.0, 3.0))  # ahead of the leaf, which looks left
    along_x = hinge("<axis><xyz>3 0 4</xyz></axis>")
    assert along_x.axis == pytest.approx((0.0, -0.6, 0.8))
    turned = hinge("<axis><xyz>1 0 0</xyz></axis>", T_axis=Pose3.from_rpy((9, 9, 9), (0, 0, 0.3)))
    assert turned.axis == pytest.approx((math.sin(0.3), -math.cos(0.3), 0.0))
    assert hinge("<axis/>").axis == pytest.approx((0.0, 0.0, 1.0))  # where it is not told


def test_a_parent_that_swings_turns_the_other_way() -> None:
    axis = "<axis><xyz>0 0 1</xyz></axis>"
    assert hinge(axis, own="frame").axis == pytest.approx((0.0, 0.0, -1.0))


@pytest.mark.parametrize(
    ("limit", "expected"),
    [
        ("<lower>-1</lower><upper>2</upper>", (-1.0, 2.0)),
        ("<lower>-1</lower>", (-1.0, 1e6)),
        ("<upper>2</upper>", (-1e6, 2.0)),
        ("<lower>-1e16</lower><upper>1e16</upper>", None),
        ("<lower>-1e6</lower><upper>1e6</upper>", None),
        ("", None),
    ],
)
def test_limits_beyond_reach_are_none(limit: str, expected: tuple[float, float] | None) -> None:
    axis = f"<axis><xyz>0 0 1</xyz><limit>{limit}</limit></axis>"
    assert hinge(axis).limits == expected
    assert hinge(axis, "prismatic").limits == expected
    assert hinge(axis, "continuous").limits is None


def test_only_a_prismatic_joint_slides() -> None:
    kinds = {
        kind: hinge("<axis/>", kind).slides for kind in ("revolute", "continuous", "prismatic")
    }
    assert kinds == {"revolute": False, "continuous": False, "prismatic": True}


def test_it_rubs_and_damps_as_told_and_never_pushes() -> None:
    told = "<axis><dynamics><damping>{}</damping><friction>{}</friction></dynamics></axis>"
    assert (hinge(told.format(3, 2)).damping, hinge(told.format(3, 2)).friction) == (3.0, 2.0)
    assert (hinge(told.format(-3, -2)).damping, hinge(told.format(-3, -2)).friction) == (0.0, 0.0)
    assert (hinge("<axis/>").damping, hinge("<axis/>").friction) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("axis", "problem"),
    [
        ("", "lacks <axis>"),
        ("<axis><xyz>0 0 0</xyz></axis>", "joint 'j'.*axis must not be zero"),
        ("<axis><xyz>1 0</xyz></axis>", "joint 'j' <xyz>.*has 2 numbers"),
        ("<axis><xyz>1.5e308 1.5e308 0</xyz></axis>", "axis must not be zero"),
        ("<axis><limit><lower>a</lower></limit></axis>", "joint 'j' <limit/lower>.*not 1 numbers"),
    ],
)
def test_a_hinge_without_an_axis_is_refused(axis: str, problem: str) -> None:
    with pytest.raises(WorldError, match=problem):
        hinge(axis)
