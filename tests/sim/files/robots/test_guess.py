"""Which joints are the wheels of the two sides, where a file names none."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_sim.files.robots.guess import guess_drive, guess_sides
from arjuna_sim.files.robots.plugins import NO_DRIVE
from arjuna_sim.files.urdf.gazebo import read_tags
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.urdf import Joint, Link, Mimic, Urdf
from tests.sim.builders import urdf_file
from tests.sim.wheeled import ALONG_Y, wheeled

CORNERS = ((0.2, 0.15, 0.0), (0.2, -0.15, 0.0), (-0.2, 0.15, 0.0), (-0.2, -0.15, 0.0))
SIDES = ("front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel")
PAIRS = (SIDES[::2], SIDES[1::2])


def guessed(urdf: Urdf, inside: str = "") -> tuple[tuple[str, ...], tuple[str, ...]]:
    xml = urdf_file(inside)
    return guess_sides(xml, urdf, read_tags(xml, urdf).controlled)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_sides_are_where_wheels_stand_wherever_their_axes_point(sign: float) -> None:
    assert guessed(wheeled(CORNERS, along=(0.0, sign, 0.0), names=SIDES)) == PAIRS
    aside = [(x, y + 0.5, z) for x, y, z in CORNERS]  # of a root that is not in the middle
    assert guessed(wheeled(aside, along=(0.0, sign, 0.0), names=SIDES)) == PAIRS
    plain = wheeled(CORNERS, along=(0.0, sign, 0.0))
    assert guessed(plain) == (("a", "c"), ("b", "d"))


def test_names_say_which_side_is_left_of_a_robot_that_looks_back() -> None:
    back = [(x, -y, z) for x, y, z in CORNERS]
    assert guessed(wheeled(back, names=SIDES)) == PAIRS
    short = ("wheel_fl", "wheel_fr", "wheel_rl", "wheel_rr")
    assert guessed(wheeled(back, names=short)) == (short[::2], short[1::2])


def test_a_robot_that_looks_back_drives_ahead_of_its_base() -> None:
    xml = urdf_file()
    drive = guess_drive(xml, wheeled([(x, -y, z) for x, y, z in CORNERS], names=SIDES))
    assert (drive.left, drive.right) == PAIRS[::-1]
    assert drive.effective_track == pytest.approx(0.3 * (1.0 + (0.4 / 0.3) ** 2), rel=0.01)
    assert "left and right are exchanged" in next(iter(xml.notes)).text


@pytest.mark.parametrize(
    ("along", "rpy", "left"),
    [((1.0, 0.0, 0.0), (0, 0, math.pi / 2), -1.0), ((0.0, 0.0, 1.0), (math.pi / 2, 0, 0), -1.0)],
)
def test_without_names_it_looks_where_it_turns_least(
    along: tuple[float, float, float], rpy: tuple[float, float, float], left: float
) -> None:
    tyre = Part(Shape(Kind.BOX, (0.2, 0.2, 0.2)))
    positions = [tuple(left * s * 0.2 * np.array(along)) for s in (1.0, -1.0)]
    x, y, z = along
    for axis in (along, (-x, -y, -z)):
        assert guessed(wheeled(positions, (tyre,), axis)) == (("a",), ("b",))


@pytest.mark.parametrize(
    ("x", "z", "radius", "pairs"),
    [
        (0.029, 0.0, 0.1, True),  # 0.3 radii off
        (0.031, 0.0, 0.1, False),
        (0.0, 0.029, 0.1, True),
        (0.0, 0.031, 0.1, False),
        (0.0, 0.0, 0.109, True),  # a tenth larger
        (0.0, 0.0, 0.112, False),
    ],
)
def test_wheels_pair_with_equal_opposites(x: float, z: float, radius: float, pairs: bool) -> None:
    urdf = wheeled([(0.0, 0.2, 0.0), (x, -0.2, z)])
    tyre = Part(Shape(Kind.CYLINDER, (radius, 0.04)), ALONG_Y)
    urdf.links["b"] = Link("b", None, (tyre,), ())
    xml = urdf_file()
    found = guess_sides(xml, urdf)
    assert found == ((("a",), ("b",)) if pairs else ((), ()))
    said = [f"joint '{n}': turns freely: it has no partner on the other side" for n in "ab"]
    assert [note.text for note in xml.notes] == ([] if pairs else said)


def test_small_wheels_may_be_two_centimetres_off() -> None:
    tiny = Part(Shape(Kind.CYLINDER, (0.02, 0.01)), ALONG_Y)
    assert guessed(wheeled([(0.0, 0.1, 0.0), (0.019, -0.1, 0.0)], (tiny,))) == (("a",), ("b",))
    assert guessed(wheeled([(0.0, 0.1, 0.0), (0.021, -0.1, 0.0)], (tiny,))) == ((), ())


def test_a_wheel_in_the_middle_or_askew_is_of_no_side() -> None:
    middle = [(0.0, 0.2, 0.0), (0.0, -0.2, 0.0), (0.0, 0.004, 0.0)]
    assert guessed(wheeled(middle)) == (("a",), ("b",))
    askew = wheeled([(0.0, 0.2, 0.0), (0.0, -0.2, 0.0)])
    for angle, pairs in ((0.44, True), (0.46, False)):  # cosine 0.905 and 0.896
        direction = (math.sin(angle), math.cos(angle), 0.0)
        askew.joints["b"] = replace(askew.joints["b"], axis=direction)
        assert guessed(askew) == ((("a",), ("b",)) if pairs else ((), ()))


@pytest.mark.parametrize(
    ("kind", "trail", "drives"),
    [("continuous", 0.02, False), ("continuous", 0.0, True), ("revolute", 0.02, True)],
)
def test_wheels_that_trail_what_turns_freely_are_casters(
    kind: str, trail: float, drives: bool
) -> None:
    made = wheeled(CORNERS, names=SIDES)
    joints, links = dict(made.joints), dict(made.links)
    for name in SIDES[2:]:
        fork, T = f"{name}_fork", joints[name].T_parent_child
        links[fork] = Link(fork, None, (), ())
        joints[name] = replace(joints[name], parent=fork, T_parent_child=Pose3((-trail, 0.0, 0.0)))
        joints[fork] = Joint(fork, kind, "base", fork, T, (0.0, 0.0, 1.0), (-1.0, 1.0))
    assert guessed(replace(made, joints=joints, links=links)) == (
        PAIRS if drives else (SIDES[:1], SIDES[1:2])
    )


def test_wheels_are_what_is_controlled_else_named_so_else_all_that_turns() -> None:
    names = ("wheel_a", "wheel_b", "disc_a", "disc_b")
    sides = [CORNERS[0], CORNERS[1], CORNERS[2], CORNERS[3]]
    urdf = wheeled(sides, names=names)
    assert guessed(urdf) == (("wheel_a",), ("wheel_b",))
    control = "<ros2_control>{}</ros2_control>".format(
        "".join(
            f"<joint name='disc_{n}'><command_interface name='velocity'/></joint>" for n in "ab"
        )
    )
    assert guessed(urdf, control) == (("disc_a",), ("disc_b",))
    one = control.replace("disc_b", "none")
    assert guessed(urdf, one) == (("wheel_a",), ("wheel_b",))  # one alone is no drive
    effort = control.replace("velocity", "effort")
    assert guessed(urdf, effort) == (("wheel_a",), ("wheel_b",))
    old = "<transmission><joint name='disc_a'/><joint name='disc_b'/>{}</transmission>"
    by = "<hardwareInterface>hardware_interface/{}JointInterface</hardwareInterface>"
    assert guessed(urdf, old.format(by.format("Velocity"))) == (("disc_a",), ("disc_b",))
    assert guessed(urdf, old.format(by.format("Effort"))) == (("wheel_a",), ("wheel_b",))
    bare = wheeled(sides, names=("p", "q", "caster_a", "caster_b"))
    assert guessed(bare) == (("p",), ("q",))  # casters never
    for no in (
        replace(bare.joints["p"], kind="revolute"),
        replace(bare.joints["p"], mimic=Mimic("q")),
    ):
        assert guessed(replace(bare, joints={**bare.joints, "p": no})) == ((), ())
    hollow = replace(bare, links={**bare.links, "p": Link("p", None, (), ())})
    assert guessed(hollow) == ((), ())


def test_a_guess_says_what_it_is() -> None:
    xml = urdf_file()
    drive = guess_drive(xml, wheeled(CORNERS, names=SIDES))
    assert (drive.left, drive.right) == PAIRS
    assert (drive.separation, drive.radius) == pytest.approx((0.3, 0.1))
    assert drive.effective_radius == pytest.approx(0.1)
    assert drive.effective_track == pytest.approx(0.3 * (1.0 + (0.4 / 0.3) ** 2), rel=1e-3)
    assert [note.text for note in xml.notes] == [
        "no drive plugin: guessed are the wheels front_left_wheel, rear_left_wheel (left) and"
        " front_right_wheel, rear_right_wheel (right), separation 0.3 m, radius 0.1 m"
    ]
    none = urdf_file()
    assert not guess_drive(none, wheeled(CORNERS[:1])).wheels
    assert "has no drive: neither a drive plugin nor wheels on both sides" in str(list(none.notes))
    assert not guess_drive(none, wheeled(CORNERS[:1]), has_plugin=True).wheels
    assert "its drive plugin names no wheels, and there are none on both" in str(list(none.notes))


@pytest.mark.parametrize(
    ("along", "about"),
    [((0.0, 0.0, 1.0), "the vertical"), ((1.0, 0.0, 0.0), "x, as joints without <axis> do")],
)
def test_wheels_that_turn_about_no_line_across_are_named(
    along: tuple[float, float, float], about: str
) -> None:
    xml = urdf_file()
    assert guess_drive(xml, wheeled(CORNERS[:2], along=along, names=SIDES[:2])) is NO_DRIVE
    said = f"front_left_wheel, front_right_wheel: turn about {about}, as no wheel does that drives"
    assert [note.text for note in xml.notes][1:] == [said]
