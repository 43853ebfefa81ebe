"""What clients spawn: read from names and files, or refused with a reason."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import ArjunaError
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_sim.files.library import Fault, Library, ResourceError
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.spawned import read_entity
from arjuna_sim.model.entities import Category
from tests.sim.builders import EMPTY, ROOT, run, simulator

BOX = """<sdf version="1.7"><model name="crate">{static}<link name="l">{inertial}
<collision name="c"><geometry><box><size>0.4 0.4 0.4</size></box></geometry></collision>
</link></model></sdf>"""
CART = """<robot name="cart"><link name="base"><inertial><mass value="4"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial><collision>
<geometry><box size="0.2 0.4 0.6"/></geometry></collision></link></robot>"""


def _library(folder: Path) -> Library:
    return Library(folder, SearchPath())


@pytest.mark.parametrize(
    ("uri", "low", "high"),
    [
        ("box:0.4,0.6,1", (-0.2, -0.3, 0.0), (0.2, 0.3, 1.0)),
        ("cylinder:0.2,1", (-0.2, -0.2, 0.0), (0.2, 0.2, 1.0)),
        ("sphere:0.25", (-0.25, -0.25, 0.0), (0.25, 0.25, 0.5)),
    ],
)
def test_primitive_stands_on_its_origin(
    uri: str, low: tuple[float, ...], high: tuple[float, ...]
) -> None:
    found = read_entity(uri, "", _library(ROOT)).bounds()
    assert found[0] == pytest.approx(low, abs=1e-9)
    assert found[1] == pytest.approx(high, abs=1e-9)


def test_files_say_what_is_held_and_what_weighs(tmp_path: Path) -> None:
    def mass(text: str) -> float:
        return read_entity("", text, _library(tmp_path)).mass

    heavy = "<inertial><mass>7</mass></inertial>"
    assert mass(BOX.format(static="", inertial=heavy)) == 7.0
    assert mass(BOX.format(static="", inertial="")) == 1.0
    assert mass(BOX.format(static="<static>true</static>", inertial=heavy)) == 0.0
    assert mass(CART) == 4.0


MESH = "<mesh><uri>none.stl</uri></mesh>"


@pytest.mark.parametrize(
    ("uri", "text", "fault", "problem"),
    [
        ("", "", Fault.NO_RESOURCE, "neither a uri nor a resource_string"),
        ("", "hello", Fault.UNSUPPORTED_FORMAT, "neither <sdf> nor <robot>"),
        ("", BOX[:80], Fault.RESOURCE_PARSE_ERROR, "broken XML"),
        ("", BOX.format(static="", inertial="").replace("0.4", "nan"), None, "finite"),
        ("", "<sdf version='1.7'><world name='w'/></sdf>", Fault.UNSUPPORTED_FORMAT, "load_world"),
        ("", "<sdf version='1.7'><model name='m'/></sdf>", Fault.RESOURCE_PARSE_ERROR, "neither"),
        ("", "<!DOCTYPE x [<!ENTITY a 'a'>]><sdf>&a;</sdf>", None, "DTD"),
        ("", CART.replace('value="4"', 'value="1e9"'), None, "weighs 1e\\+09 kg"),
        ("", CART.replace('<box size="0.2 0.4 0.6"/>', ""), None, "geometry"),
        ("box:1,1", "", Fault.RESOURCE_PARSE_ERROR, "needs 3 finite numbers"),
        ("box:1,1,nan", "", Fault.RESOURCE_PARSE_ERROR, "needs 3 finite numbers"),
        ("box:1,1,1e9", "", Fault.RESOURCE_PARSE_ERROR, "size beyond"),
        ("sphere:0", "", Fault.RESOURCE_PARSE_ERROR, "size beyond"),
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


def test_missing_mesh_of_a_spawned_model_is_a_missing_asset(tmp_path: Path) -> None:
    text = BOX.format(static="", inertial="").replace("<box><size>0.4 0.4 0.4</size></box>", MESH)
    with pytest.raises(ResourceError, match=r"mesh 'none.stl' does not exist") as caught:
        read_entity("", text, _library(tmp_path))
    assert caught.value.fault is Fault.MISSING_ASSETS


@pytest.mark.parametrize("name", ["it does not exist", "left out", "not simulated"])
def test_names_are_no_reason_to_refuse_a_model(name: str) -> None:
    text = BOX.format(static="<blink>1</blink>", inertial="").replace("crate", name)
    assert read_entity("", text, _library(ROOT)).name == name


def test_library_finds_models_and_worlds_in_its_folder_and_the_shipped(tmp_path: Path) -> None:
    crate = tmp_path / "models" / "crate"
    crate.mkdir(parents=True)
    (crate / "model.sdf").write_text(BOX.format(static="", inertial=""))
    (tmp_path / "mine.world").write_text("<sdf/>")
    library = _library(tmp_path)
    assert library.models() == (crate,)
    assert read_entity("models/crate", "", library).name == "crate"
    assert read_entity("model://crate", "", library).name == "crate"
    names = [path.name for path in library.worlds()]
    assert {"mine.world", "arjuna_room.world", "empty.world"} <= set(names)
    assert library.find("worlds/empty.world", (".world",)).name == "empty.world"


WALKER = """<sdf version='1.7'><actor name='w'><script><trajectory id='0' type='walk'>
<waypoint><time>0</time><pose>0 0 0 0 0 0</pose></waypoint>
<waypoint><time>4</time><pose>0 2 0 0 0 0</pose></waypoint></trajectory></script></actor></sdf>"""
TOKENS = ("1e9", "1e308", "-1", "nan", "inf", "0", "", "<", "</link>", "&a;", "1e-300", "9" * 400)


def _mutated(text: str, rng: np.random.Generator) -> str:
    """Replace a number, insert a token, or cut a passage out."""
    kind, at = int(rng.integers(3)), int(rng.integers(len(text)))
    token = TOKENS[int(rng.integers(len(TOKENS)))]
    if kind == 0:
        found = list(re.finditer(r"-?\d+(\.\d+)?", text))
        number = found[int(rng.integers(len(found)))]
        return text[: number.start()] + token + text[number.end() :]
    end = at if kind == 1 else at + int(rng.integers(1, 30))
    return text[:at] + (token if kind == 1 else "") + text[end:]


@pytest.mark.parametrize("seed", range(3))
def test_whatever_a_client_sends_is_spawned_or_refused_and_the_robot_stands(seed: int) -> None:
    rng, library = np.random.default_rng(seed), _library(ROOT)
    sim = simulator(EMPTY)
    corpus = (BOX.format(static="", inertial="<inertial><mass>7</mass></inertial>"), CART, WALKER)
    spawned = 0
    for i in range(120):
        text = _mutated(corpus[i % len(corpus)], rng)
        try:
            entity = read_entity("", text, library)
            sim.stage.spawn(dataclasses.replace(entity, name="it", start=Pose3((3.0, 0.0, 0.0))))
        except ArjunaError:
            continue
        spawned += 1
        run(sim, 0.1)
        sim.stage.delete("it")
    assert 0 < spawned < 120
    assert sim.robot.truth().pose.distance(SE2()) < 0.01


def test_endless_shapes_are_refused() -> None:
    shape = "<geometry><sphere><radius>0.01</radius></sphere></geometry>"
    links = f"<link name='l'><collision name='c'>{shape}</collision></link>" * 2001
    with pytest.raises(ResourceError, match="'m' has 2001 shapes; at most 2000"):
        read_entity("", f"<sdf><model name='m'>{links}</model></sdf>", _library(ROOT))


@pytest.mark.parametrize(
    ("uri", "category", "mass"),
    [
        ("box:0.4,0.6,1", Category.STATIC_OBJECT, 0.0),
        ("box:0.4,0.6,1?mass=1", Category.OBJECT, 1.0),
        ("sphere:0.2?mass=0", Category.STATIC_OBJECT, 0.0),
        ("person", Category.HUMAN, 0.0),
        ("person?mass=70", Category.HUMAN, 70.0),
    ],
)
def test_what_weighs_can_be_pushed_and_is_no_fixture(
    uri: str, category: Category, mass: float
) -> None:
    entity = read_entity(uri, "", _library(ROOT))
    assert (entity.category, entity.mass, entity.spawned) == (category, mass, True)
