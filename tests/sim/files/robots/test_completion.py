"""Masses, friction and shapes of robots, completed where their files lack them."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.check import check
from arjuna_sim.files.robots.completion import (
    bound_inertias,
    complete_casters,
    complete_masses,
    complete_shapes,
    complete_wheels,
    friction_of,
    rigid_groups,
)
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.model.geometry.shapes import Inertial, Kind, Part, Shape
from arjuna_sim.model.settings import DriveKind, DriveSettings
from arjuna_sim.model.urdf import Joint, Link, Urdf
from tests.sim import drive_cases as cases
from tests.sim.builders import texts, urdf_file
from tests.sim.wheeled import ALONG_Y

pytestmark = pytest.mark.usefixtures("without_sills")

CUBE = Part(Shape(Kind.BOX, (0.2, 0.2, 0.2)))  # of 8 litres
PLANE = Part(Shape(Kind.PLANE))
TYRE = Part(Shape(Kind.CYLINDER, (0.1, 0.04)), ALONG_Y)
DRIVE = DriveSettings(("wheel",), (), 1.0, 0.1, 1.0, 1.0, 0.1)


def link(name: str, *parts: Part, mass: float = 0.0, inertia: float = 0.0) -> Link:
    own = Inertial(mass, (0.0, 0.0, 0.0), np.eye(3) * inertia) if mass else None
    return Link(name, own, parts, ())


def robot(
    *links: Link, fixed: tuple[tuple[str, str], ...] = (), positions: dict[str, Pose3] | None = None
) -> Urdf:
    """Return a robot whose first link carries the others, by fixed joints where `fixed`."""
    root, *others = links
    parents = {child: (parent, "fixed") for parent, child in fixed}
    joints = {}
    for one in others:
        parent, kind = parents.get(one.name, (root.name, "continuous"))
        pose = (positions or {}).get(one.name, ORIGIN)
        joints[one.name] = Joint(one.name, kind, parent, one.name, pose, (0.0, 1.0, 0.0))
    return Urdf(Path("r"), "r", "", root.name, {one.name: one for one in links}, joints)


def test_a_robot_that_could_touch_nothing_is_as_solid_as_it_is_drawn() -> None:
    drawn = Link("base", None, (), (CUBE,))
    solid, bare = Link("wheel", None, (TYRE,), (CUBE,)), Link("none", None, (), ())
    xml = urdf_file()
    found = complete_shapes(xml, robot(drawn, solid, bare)).links
    assert found == {
        "base": Link("base", None, (CUBE,), (CUBE,)),
        "wheel": solid,
        "none": bare,
    }
    note = "link 'base': has no <collision>, so it is as solid as it is drawn"
    assert texts(xml.notes) == (note,)
    arm = Link("arm", None, (TYRE,), ())  # fixed: no wheel, so the robot can touch
    kept = robot(drawn, arm, fixed=(("base", "arm"),))
    assert complete_shapes(xml, kept) == kept


def test_what_marks_a_frame_is_not_solid() -> None:
    mark, small = (Part(Shape(Kind.BOX, (size, size, size))) for size in (0.002, 0.0021))
    xml = urdf_file()
    found = complete_shapes(xml, robot(link("foot", mark, small), Link("base", None, (), (mark,))))
    assert found.links["foot"].collisions == (small,)
    assert texts(xml.notes) == ()
    assert not complete_shapes(xml, robot(Link("base", None, (), (mark,)))).links["base"].collisions
    assert "no link has a shape (<collision> or <visual>): only wheels of a drive bear it" in (
        texts(xml.notes)
    )


@pytest.mark.parametrize(
    ("z", "mass", "visuals", "radius"),
    [
        (-0.07, 0.2, (), 0.03),
        (-0.101, 0.2, (), None),  # below the ground
        (0.15, 0.2, (), None),  # higher than wheels are
        (-0.07, 0.0, (), None),  # a frame alone
        (-0.07, 0.2, (CUBE,), None),
    ],
)
def test_a_caster_without_a_shape_is_a_ball_that_reaches_the_ground(
    z: float, mass: float, visuals: tuple[Part, ...], radius: float | None
) -> None:
    caster = dataclasses.replace(link("Castor_1", mass=mass), visuals=visuals)
    made = robot(
        link("base", mass=5.0),
        link("wheel", TYRE),
        caster,
        fixed=(("base", "Castor_1"),),
        positions={"Castor_1": Pose3((0.2, 0.0, z))},
    )
    xml = urdf_file()
    balls = complete_casters(xml, made, DRIVE).links["Castor_1"].collisions
    said = [] if radius is None else [pytest.approx(radius)]
    assert [part.shape.size[0] for part in balls] == said
    note = "link 'Castor_1': has no shape: a ball of radius 0.03 m is taken"
    assert texts(xml.notes) == (() if radius is None else (note,))


def test_a_wheel_without_a_shape_is_a_cylinder_about_its_axis() -> None:
    """A costmap's footprint holds it then, as that of a robot without any of its meshes."""
    xml = urdf_file()
    made = complete_wheels(xml, robot(link("base", CUBE, mass=5.0), link("wheel")), DRIVE)
    (wheel,) = made.links["wheel"].collisions
    assert np.ptp(wheel.points(ORIGIN), axis=0) == pytest.approx([0.2, 0.05, 0.2], rel=0.02)
    note = "link 'wheel': has no shape: a cylinder of radius 0.1 m is taken"
    assert texts(xml.notes) == (note,)
    drawn = robot(link("base", CUBE, mass=5.0), Link("wheel", None, (), (TYRE,)))
    assert not complete_wheels(urdf_file(), drawn, DRIVE).links["wheel"].collisions


def test_what_carries_a_driven_wheel_is_no_caster_whatever_its_name() -> None:
    """A youBot's caster_link_fl, in which its wheel turns, gets no ball beside that."""
    made = robot(link("base", mass=5.0), link("wheel", TYRE), link("caster", mass=0.2))
    joints = {**made.joints, "wheel": dataclasses.replace(made.joints["wheel"], parent="caster")}
    made = dataclasses.replace(made, joints=joints)
    assert not complete_casters(urdf_file(), made, DRIVE).links["caster"].collisions


def test_links_that_are_fixed_to_each_other_are_one_group_its_root_first() -> None:
    links = [Link(name, None, (), ()) for name in ("tip", "root", "mid", "free", "on_free")]
    chain = (("root", "mid", "fixed"), ("mid", "tip", "fixed"), ("root", "free", "continuous"))
    joints = {
        child: Joint(child, kind, parent, child, ORIGIN)
        for parent, child, kind in (*chain, ("free", "on_free", "fixed"))
    }
    urdf = Urdf(Path("r"), "r", "", "root", {one.name: one for one in links}, joints)
    assert rigid_groups(urdf) == [["root", "tip", "mid"], ["free", "on_free"]]


@pytest.mark.parametrize(
    ("own", "inner", "given"),  # of a root and of what is fixed to it [kg]
    [
        (0.0, 0.0, (4.0, 4.0)),  # 8 litres of 500 kg/m^3 each
        (1.0, 0.0, (1.0, 0.0)),  # plausible: more than 20 kg/m^3 of 16 litres
        (0.33, 0.0, (0.33, 0.0)),
        (0.31, 0.0, (0.31, 4.0)),  # as light as foam: the other's mass was forgotten
    ],
)
def test_lost_masses_are_computed(own: float, inner: float, given: tuple[float, float]) -> None:
    xml = urdf_file()
    urdf = robot(
        link("base", CUBE, mass=own), link("top", CUBE, mass=inner), fixed=(("base", "top"),)
    )
    links = complete_masses(xml, urdf).links
    found = [0.0 if (i := links[n].inertial) is None else i.mass for n in ("base", "top")]
    assert found == pytest.approx(given)
    new = [
        n
        for n, before, now in zip(("base", "top"), (own, inner), found, strict=True)
        if now != before
    ]
    assert [note.split(":")[0] for note in texts(xml.notes)] == [f"link '{name}'" for name in new]


def test_what_moves_and_has_neither_mass_nor_shape_weighs_ten_grams() -> None:
    drawn = Link("bare", None, (), (PLANE, CUBE))
    xml = urdf_file()
    urdf = robot(link("base", CUBE, mass=5.0), drawn, link("massive", mass=2.0))
    found = complete_masses(xml, urdf).links
    own = found["bare"].inertial
    assert own is not None
    assert own.mass == 0.01
    np.testing.assert_allclose(own.inertia, np.eye(3) * 0.01 * 0.2**2 / 6.0, atol=1e-9)
    massive = found["massive"].inertial
    assert massive is not None
    assert massive.mass == 2.0
    note = "link 'bare': has neither mass nor solid shape: it gets 0.01 kg"
    assert texts(xml.notes) == (note,)


# A wheel of 0.5 kg and 0.1 m, whose own inertia is 0.0025 kg m^2 about its axis. All its mass at
# its farthest corner, 0.1 m out and 0.02 m aside, has 0.5 * 0.0104 kg m^2, which is taken fourfold.
MOST = 4.0 * 0.5 * (0.1**2 + 0.02**2)


@pytest.mark.parametrize(
    ("said", "taken"), [(1.0, False), (1.02 * MOST, False), (0.98 * MOST, True), (0.002, True)]
)
def test_an_inertia_beyond_its_shapes_reach_is_a_placeholder(said: float, taken: bool) -> None:
    wheel = link("wheel", TYRE, mass=0.5, inertia=said)
    position = {"wheel": Pose3((3.0, 2.0, 1.0))}  # far from the root, which must not matter
    xml = urdf_file()
    urdf = robot(link("base", CUBE, mass=9.0, inertia=0.1), wheel, positions=position)
    found = bound_inertias(xml, urdf, DRIVE).links
    own, base = found["wheel"].inertial, found["base"].inertial
    assert own is not None
    assert base is not None
    assert own.mass == 0.5
    disc = np.array([0.25 * 0.1**2 + 0.04**2 / 12.0, 0.5 * 0.1**2, 0.25 * 0.1**2 + 0.04**2 / 12.0])
    expected = np.eye(3) * said if taken else np.diag(0.5 * disc)
    np.testing.assert_allclose(own.inertia, expected, atol=1e-9)
    assert np.diag(base.inertia) == pytest.approx(0.1)
    said_of = f"link 'wheel': 0.5 kg of its size cannot have an inertia of {said:.3g} kg m^2"
    noted = texts(xml.notes)
    assert [note.split(": that of")[0] for note in noted] == ([] if taken else [said_of])


def test_a_wheel_without_shapes_reaches_as_far_as_the_drive_says() -> None:
    for said, taken in ((4.1 * 0.5 * 0.1**2, False), (3.9 * 0.5 * 0.1**2, True)):
        bare = robot(link("base", CUBE, mass=9.0), link("wheel", mass=0.5, inertia=said))
        own = bound_inertias(urdf_file(), bare, DRIVE).links["wheel"].inertial
        assert own is not None
        expected = said if taken else 0.5 * 0.1**2
        np.testing.assert_allclose(own.inertia, np.eye(3) * expected)
        # What is no wheel and has no shape may have any inertia.
        other = dataclasses.replace(DRIVE, left=())
        own = bound_inertias(urdf_file(), bare, other).links["wheel"].inertial
        assert own is not None
        np.testing.assert_allclose(own.inertia, np.eye(3) * said)


def test_a_part_is_bounded_by_all_shapes_that_are_fixed_to_it() -> None:
    """A link in the middle of a part may carry the inertia of all of it."""
    rod = Part(Shape(Kind.BOX, (2.0, 0.1, 0.1)))
    wheel, rim = link("wheel", TYRE, mass=0.5, inertia=1.9), Link("rim", None, (), (PLANE, rod))
    urdf = robot(link("base", CUBE, mass=9.0), wheel, rim, fixed=(("wheel", "rim"),))
    own = bound_inertias(urdf_file(), urdf, DRIVE).links["wheel"].inertial
    assert own is not None
    np.testing.assert_allclose(own.inertia, np.eye(3) * 1.9)  # of at most 4 * 0.5 * 1.005


BALL = Part(Shape(Kind.SPHERE, (0.02,)))
SKID = Part(Shape(Kind.BOX, (0.04, 0.04, 0.04)))


def friction(
    caster: Part = BALL,
    z: float = -0.08,
    kind: DriveKind = DriveKind.SIDES,
    said: dict[str, float] | None = None,
    name: str = "skid",
    above: tuple[Part, ...] = (),
) -> tuple[dict[str, float], tuple[str, ...]]:
    """Return the friction of a robot whose wheel's lowest point is at z = -0.1, and the notes."""
    xml = urdf_file()
    urdf = robot(
        *(
            link("base", CUBE),
            link("wheel", TYRE),
            link(name, *above, caster),
            Link("air", None, (), ()),
        ),
        fixed=(("base", name), ("base", "air")),
        positions={name: Pose3((0.3, 0.0, z)), "wheel": Pose3((0.0, 0.3, 0.0))},
    )
    base = dataclasses.replace(urdf.links["base"], collisions=())
    urdf = dataclasses.replace(urdf, links={**urdf.links, "base": base})
    return friction_of(xml, urdf, said or {}, DRIVE, kind), texts(xml.notes)


@pytest.mark.parametrize(
    ("z", "slides"), [(-0.08, True), (-0.0725, True), (-0.0715, False), (-0.2, True)]
)
def test_what_is_fixed_and_no_more_than_8_mm_off_the_ground_slides(z: float, slides: bool) -> None:
    found, notes = friction(SKID, z)
    assert found == ({"skid": 0.01} if slides else {})
    assert notes == (("link 'skid': slides along on the ground, as a caster",) * slides)


@pytest.mark.parametrize(("z", "slides"), [(-0.2, True), (-0.03, True), (0.03, False)])
def test_balls_and_casters_slide_where_a_robot_may_lean_on_them(z: float, slides: bool) -> None:
    """Wherever below its axles that is: a caster that hangs too high is leant on."""
    body = Part(SKID.shape, Pose3((0.0, 0.0, 0.02)))
    for above in ((), (body,)):
        assert friction(BALL, z, above=above) == ({"skid": 0.01} if slides else {}, ())
    found, notes = friction(SKID, z, name="rear_castor")
    assert found == ({"rear_castor": 0.01} if slides else {})
    assert notes == (("link 'rear_castor': slides along on the ground, as a caster",) * slides)


def test_a_bracket_above_its_caster_s_wheel_does_not_slide() -> None:
    urdf = robot(
        *(link("base"), link("wheel", TYRE), link("caster_base", SKID)),
        *(Link("fork", None, (), ()), link("caster_wheel", BALL)),
        fixed=(("base", "caster_base"), ("base", "fork"), ("fork", "caster_wheel")),
        positions={
            "caster_base": Pose3((0.3, 0.0, -0.03)),
            "fork": Pose3((0.3, 0.0, 0.0)),
            "caster_wheel": Pose3((-0.02, 0.0, -0.08)),
            "wheel": Pose3((0.0, 0.3, 0.0)),
        },
    )
    xml = urdf_file()
    assert friction_of(xml, urdf, {}, DRIVE) == {"caster_wheel": 0.01}
    assert texts(xml.notes) == ()


@pytest.mark.parametrize(
    ("names", "along", "slide"),
    [
        (("a", "b"), (0.0, 0.0, 1.0), False),
        (("a",), (0.0, 0.0, 1.0), True),  # a caster's, whatever its name
        (("a_caster", "b_caster"), (0.0, 0.0, 1.0), True),
        (("a", "b"), (0.0, 1.0, 0.0), True),  # a rocker's
    ],
)
def test_only_the_wheels_of_a_trailer_grip(
    names: tuple[str, ...], along: tuple[float, float, float], slide: bool
) -> None:
    parts = (link("base", CUBE), link("wheel", TYRE), Link("hitch", None, (), ()))
    urdf = robot(*parts, link("trailer"), *(link(n, TYRE) for n in names))
    joints = dict(urdf.joints)
    joints["hitch"] = dataclasses.replace(joints["hitch"], kind="revolute", axis=along)
    joints["trailer"] = dataclasses.replace(joints["trailer"], kind="fixed", parent="hitch")
    joints |= {n: dataclasses.replace(joints[n], parent="trailer") for n in names}
    found = friction_of(urdf_file(), dataclasses.replace(urdf, joints=joints), {}, DRIVE)
    assert set(names) & found.keys() == (set(names) if slide else set())


def test_what_the_file_says_of_a_caster_is_kept() -> None:
    assert friction(said={"skid": 0.3})[0] == {"skid": 0.3}
    wheels = friction(said={"wheel": 0.2})[0]
    assert wheels == {"wheel": 0.2, "skid": 0.01}


@pytest.mark.parametrize(
    ("said", "wheel", "found"), [(2.0, 0.5, 2.0), (10.0, 0.5, 0.5), (10.0, 1.5, 1.0)]
)
def test_what_slides_along_holds_no_more_than_the_wheels(
    said: float, wheel: float, found: float
) -> None:
    """A Pioneer's caster, which is fixed, has 10 where its wheels have 0.5."""
    wanted, notes = friction(SKID, said={"skid": said, "wheel": wheel})
    assert wanted == {"skid": found, "wheel": wheel}
    text = f"link 'skid': friction {said:g} is taken to be {found:g}, as of its wheels"
    assert notes == ((f"{text}: what slides along would hold the robot",) * (said != found))
    high = friction(SKID, -0.07, said={"skid": said})[0]
    assert high == {"skid": said}


@pytest.mark.parametrize(("said", "found"), [(0.79, 0.8), (0.8, 0.8), (1.5, 1.5)])
def test_wheels_of_a_robot_that_was_moved_in_the_plane_grip(said: float, found: float) -> None:
    wanted, notes = friction(kind=DriveKind.PLANAR, said={"wheel": said})
    assert wanted["wheel"] == found
    slips = f"link 'wheel': its friction {said:g} would slip; it gets 0.8"
    assert notes == ((slips,) if said < 0.8 else ())
    assert "wheel" not in friction(kind=DriveKind.PLANAR)[0]


def test_a_robot_without_wheels_keeps_what_it_says() -> None:
    urdf = robot(link("base", CUBE))
    none = dataclasses.replace(DRIVE, left=())
    assert friction_of(urdf_file(), urdf, {"base": 0.4}, none) == {"base": 0.4}


@pytest.mark.parametrize(("x", "leans"), [(0.0, False), (0.4, True)])
def test_robot_that_tips_over_is_named(tmp_path: Path, x: float, leans: bool) -> None:
    path = cases.Robot(cases.four()).write(tmp_path)
    mass = "<inertial><mass value='12.0'/>"
    moved = mass.replace("<inertial>", f"<inertial><origin xyz='{x} 0 0'/>")
    path.write_text(path.read_text("utf-8").replace(mass, moved), "utf-8")
    notes = texts(check(path, SearchPath(), {}).notes)
    assert any("it tips over, or would have to balance" in note for note in notes) == leans
