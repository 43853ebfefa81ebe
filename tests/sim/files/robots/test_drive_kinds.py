"""The kinds of drives, by plugins, names and wheels: sides, rollers and steering."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.twist import Velocity
from arjuna_sim.files.robots.drive_kinds import (
    omni_drive,
    steering_joints,
    with_mecanum,
    with_steering,
)
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.model.settings import DriveKind, DriveSettings
from arjuna_sim.model.urdf import Joint, Link, Mimic, Urdf
from tests.sim import drive_cases as cases
from tests.sim.builders import run, simulator, texts, urdf_file
from tests.sim.files.test_robots import FOUR, LEFT, _robot
from tests.sim.robot_files.tags import sides
from tests.sim.wheeled import NAMES, wheeled

SIDES = sides("front", "rear")


@pytest.mark.parametrize(
    ("wheels", "file", "inside", "said"),
    [
        (FOUR, "libgazebo_ros_omni_drive.so", "", "wheels' axes are parallel"),
        (FOUR, "gz-sim-ackermann-steering-system", SIDES, "no joint steers a wheel"),
        (FOUR, "gz-sim-diff-drive-system", SIDES, ""),
    ],
)
def test_drive_that_is_simulated_as_another_says_so(
    tmp_path: Path, wheels: str, file: str, inside: str, said: str
) -> None:
    path = _robot(tmp_path, wheels + cases.plugin(file, inside))
    robot = load_robot(path, SearchPath())
    assert robot.drive.kind is DriveKind.SIDES
    given = [note for note in texts(robot.notes) if "of its two sides" in note]
    assert len(given) == (1 if said else 0)
    assert not said or said in given[0]
    last = run(simulator(robot=path), 1.5, Velocity(0.3, y=0.3))
    assert last.truth.v == pytest.approx(0.3, rel=0.1)
    assert abs(last.truth.side) < 0.01


@pytest.mark.parametrize("file", ["gz-sim-diff-drive-system", ""])
def test_wheels_that_gazebo_would_roll_backward_are_said(tmp_path: Path, file: str) -> None:
    path = cases.Robot(cases.four(), cases.plugin(file, SIDES) if file else "").write(tmp_path)
    path.write_text(
        path.read_text("utf-8").replace("<axis xyz='0 0 1'/>", "<axis xyz='0 0 -1'/>", 1)
    )
    said = [note for note in texts(load_robot(path, SearchPath()).notes) if "backward" in note]
    assert len(said) == bool(file)
    assert not said or said[0].startswith("joint 'front_left_wheel_joint': axes point to the right")
    assert run(simulator(robot=path), 1.0, Velocity(0.3)).truth.v == pytest.approx(0.3, rel=0.1)


def test_robot_moved_in_the_plane_says_by_what(tmp_path: Path) -> None:
    path = cases.planar().write(tmp_path)
    slips = "<gazebo reference='front_left_mecanum_wheel'><mu1>0.01</mu1></gazebo></robot>"
    path.write_text(path.read_text().replace("</robot>", slips))
    robot = load_robot(path, SearchPath())
    assert any("moved in the plane: it moves by mecanum wheels" in n for n in texts(robot.notes))
    assert any("its friction 0.01 would slip; it gets 0.8" in n for n in texts(robot.notes))
    assert robot.settings.friction["front_left_mecanum_wheel"] == 0.8


@pytest.mark.parametrize(
    "tags",
    [
        "<mu1>0.7</mu1><mu2>0</mu2><fdir1>1 {sign} 0</fdir1>",
        "<collision><surface><friction><ode><mu>0.7</mu><mu2>0</mu2><fdir1>1 {sign} 0</fdir1></ode>"
        "</friction></surface></collision>",
    ],
)
def test_file_says_in_which_direction_rollers_grip(tmp_path: Path, tags: str) -> None:
    """They must let the robot drive in any direction."""
    path = cases.mecanum().write(tmp_path)
    rubbing = "".join(
        f"<gazebo reference='{end}_{side}_wheel'>{tags.format(sign=sign)}</gazebo>"
        for end, side, sign in (
            ("front", "left", -1),
            ("front", "right", 1),
            ("rear", "left", 1),
            ("rear", "right", -1),
        )
    )
    standard = load_robot(path, SearchPath())
    path.write_text(path.read_text().replace("</robot>", f"{rubbing}</robot>"))
    given = load_robot(path, SearchPath())
    assert np.allclose(given.drive.grips, standard.drive.grips)
    assert given.settings.friction["front_left_wheel"] == 0.7
    assert not any(
        word in note for note in texts(given.notes) for word in ("mu2", "fdir1", "<coll")
    )
    path.write_text(path.read_text().replace("<fdir1>1 -1 0", "<fdir1>1 1 0"))
    odd = load_robot(path, SearchPath())
    assert odd.drive.grips == standard.drive.grips
    assert any("do not let mecanum wheels drive" in note for note in texts(odd.notes))


def test_friction_of_two_directions_is_noted_without_rollers(tmp_path: Path) -> None:
    rubbing = "<gazebo reference='front_left_wheel'><mu1>1</mu1><mu2>0</mu2></gazebo>"
    robot = load_robot(_robot(tmp_path, FOUR + rubbing), SearchPath())
    assert set(robot.drive.left) == set(LEFT)
    assert any("<mu2> is taken to be <mu1>" in note for note in texts(robot.notes))


def test_casters_do_not_steer(tmp_path: Path) -> None:
    """A wheel that swivels with limits is a caster where its name says so."""
    robot = cases.Robot((*cases.four()[:2], cases.Wheel("caster", -0.15, 0.0, steered=True)))
    drive = load_robot(robot.write(tmp_path), SearchPath()).drive
    assert (drive.kind, drive.steering, drive.free) == (DriveKind.SIDES, (), ())


UP = (0.0, 0.0, 1.0)
WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
STEERS = ("left_steer", "right_steer")
HALF = math.sqrt(0.5)


def car(trail: float = 0.0, drop: float = 0.0, **steer: Any) -> Urdf:
    """Return a car whose front wheels are on joints that steer.

    Args:
        trail: How far the front wheels are behind these [m].
        drop: How far below the rear ones [m].
        steer: What the left of these joints is otherwise.
    """
    positions = ((-trail, 0.0, -drop), (-trail, 0.0, -drop), (-0.5, 0.3, 0.0), (-0.5, -0.3, 0.0))
    urdf = wheeled(positions, names=WHEELS)
    joints, links = dict(urdf.joints), dict(urdf.links)
    for i, (name, y) in enumerate(zip(STEERS, (0.3, -0.3), strict=True)):
        hub = f"hub{i}"
        links[hub] = Link(hub, None, (), ())
        at = Pose3((0.5, y, 0.0))
        joints[name] = Joint(name, "revolute", "base", hub, at, UP, (-0.6, 0.8))
        joints[WHEELS[i]] = replace(joints[WHEELS[i]], parent=hub)
    left = replace(joints.pop(STEERS[0]), **steer)
    joints = {left.name: left, **joints}
    return Urdf(urdf.path, "r", "", "base", links, joints)


def tilted(angle: float) -> tuple[float, float, float]:
    return (math.sin(angle), 0.0, math.cos(angle))


@pytest.mark.parametrize(
    ("how", "steers"),
    [
        ({}, True),
        ({"axis": (0.0, 0.0, -1.0)}, True),
        ({"axis": tilted(0.78)}, True),  # 45 degrees off the vertical
        ({"axis": tilted(0.8)}, False),
        ({"kind": "fixed"}, False),
        ({"kind": "prismatic"}, False),
        ({"kind": "continuous"}, True),
        ({"kind": "continuous", "trail": 0.0099}, True),
        ({"kind": "continuous", "trail": 0.0101}, False),  # a caster's wheel trails
        ({"kind": "revolute", "trail": 0.05}, True),
        ({"mimic": Mimic("right_steer", 1.0)}, True),
        ({"mimic": Mimic("right_steer", -1.0)}, False),
        ({"name": "left_caster_steer"}, False),
        ({"name": "left_joint"}, True),  # of any name, with limits
        ({"name": "left_joint", "trail": 0.05}, False),
        ({"name": "left_joint", "kind": "continuous"}, False),
        ({"name": "swerve_left_joint", "kind": "continuous"}, True),
        ({"child": "nothing"}, False),
    ],
)
def test_a_joint_steers_that_turns_a_wheel_upright(how: dict[str, Any], steers: bool) -> None:
    if "child" in how:
        urdf = car()
        urdf.links["nothing"] = Link("nothing", None, (), ())
        extra = replace(urdf.joints["left_steer"], name="third_steer", child="nothing")
        urdf.joints["third_steer"] = extra
        assert steering_joints(urdf) == STEERS
        return
    left = str(how.get("name", "left_steer"))
    assert steering_joints(car(**how)) == ((left, "right_steer") if steers else ("right_steer",))


@pytest.mark.parametrize("behind", [0.0, 0.02], ids=["axle", "trailer"])
def test_a_joint_above_an_axle_of_two_wheels_steers_it(behind: float) -> None:
    urdf = wheeled(((-behind, 0.3, 0.0), (-behind, -0.3, 0.0), (-0.5, 0.3, 0.0), (-0.5, -0.3, 0.0)))
    joints, links = dict(urdf.joints), dict(urdf.links)
    links["axle"] = Link("axle", None, (), ())
    at = Pose3((0.5, 0.0, 0.0))
    for name in list(joints)[:2]:
        joints[name] = replace(joints[name], parent="axle")
    joints["pivot"] = Joint("pivot", "revolute", "base", "axle", at, UP, (-0.6, 0.6))
    found = steering_joints(Urdf(urdf.path, "r", "", "base", links, joints))
    assert found == (() if behind else ("pivot",))


def drive(**given: Any) -> DriveSettings:
    sides = DriveSettings(WHEELS[::2], WHEELS[1::2], 0.6, 0.1, 1.0, 0.6, 0.1)
    return replace(sides, **given)


def test_wheels_that_are_not_steered_drive_and_the_others_roll() -> None:
    found = with_steering(urdf_file(), car(), drive())
    assert found is not None
    assert found.kind is DriveKind.STEERED
    assert (found.left, found.right) == (("rear_left",), ("rear_right",))
    assert (found.steering, found.free) == (STEERS, ("front_left", "front_right"))
    assert found.steering_limit == 0.6  # the narrowest
    all_driven = with_steering(urdf_file(), car(), drive(plugin="ackermann"))
    assert all_driven is not None
    assert (all_driven.left, all_driven.free) == (WHEELS[::2], ())
    front = with_steering(urdf_file(), car(), drive(left=WHEELS[:1], right=WHEELS[1:2]))
    assert front is not None
    assert front.wheels == WHEELS[:2]  # where none else drives
    assert with_steering(urdf_file(), car(), drive(left=(), right=())) is None
    assert (
        with_steering(urdf_file(), wheeled(names=WHEELS), drive(left=WHEELS[:1], right=())) is None
    )


@pytest.mark.parametrize(("drop", "rolls"), [(0.019, True), (0.021, False), (-0.021, False)])
def test_a_wheel_off_the_ground_does_not_roll(drop: float, rolls: bool) -> None:
    found = with_steering(urdf_file(), car(drop=drop), drive())
    assert found is not None
    assert found.free == (WHEELS[:2] if rolls else ())


def test_a_wheel_that_is_only_drawn_rolls_beside_steered_ones() -> None:
    urdf = car()
    child = urdf.joints[WHEELS[0]].child
    link = urdf.links[child]
    for visuals, free in ((link.collisions, WHEELS[:2]), ((), WHEELS[1:2])):
        urdf.links[child] = replace(link, collisions=(), visuals=visuals)
        found = with_steering(urdf_file(), urdf, drive())
        assert found is not None
        assert found.free == free


@pytest.mark.parametrize(
    ("limits", "given", "expected"),
    [
        ((-0.6, 0.8), 0.0, 0.6),
        ((-0.6, 0.3), 0.0, 0.3),
        ((-0.6, 0.8), 0.4, 0.4),
        ((-0.6, 0.8), 0.9, 0.6),
        ((-0.01, 0.01), 0.0, 0.05),
        ((-3.0, 3.0), 0.0, 0.6),  # the other's
    ],
)
def test_steering_goes_as_far_as_its_narrowest_joint(
    limits: tuple[float, float], given: float, expected: float
) -> None:
    found = with_steering(urdf_file(), car(limits=limits), drive(steering_limit=given))
    assert found is not None
    assert found.steering_limit == expected
    free = with_steering(urdf_file(), car(limits=None), drive(steering=("left_steer",)))
    assert free is not None
    assert (free.steering, free.steering_limit) == (("left_steer",), 1.4)


def test_a_joint_that_mimics_the_other_is_noted() -> None:
    xml = urdf_file()
    assert with_steering(xml, car(mimic=Mimic("right_steer")), drive()) is not None
    (note,) = xml.notes
    assert (
        note.text
        == "joint 'left_steer': steers its own wheel, so that none slides, and mimics none"
    )


CORNERS = ((0.2, 0.2, 0.0), (0.2, -0.2, 0.0), (-0.2, 0.2, 0.0), (-0.2, -0.2, 0.0))
X = {"a": (HALF, -HALF), "b": (HALF, HALF), "c": (HALF, HALF), "d": (HALF, -HALF)}


def mecanum(
    given: Mapping[str, tuple[float, float]], front: float = 0.2
) -> tuple[dict[str, tuple[float, float]] | None, list[str]]:
    """Return how each of four wheels grips, and what is noted."""
    urdf, xml = wheeled([(front, *CORNERS[0][1:]), *CORNERS[1:]]), urdf_file()
    sides = DriveSettings(("a", "c"), ("b", "d"), 0.4, 0.1, 1.0, 0.4, 0.1)
    found = with_mecanum(xml, urdf, sides, given)
    notes = [note.text for note in xml.notes]
    return (None if found is None else dict(zip(found.wheels, found.grips, strict=True))), notes


def test_mecanum_wheels_grip_as_an_x_unless_their_file_says_better() -> None:
    assert mecanum({}) == (X, [])
    steep = {name: (0.6, math.copysign(0.8, y)) for name, (_, y) in X.items()}
    assert mecanum(steep) == (steep, [])
    doubt = "its <fdir1> do not let mecanum wheels drive: their rollers are those of an X"
    assert mecanum(dict.fromkeys(X, (0.6, 0.8))) == (X, [doubt])  # not across that
    assert mecanum({"a": (0.6, -0.8)}) == (X, [doubt])  # of one alone
    across = {name: (0.0, math.copysign(1.0, y)) for name, (_, y) in X.items()}
    assert mecanum(across) == (X, [doubt])  # their motors would move nothing
    assert mecanum({}, front=-0.181)[0] is None  # no front and rear
    assert mecanum({}, front=-0.179)[0] is not None
    two = DriveSettings(("a",), ("b", "d"), 0.4, 0.1, 1.0, 0.4, 0.1)
    assert with_mecanum(urdf_file(), wheeled(CORNERS), two, {}) is None


@pytest.mark.parametrize(("spread", "is_omni"), [(0.24, False), (0.25, True)])
def test_three_wheels_whose_axes_spread_are_omni_wheels(spread: float, is_omni: bool) -> None:
    urdf = wheeled([(0.3, 0.0, 0.0), (-0.3, 0.3, 0.0), (-0.3, -0.3, 0.0)])
    urdf.joints["c"] = replace(urdf.joints["c"], axis=(math.sin(spread), math.cos(spread), 0.0))
    found = omni_drive(urdf, NAMES[:3])  # 0.97 is the cosine of 0.2456
    assert (found is not None) is is_omni
    assert omni_drive(urdf, NAMES[:2]) is None
    if found is not None:
        assert (found.kind, found.wheels) == (DriveKind.OMNI, NAMES[:3])
        assert found.grips[0] == pytest.approx((1.0, 0.0))
        assert found.grips[2] == pytest.approx((math.cos(spread), -math.sin(spread)))
        assert found.separation == pytest.approx(2.0 * math.hypot(0.3, 0.3))
        urdf.joints["a"] = replace(urdf.joints["a"], axis=(0.0, 0.9, 0.31))
        assert omni_drive(urdf, NAMES[:3]) is None  # one lies
