"""Which links of a world's model move as one, and what its joints do."""

from __future__ import annotations

import math

import pytest

from arjuna_core.errors import WorldError
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.files.sdf.model_tags import SdfJoint, SdfLink
from arjuna_sim.files.sdf.rigid_groups import RigidGroup, read_hinge, rigid_groups
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.urdf import Hinge
from tests.sim.builders import sdf_file, texts

Found = list[tuple[list[str], bool, bool]]
DOOR = ("revolute", "frame", "leaf")


def cube(name: str, x: float = 0.0, y: float = 0.0, static: bool = False) -> SdfLink:
    """Return a link that is a cube of 1 m."""
    part = Part(Shape(Kind.BOX, (1.0, 1.0, 1.0)), Pose3((x, y, 0.0)))
    xml = sdf_file()
    return SdfLink(xml.root, xml, name, ORIGIN, static, False, None, [part])


def joint(kind: str, parent: str, child: str, limits: str = "") -> SdfJoint:
    axis = f"<axis><xyz>0 0 1</xyz>{limits}</axis>" if kind != "fixed" else ""
    xml = sdf_file(f"<joint name='{parent}-{child}' type='{kind}'>{axis}</joint>")
    return SdfJoint(xml.root[0], xml, "", kind, parent, child, ORIGIN, (ORIGIN, ORIGIN))


def read(
    links: list[SdfLink], *joints: tuple[str, ...], notes: XmlFile | None = None
) -> list[RigidGroup]:
    return rigid_groups(
        notes or sdf_file(), "model 'm'", links, [joint(*words) for words in joints]
    )


def grouped(links: list[SdfLink], *joints: tuple[str, ...], notes: XmlFile | None = None) -> Found:
    """Return of each group the names, whether it is fast, and whether it swings."""
    groups = read(links, *joints, notes=notes)
    return [([one.name for one in g.links], g.fast, g.hinge is not None) for g in groups]


def apart(*names: str) -> list[SdfLink]:
    """Return cubes 2 m from each other, so that none overlap."""
    return [cube(name, 2.0 * i) for i, name in enumerate(names)]


def test_what_no_joint_connects_holds_together_where_it_overlaps() -> None:
    assert grouped(apart("a", "b")) == [(["a"], False, False), (["b"], False, False)]
    chain = [cube("a"), cube("far", 9.0), cube("b", 0.9), cube("c", 0.9, 0.9)]
    assert grouped(chain) == [(["a", "b", "c"], False, False), (["far"], False, False)]


@pytest.mark.parametrize(
    ("x", "y", "count"), [(0.998, 0.0, 1), (0.9995, 0.0, 2), (1.1, 0.0, 2), (0.5, -0.9995, 2)]
)
def test_what_only_touches_does_not_overlap(x: float, y: float, count: int) -> None:
    assert len(grouped([cube("a"), cube("b", x, y)])) == count
    assert len(grouped([cube("b", x, y), cube("a")])) == count


def test_what_a_joint_connects_holds_by_that_alone() -> None:
    """Gazebo lets links of one model pass through each other."""
    inside = [cube("a"), cube("b", 0.1), cube("post", 5.0, static=True)]
    swinging = grouped(inside, ("revolute", "post", "b"))
    assert swinging == [(["post"], True, False), (["a"], False, False), (["b"], False, True)]


def test_fixed_joints_hold_links_together_however_far() -> None:
    links = apart("a", "b", "c", "d")
    pairs = ("fixed", "c", "a"), ("fixed", "d", "b")
    assert grouped(links, *pairs) == [(["a", "c"], False, False), (["b", "d"], False, False)]
    assert grouped(links, *pairs, ("fixed", "a", "b")) == [(["a", "b", "c", "d"], False, False)]


@pytest.mark.parametrize("ends", [("world", "a"), ("a", "world")])
def test_what_is_fixed_to_the_world_stands_fast_with_what_it_holds(ends: tuple[str, str]) -> None:
    found = grouped(apart("b", "a", "c"), ("fixed", *ends), ("fixed", "a", "b"))
    assert found == [(["b", "a"], True, False), (["c"], False, False)]


@pytest.mark.parametrize("kind", [Kind.PLANE, Kind.TERRAIN])
def test_grounds_and_static_links_stand_fast_and_take_nobody_along(kind: Kind) -> None:
    shape = Shape(kind) if kind is Kind.PLANE else Shape(kind, (9.0, 9.0, 1.0))
    xml = sdf_file()
    ground = SdfLink(xml.root, xml, "ground", ORIGIN, False, False, None, [Part(shape)])
    found = grouped([cube("a"), ground, cube("still", 0.2, static=True)])
    assert found == [(["ground", "still"], True, False), (["a"], False, False)]


@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic"])
@pytest.mark.parametrize("ends", [("frame", "leaf"), ("leaf", "frame"), ("world", "leaf")])
def test_what_one_joint_holds_to_what_stands_fast_swings(kind: str, ends: tuple[str, str]) -> None:
    notes = sdf_file()
    links = [cube("leaf"), cube("knob", 2.0), cube("frame", 4.0, static=True)]
    found = grouped(links, (kind, *ends), ("fixed", "leaf", "knob"), notes=notes)
    assert found == [(["frame"], True, False), (["leaf", "knob"], False, True)]
    assert not notes.notes


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("revolute", "frame", "leaf"), "held by 2 joints (revolute)"),
        (("prismatic", "world", "leaf"), "held by 2 joints (prismatic, revolute)"),
    ],
)
def test_what_two_joints_hold_stands_fast(more: tuple[str, ...], said: str) -> None:
    notes = sdf_file()
    links = [cube("leaf"), cube("frame", 4.0, static=True)]
    assert grouped(links, DOOR, more, notes=notes) == [
        *((["frame"], True, False), (["leaf"], True, False))
    ]
    assert texts(notes.notes) == (f"model 'm': stands fast, {said}",)


def test_a_joint_of_a_kind_that_is_not_simulated_holds_fast() -> None:
    notes = sdf_file()
    links = [cube("leaf"), cube("frame", 4.0, static=True)]
    assert grouped(links, ("screw", "frame", "leaf"), notes=notes)[1] == (["leaf"], True, False)
    assert texts(notes.notes) == ("model 'm': stands fast, held by 1 joints (screw)",)


@pytest.mark.parametrize(("upper", "fast"), [(0.0, True), (0.1, False), (-1.0, True)])
def test_a_joint_without_play_holds_fast(upper: float, fast: bool) -> None:
    limits = f"<limit><lower>0</lower><upper>{upper}</upper></limit>"
    links = [cube("leaf"), cube("frame", 4.0, static=True)]
    assert grouped(links, (*DOOR, limits))[1] == (["leaf"], fast, not fast)


def test_a_broken_joint_holds_fast_and_is_said() -> None:
    notes = sdf_file()
    links = [cube("leaf"), cube("frame", 4.0, static=True)]
    words = (*DOOR, "<dynamics><damping>x</damping></dynamics>")
    assert grouped(links, words, notes=notes)[1] == (["leaf"], True, False)
    assert texts(notes.notes)[0].startswith("model 'm' joint 'frame-leaf' is left out")


def hung(
    links: list[SdfLink], *joints: tuple[str, ...], notes: XmlFile, driven: tuple[str, ...] = ()
) -> dict[str, str | None]:
    """Return of each group's first link that of the group it hangs on; "world", or None if free."""
    groups = rigid_groups(notes, "model 'm'", links, [joint(*words) for words in joints], driven)
    names = [group.links[0].name for group in groups]
    assert all(group.on is None or group.on < i for i, group in enumerate(groups))
    return {
        name: None if group.hinge is None else "world" if group.on is None else names[group.on]
        for name, group in zip(names, groups, strict=True)
    }


@pytest.mark.parametrize("is_turned", [False, True])
@pytest.mark.parametrize("top", ["", "world", "frame"])
@pytest.mark.parametrize("count", [2, 3, 6])
@pytest.mark.parametrize("is_star", [False, True])
def test_links_in_chains_hang_on_each_other(
    is_star: bool, count: int, top: str, is_turned: bool
) -> None:
    """A door was one piece with its handle, a cart with its wheels, a chest with its drawers."""
    names = [f"l{i}" for i in range(count)]
    above = {name: names[0] if is_star else names[i] for i, name in enumerate(names[1:])}
    pairs = [*above.items(), *([(names[0], top)] if top else [])]
    ends = [pair if is_turned else pair[::-1] for pair in pairs]
    notes, links = sdf_file(), apart(*names)
    links += [cube("frame", 40.0, static=True)] * (top == "frame")
    found = hung(links, *(("revolute", *each) for each in ends), notes=notes)
    assert found == {**above, names[0]: top or None} | ({"frame": None} if top == "frame" else {})
    assert not notes.notes


@pytest.mark.parametrize(
    ("joints", "driven"),
    [
        ([("screw", "a", "b"), ("revolute", "b", "c")], ()),
        ([("revolute", "a", "b"), ("revolute", "b", "c")], ("a-b",)),
        ([("revolute", "a", "b", "<limit><lower>0</lower><upper>0</upper></limit>")], ()),
        ([("revolute", "a", "b"), ("prismatic", "a", "b")], ()),
        ([("revolute", "a", "b"), ("revolute", "b", "c"), ("revolute", "c", "a")], ()),
        ([("revolute", "a", "b"), ("revolute", "a", "world"), ("revolute", "b", "world")], ()),
    ],
)
def test_what_cannot_hang_holds_together_and_that_is_said(
    joints: list[tuple[str, ...]], driven: tuple[str, ...]
) -> None:
    notes = sdf_file()
    found = hung(apart("a", "b", "c"), *joints, notes=notes, driven=driven)
    assert "b" not in found
    (said,) = (text for text in texts(notes.notes) if "hold together" in text)
    assert said.startswith("model 'm': its links hold together as one body at a-b")


def test_what_nothing_can_touch_goes_with_what_it_hangs_on() -> None:
    notes, (cart, knob) = sdf_file(), apart("cart", "knob")
    knob.solid.clear()
    assert hung([cart, knob], ("revolute", "cart", "knob"), notes=notes) == {"cart": None}


def test_a_joint_within_one_body_or_of_what_stands_fast_changes_nothing() -> None:
    links = [*apart("a", "b"), cube("frame", 9.0, static=True), cube("post", 12.0, static=True)]
    bolted = ("fixed", "a", "b")
    assert grouped(links, bolted, ("revolute", "a", "b"))[1] == (["a", "b"], False, False)
    found = grouped(links, ("revolute", "frame", "post"))
    assert found == [(["frame", "post"], True, False), (["a"], False, False), (["b"], False, False)]


def test_joints_of_links_that_are_not_there_hold_nothing() -> None:
    found = grouped(apart("a", "b"), ("fixed", "world", "none"), ("fixed", "a", "none"))
    assert found == [(["a"], False, False), (["b"], False, False)]


QUARTER = math.pi / 2
LEAF = Pose3.from_rpy((1.0, 0.0, 0.0), (0.0, 0.0, QUARTER))


def hinge(
    axis: str, kind: str = "revolute", T_axis: Pose3 = ORIGIN, own: str = "leaf", link: Pose3 = LEAF
) -> Hinge:
    """Return the hinge of a leaf on a frame, at (1, 2, 3) of the world."""
    xml = sdf_file(f"<joint name='j' type='{kind}'>{axis}</joint>")
    at = Pose3((1.0, 2.0, 3.0))
    joint = SdfJoint(xml.root[0], xml, "", kind, "frame", "leaf", at, (T_axis, T_axis))
    found = read_hinge(joint, SdfLink(xml.root, xml, "leaf", link, False, False, None), {own})
    assert found is not None
    return found


def test_axis_and_anchor_are_in_the_frame_of_what_swings() -> None:
    found = hinge("<axis><xyz>0 0 2</xyz></axis>")
    assert found.axis == pytest.approx((0.0, 0.0, 1.0))
    assert found.anchor == pytest.approx((2.0, 0.0, 3.0))  # ahead of the leaf, which looks left
    along_x = hinge("<axis><xyz>3 0 4</xyz></axis>")
    assert along_x.axis == pytest.approx((0.0, -0.6, 0.8))
    turned = hinge("<axis><xyz>1 0 0</xyz></axis>", T_axis=Pose3.from_rpy((9, 9, 9), (0, 0, 0.3)))
    assert turned.axis == pytest.approx((math.sin(0.3), -math.cos(0.3), 0.0))
    assert hinge("<axis/>").axis == pytest.approx((0.0, 0.0, 1.0))  # where it is not told


def test_a_ball_turns_about_any_axis_and_a_universal_joint_about_two() -> None:
    ball = hinge("", "ball")
    assert (ball.axis, ball.further, ball.limits) == (None, None, None)
    assert ball.anchor == pytest.approx((2.0, 0.0, 3.0))
    two = "<axis><xyz>0 0 1</xyz></axis><axis2><xyz>1 0 0</xyz>{}</axis2>"
    limit = "<limit><lower>-1</lower><upper>{}</upper></limit>"
    found = hinge(two.format(limit.format(2)), "universal")
    assert found.axis == pytest.approx((0.0, 0.0, 1.0))
    assert found.further is not None
    assert found.further.axis == pytest.approx((0.0, -1.0, 0.0))
    assert (found.limits, found.further.limits) == (None, (-1.0, 2.0))
    # Of a parent that swings the child's axis comes first.
    found = hinge(two.format(""), "revolute2", own="frame")
    assert found.axis == pytest.approx((0.0, 1.0, 0.0))
    assert found.further is not None
    assert found.further.axis == pytest.approx((0.0, 0.0, -1.0))
    assert hinge(two.format(limit.format(-1)), "universal").further is None  # it has no play


def test_a_parent_that_swings_turns_in_reverse() -> None:
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


def test_its_friction_and_damping_never_push() -> None:
    given = "<axis><dynamics><damping>{}</damping><friction>{}</friction></dynamics></axis>"
    assert (hinge(given.format(3, 2)).damping, hinge(given.format(3, 2)).friction) == (3.0, 2.0)
    assert (hinge(given.format(-3, -2)).damping, hinge(given.format(-3, -2)).friction) == (0.0, 0.0)
    assert (hinge("<axis/>").damping, hinge("<axis/>").friction) == (0.0, 0.0)


def test_a_spring_brings_it_back() -> None:
    spring = "<spring_stiffness>{}</spring_stiffness><spring_reference>-0.2</spring_reference>"
    found = hinge(f"<axis><dynamics>{spring.format(3)}</dynamics></axis>")
    assert (found.stiffness, found.spring_at) == (3.0, -0.2)
    assert hinge(f"<axis><dynamics>{spring.format(-3)}</dynamics></axis>").stiffness == 0.0
    assert hinge("<axis/>").stiffness == 0.0


@pytest.mark.parametrize(
    ("axis", "problem"),
    [
        ("", "lacks <axis>"),
        ("<axis><xyz>0 0 0</xyz></axis>", "joint 'j'.*axis must not be zero"),
        ("<axis><xyz>1 0</xyz></axis>", "joint 'j' <xyz>.*has 2 numbers"),
        ("<axis><xyz>1.5e308 1.5e308 0</xyz></axis>", "axis must not be zero"),
        ("<axis><limit><lower>a</lower></limit></axis>", "joint 'j' <lower>: 'a' is no number"),
    ],
)
def test_a_hinge_without_an_axis_is_refused(axis: str, problem: str) -> None:
    with pytest.raises(WorldError, match=problem):
        hinge(axis)
