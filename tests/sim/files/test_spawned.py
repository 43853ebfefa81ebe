"""Entities of clients: shapes, models, actors and robots; each refusal has its reason."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import ArjunaError
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_sim.files import library, spawned
from arjuna_sim.files.library import Fault, Library, ResourceError
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.spawned import check_assets, read_driven, read_entity
from arjuna_sim.model.entities import Category, Entity
from arjuna_sim.model.geometry.shapes import Kind
from arjuna_sim.model.notes import Note, NoteKind
from tests.fuzz.files import MUTATIONS
from tests.sim.builders import EMPTY, ROOT, run, simulator

LIBRARY = Library(ROOT, SearchPath())
SHAPE = "<geometry><box><size>0.2 0.4 0.6</size></box></geometry>"
SOLID, DRAWN = f"<collision name='c'>{SHAPE}</collision>", f"<visual name='v'>{SHAPE}</visual>"
WALK = """<actor name='w'><script><trajectory id='0' type='walk'>
<waypoint><time>0</time><pose>0 0 0 0 0 0</pose></waypoint>
<waypoint><time>4</time><pose>0 2 0 0 0 0</pose></waypoint></trajectory></script></actor>"""
BOX = '<geometry><box size="0.2 0.4 0.6"/></geometry>'
MASS = """<inertial><mass value="4"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>
</inertial>"""
WHEEL = """<link name="{0}">{1}<collision><geometry><cylinder radius="0.1" length="0.04"/>
</geometry></collision></link><joint name="{0}_wheel" type="continuous"><parent link="base"/>
<child link="{0}"/><origin xyz="0 {2} 0" rpy="-1.5707963 0 0"/><axis xyz="0 0 1"/></joint>"""
WHEELS = WHEEL.format("left", MASS, 0.3) + WHEEL.format("right", MASS, -0.3)
DRIVE = """<gazebo><plugin name="p" filename="libgazebo_ros_diff_drive.so">
<left_joint>left_wheel</left_joint><right_joint>right_wheel</right_joint></plugin></gazebo>"""


def sdf(*inside: str) -> str:
    return f"<sdf version='1.7'>{''.join(inside)}</sdf>"


def model(inside: str = SOLID, more: str = "", name: str = "m") -> str:
    return f"<model name='{name}'>{more}<link name='l'>{inside}</link></model>"


def urdf(inside: str = f"<collision>{BOX}</collision>", more: str = "") -> str:
    return f'<robot name="cart"><link name="base">{MASS}{inside}</link>{more}</robot>'


CRATE = sdf(model(name="crate"))
FAST = "<joint name='f' type='fixed'><parent>world</parent><child>l</child></joint>"
HEAVY = "<inertial><mass>7</mass></inertial>"


def read(text: str = "", uri: str = "") -> Entity:
    return read_entity(uri, text, LIBRARY)


def refused(text: str = "", uri: str = "") -> tuple[Fault, str]:
    """Return why something cannot be spawned."""
    with pytest.raises(ResourceError, match=r".") as caught:
        read_entity(uri, text, LIBRARY)
    return caught.value.fault, str(caught.value)


@pytest.mark.parametrize(
    ("uri", "kind", "size", "height", "about"),
    [
        (" box:0.4,0.6,1 ", Kind.BOX, (0.4, 0.6, 1.0), 0.5, "a box of 0.4,0.6,1 m"),
        ("cylinder:0.2,1", Kind.CYLINDER, (0.2, 1.0), 0.5, "a cylinder of 0.2,1 m"),
        ("sphere:0.25", Kind.SPHERE, (0.25,), 0.25, "a sphere of 0.25 m"),
        ("person", Kind.CYLINDER, (0.25, 1.7), 0.85, "a person"),
    ],
)
def test_a_primitive_is_a_shape_on_the_ground(
    uri: str, kind: Kind, size: tuple[float, ...], height: float, about: str
) -> None:
    found = read(uri=uri)
    (part,) = found.solid
    assert (found.name, found.drawn, found.description) == (uri.strip().split(":")[0], (), about)
    assert part.shape.kind is kind
    if about == "a person":
        assert part.pose.position[2] == part.shape.size[1] / 2
    else:
        assert (part.shape.size, part.rgba) == (size, (0.9, 0.6, 0.1, 1.0))
        assert part.pose.position == (0.0, 0.0, height)
    assert part.rgba[3] == 1.0


@pytest.mark.parametrize(
    ("uri", "problem"),
    [
        ("box:0.001,100,1", ""),
        ("box:0.0009,1,1", "has a size beyond 0.001 to 100 m"),
        ("box:1,1,100.1", "has a size beyond 0.001 to 100 m"),
        ("sphere:1?mass=10000", ""),
        ("sphere:1?mass=10001", "mass is 10001.0 kg; valid: 0 to 10000"),
        ("sphere:1?mass=x", "'mass:x' needs 1 finite numbers; valid: box:X,Y,Z"),
        ("sphere:1,2", "'sphere:1,2' needs 1 finite numbers"),
        ("sphere", "'sphere:' needs 1 finite numbers"),
        ("person:1", "'person:1' needs 0 finite numbers"),
        ("cylinder:1,inf", "needs 2 finite numbers"),
    ],
)
def test_a_primitive_needs_its_sizes_within_bounds(uri: str, problem: str) -> None:
    if not problem:
        assert read(uri=uri).solid
        return
    fault, said = refused(uri=uri)
    assert fault is Fault.RESOURCE_PARSE_ERROR
    assert problem in said


def test_a_model_that_nothing_can_touch_is_held() -> None:
    solid, drawn, both = (read(sdf(model(inside))) for inside in (SOLID, DRAWN, SOLID + DRAWN))
    assert (solid.mass, solid.category) == (1.0, Category.OBJECT)
    assert (len(solid.solid), len(solid.drawn)) == (1, 0)
    assert (drawn.mass, drawn.category) == (0.0, Category.STATIC_OBJECT)
    assert (len(drawn.solid), len(drawn.drawn)) == (0, 1)
    assert (len(both.solid), len(both.drawn)) == (1, 1)
    for each in (solid, drawn, both):
        assert (each.name, each.spawned, each.description) == ("m", True, "a model")
    assert read(sdf(model(HEAVY + SOLID))).mass == 7.0
    assert read(sdf(model(HEAVY + SOLID, "<static>true</static>"))).mass == 0.0


def test_an_actor_walks_its_path() -> None:
    found = read(sdf(WALK))
    assert (found.name, found.spawned, found.category) == ("w", True, Category.HUMAN)
    assert found.description == "an actor"
    assert found.trajectory is not None


PLANE = "<geometry><plane><normal>0 0 1</normal></plane></geometry>"


def test_a_robots_file_is_one_rigid_thing() -> None:
    found = read(urdf(f"<collision>{BOX}</collision><visual>{BOX}</visual>"))
    assert (found.name, found.mass, len(found.solid), len(found.drawn)) == ("cart", 4.0, 1, 1)
    assert read(urdf(f"<visual>{BOX}</visual>")).category is Category.STATIC_OBJECT
    assert read(urdf(more="<gazebo><static> true </static></gazebo>")).mass == 0.0
    assert read(urdf(more="<gazebo><static>false</static></gazebo>")).mass == 4.0


@pytest.mark.parametrize(("mass", "fits"), [("10000", True), ("10001", False)])
def test_nothing_weighs_more_than_ten_tonnes(mass: str, fits: bool) -> None:
    text = urdf().replace('mass value="4"', f'mass value="{mass}"')
    if fits:
        assert math.isclose(read(text).mass, 1e4)
        return
    assert refused(text) == (
        Fault.RESOURCE_PARSE_ERROR,
        "'cart' weighs 10001 kg; valid: 0 to 10000",
    )


def test_bounds_on_shapes_and_text_are_the_last_that_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    text = sdf(model(SOLID + DRAWN))
    monkeypatch.setattr(spawned, "_PARTS_MAX", 2)
    monkeypatch.setattr(library, "BYTES_MAX", len(text))
    assert read(text).solid
    assert f"has {len(text) + 1} characters; at most {len(text)} are read" in refused(text + " ")[1]
    monkeypatch.setattr(spawned, "_PARTS_MAX", 1)
    assert refused(text)[1] == "'m' has 2 shapes; at most 1 are valid"


@pytest.mark.parametrize(
    ("kind", "fault"),
    [
        (NoteKind.MISSING, Fault.MISSING_ASSETS),
        (NoteKind.UNSUPPORTED, Fault.UNSUPPORTED_ASSETS),
        (NoteKind.BROKEN, Fault.RESOURCE_PARSE_ERROR),
    ],
)
def test_what_a_reader_left_out_is_refused_by_its_first_note(kind: NoteKind, fault: Fault) -> None:
    harmless = [Note(NoteKind.IGNORED, "a"), Note(NoteKind.CHANGED, "b")]
    check_assets(harmless)
    with pytest.raises(ResourceError, match=r"^c$") as caught:
        check_assets([*harmless, Note(kind, "c"), Note(NoteKind.MISSING, "d")])
    assert caught.value.fault is fault


def test_robots_that_drive_are_no_things() -> None:
    for given in (DRIVE, ""):  # named or found
        driven = read_driven("", urdf(more=WHEELS + given), LIBRARY)
        assert driven is not None
        assert driven.drive.wheels == ("left_wheel", "right_wheel")
    for uri, text in (
        ("box:1,1,1", ""),
        (" person ", ""),
        ("", urdf()),
        ("", sdf(model())),
        ("", urdf().replace("</robot>", "<link/></robot>")),  # broken, and names no drive
    ):
        assert read_driven(uri, text, LIBRARY) is None
    broken = urdf(more=WHEELS + DRIVE.replace(">left_wheel<", ">lost<"))
    with pytest.raises(ResourceError, match=r"joint 'lost' does not exist") as caught:
        read_driven("", broken, LIBRARY)
    assert caught.value.fault is Fault.RESOURCE_PARSE_ERROR


def _library(folder: Path) -> Library:
    return Library(folder, SearchPath())


MESH = "<geometry><mesh><uri>none.stl</uri></mesh></geometry>"


@pytest.mark.parametrize(
    ("uri", "text", "fault", "problem"),
    [
        ("", "hello", Fault.UNSUPPORTED_FORMAT, "valid formats: sdf, urdf"),
        ("", CRATE[:80], Fault.RESOURCE_PARSE_ERROR, "broken XML"),
        ("", CRATE.replace("0.4", "nan"), None, "finite"),
        ("", "<sdf version='1.7'><world name='w'/></sdf>", Fault.UNSUPPORTED_FORMAT, "load_world"),
        ("", " \n", Fault.NO_RESOURCE, "neither a uri nor a resource_string was given"),
        ("", sdf(model(), model(name="n")), None, "must hold one <model> or one"),
        ("", sdf(model(), WALK), None, "must hold one <model> or one"),
        ("", sdf(), None, "must hold a <world>, a <model> or an <actor>"),
        ("", sdf("<model name='m'/>"), None, "neither"),
        ("", sdf(model("")), None, "has neither <collision> nor <visual>"),
        ("", urdf(""), None, "has neither <collision> nor <visual>"),
        ("", sdf(model(SOLID.replace(SHAPE, PLANE))), Fault.UNSUPPORTED_ASSETS, "has a <plane>"),
        ("", sdf(model(SOLID.replace(SHAPE, MESH))), Fault.MISSING_ASSETS, "mesh 'none.stl' does"),
        ("", "<!DOCTYPE x [<!ENTITY a 'a'>]><sdf>&a;</sdf>", None, "DTD"),
        ("", urdf().replace('<box size="0.2 0.4 0.6"/>', ""), None, "geometry"),
        ("box:1,1,1?mass=-1", "", Fault.RESOURCE_PARSE_ERROR, "mass is -1"),
        ("none.sdf", "", Fault.NOT_FOUND, "does not exist"),
        ("model://nothing", "", Fault.NOT_FOUND, "model path"),
        ("../../etc/passwd", "", Fault.FORBIDDEN, "lies outside"),
        ("file:///etc/passwd", "", Fault.FORBIDDEN, "lies outside"),
        ("http://a/b.sdf", "", Fault.UNSUPPORTED_FORMAT, "valid: a path"),
        ("notes.txt", "", Fault.UNSUPPORTED_FORMAT, "none of .sdf, .urdf"),
        ("link.sdf", "", Fault.FORBIDDEN, "lies outside"),
    ],
)
def test_what_cannot_be_spawned_is_refused_with_its_reason(
    tmp_path: Path, uri: str, text: str, fault: Fault | None, problem: str
) -> None:
    (tmp_path / "notes.txt").write_text("x")
    (tmp_path / "link.sdf").symlink_to("/etc/hostname")
    with pytest.raises(ResourceError, match=problem) as caught:
        read_entity(uri, text, _library(tmp_path))
    assert caught.value.fault is (fault or Fault.RESOURCE_PARSE_ERROR)


@pytest.mark.parametrize("text", [sdf(model(SOLID + DRAWN)), urdf()])
@pytest.mark.parametrize("look", ["none.stl", "none.skp", "notes.stl", "../../up.stl"])
def test_what_is_only_seen_is_left_out_of_what_is_spawned(
    tmp_path: Path, text: str, look: str
) -> None:
    """Gazebo spawns it without: robots of others lack a mesh that was only drawn."""
    (tmp_path / "notes.stl").write_text("x")
    mesh = f"<mesh filename='{look}'><uri>{look}</uri></mesh>"
    visual = f"<visual name='lost'><geometry>{mesh}</geometry></visual>"
    found = read_entity("", text.replace("<collision", f"{visual}<collision"), _library(tmp_path))
    assert (len(found.solid), len(found.notes)) == (1, 1)
    assert f"'{look}'" in found.notes[0]


@pytest.mark.parametrize(("parent", "mass"), [("l", 7.0), ("world", 0.0)])
def test_a_spawned_model_hangs_in_its_joints_as_one_of_a_world(parent: str, mass: float) -> None:
    joint = "<joint name='j' type='revolute'><parent>l</parent><child>d</child><axis/></joint>"
    drawer = (
        f"<link name='d'><pose>1 0 0 0 0 0</pose><inertial><mass>2</mass></inertial>{SOLID}</link>"
    )
    more = f"</link>{joint}{drawer}{FAST * (parent == 'world')}</model>"
    chest = model(HEAVY + SOLID, name="chest").replace("</link></model>", more)
    found = read(sdf(chest))
    assert (len(found.solid), found.mass, found.name, found.notes) == (1, mass, "chest", ())
    (leaf,) = found.hung
    assert (leaf.name, leaf.on, leaf.mass, leaf.hinge is not None) == ("::d", "", 2.0, True)
    placed = dataclasses.replace(found, name="mine", start=Pose3((2.0, 0.0, 0.0))).whole()
    assert list(placed) == ["mine", "mine::d"]
    assert placed["mine::d"].on == "mine"
    assert placed["mine::d"].start.position == pytest.approx((3.0, 0.0, 0.0))


def test_links_of_a_spawned_model_that_nothing_connects_are_one_body() -> None:
    far = (
        f"<link name='d'><pose>5 0 0 0 0 0</pose><inertial><mass>2</mass></inertial>{SOLID}</link>"
    )
    found = read(sdf(model(HEAVY + SOLID, far)))
    assert (len(found.solid), found.mass, found.hung) == (2, 9.0, ())
    assert found.notes == ("what of it hangs on nothing is spawned as one body",)


@pytest.mark.parametrize("name", ["it does not exist", "left out", "not simulated"])
def test_names_are_no_reason_to_refuse_a_model(name: str) -> None:
    assert read(sdf(model(more="<blink>1</blink>", name=name))).name == name


def test_library_finds_models_and_worlds_in_its_folder_and_the_shipped(tmp_path: Path) -> None:
    crate = tmp_path / "models" / "crate"
    crate.mkdir(parents=True)
    (crate / "model.sdf").write_text(CRATE)
    (tmp_path / "mine.world").write_text("<sdf/>")
    library = _library(tmp_path)
    assert library.models() == (crate,)
    assert read_entity("models/crate", "", library).name == "crate"
    assert read_entity("model://crate", "", library).name == "crate"
    names = [path.name for path in library.worlds()]
    assert {"mine.world", "arjuna_room.world", "empty.world"} <= set(names)
    assert library.find("worlds/empty.world", (".world",)).name == "empty.world"


def test_whatever_a_client_sends_is_spawned_or_refused_and_the_robot_stands() -> None:
    rng, sim = np.random.default_rng(0), simulator(EMPTY)
    corpus = sdf(model(HEAVY + SOLID)), urdf(), sdf(WALK)
    spawned = 0
    for i in range(120):
        mutate = MUTATIONS[rng.integers(len(MUTATIONS))]
        text = mutate(corpus[i % len(corpus)].encode(), rng).decode(errors="replace")
        try:
            entity = read(text)
            sim.stage.spawn(dataclasses.replace(entity, name="it", start=Pose3((3.0, 0.0, 0.0))))
        except ArjunaError:
            continue
        spawned += 1
        run(sim, 0.1)
        sim.stage.delete("it")
    assert 0 < spawned < 120
    assert sim.robot.truth().pose.distance(SE2()) < 0.01
