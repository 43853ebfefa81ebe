"""A model replaces its include, with what the include says of it."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element

import pytest

from arjuna_core.errors import WorldError
from arjuna_sim.files.sdf import includes as module
from arjuna_sim.files.sdf.includes import ExcessError, Includes, leaving_out
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind
from tests.sim.builders import sdf_file, texts

BOX = "<model name='box'><pose>1 0 0 0 0 0</pose><static>true</static><link name='l'/></model>"


def write(folder: Path, name: str, inside: str) -> None:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"<sdf version='1.9'>{inside}</sdf>", encoding="utf-8")


def include(uri: str, inside: str = "", merge: str = "") -> str:
    given = f" merge='{merge}'" if merge else ""
    return f"<include{given}><uri>{uri}</uri>{inside}</include>"


class Expanded:
    """A world after what it includes was put in."""

    def __init__(self, folder: Path, inside: str) -> None:
        text = f"<sdf version='1.9'><world name='w'>{inside}</world></sdf>"
        self.xml = XmlFile(folder / "made.world", "sdf", WorldError, text.encode())
        self.world: Element = self.xml.root[0]
        self.includes = Includes(self.xml)
        self.includes.expand(self.xml, self.world)

    def notes(self) -> tuple[str, ...]:
        return texts(self.xml.notes)


def test_a_model_replaces_its_include_in_order(tmp_path: Path) -> None:
    write(tmp_path, "box.sdf", BOX)
    found = Expanded(tmp_path, f"<model name='a'/>{include('box.sdf')}<model name='z'/>")
    assert [(one.tag, one.get("name")) for one in found.world] == [
        *(("model", "a"), ("model", "box"), ("model", "z"))
    ]
    assert found.world[1].findtext("pose") == "1 0 0 0 0 0"
    assert found.notes() == ()


def test_what_an_include_says_wins_and_what_it_does_not_stays(tmp_path: Path) -> None:
    write(tmp_path, "box.sdf", BOX.replace("<link", "<pose>9 9 9 0 0 0</pose><link"))
    own = (
        "<name> mine </name><pose>2 0 0 0 0 0</pose><static>false</static>"
        "<placement_frame> l </placement_frame>"
    )
    model = Expanded(tmp_path, include("box.sdf", own)).world[0]
    assert model.get("name") == "mine"
    assert [tag.text for tag in model.findall("pose")] == ["2 0 0 0 0 0"]
    assert [tag.text for tag in model.findall("static")] == ["false"]
    assert model.get("placement_frame") == "l"
    assert model.find("link") is not None
    plain = Expanded(tmp_path, include("box.sdf")).world[0]
    assert plain.get("placement_frame") is None
    assert len(plain.findall("pose")) == 2


@pytest.mark.parametrize(
    ("given", "merged"),
    [("true", True), (" 1 ", True), ("TRUE", True), ("false", False), ("", False)],
)
def test_an_include_merges_where_it_says_so(tmp_path: Path, given: str, merged: bool) -> None:
    write(tmp_path, "box.sdf", BOX)
    model = Expanded(tmp_path, include("box.sdf", merge=given)).world[0]
    assert (model.get("merge") == "true") is merged


def test_two_of_one_file_are_two_models_of_that_file(tmp_path: Path) -> None:
    write(tmp_path, "box.sdf", BOX)
    names = "<name>a</name>", "<name>b</name>"
    found = Expanded(tmp_path, "".join(include("box.sdf", name) for name in names))
    a, b = found.world
    assert (a.get("name"), b.get("name")) == ("a", "b")
    assert found.includes.file_of(a, found.xml) is found.includes.file_of(b, found.xml)
    assert found.includes.file_of(a, found.xml).path == (tmp_path / "box.sdf").resolve()
    assert found.includes.file_of(found.world, found.xml) is found.xml


def test_models_within_models_are_put_in_by_their_own_files(tmp_path: Path) -> None:
    """A path is beside the file that names it."""
    write(tmp_path, "parts/box.sdf", BOX)
    write(tmp_path, "parts/shelf.sdf", f"<model name='shelf'>{include('box.sdf')}</model>")
    inside = f"<model name='room'>{include('parts/shelf.sdf')}</model>"
    found = Expanded(tmp_path, inside)
    box = found.world.find("model/model/model")
    assert box is not None
    assert box.get("name") == "box"
    assert found.includes.file_of(box, found.xml).path.name == "box.sdf"


@pytest.mark.parametrize("uri", ["model://sun", "sun", "https://fuel.org/1.0/openrobotics/Sun"])
def test_the_sun_is_there_anyway(tmp_path: Path, uri: str) -> None:
    found = Expanded(tmp_path, include(uri))
    assert [one.tag for one in found.world] == ["light"]
    assert found.notes() == ()


@pytest.mark.parametrize("uri", ["model://ground_plane", "https://x.org/models/Ground Plane/"])
def test_the_ground_is_built_in(tmp_path: Path, uri: str) -> None:
    (ground,) = Expanded(tmp_path, include(uri, "<pose>0 0 1 0 0 0</pose>")).world
    assert ground.get("name") == "ground_plane"
    assert ground.findtext("static") == "true"
    assert ground.findtext("pose") == "0 0 1 0 0 0"
    for tag in ("collision", "visual"):
        part = ground.find(f"link/{tag}")
        assert part is not None
        assert part.find("geometry/plane") is not None
        assert len((part.findtext("material/diffuse") or "").split()) == 4


@pytest.mark.parametrize("uri", ["none", "model://none/"])
@pytest.mark.parametrize(("own", "name"), [("", "none"), ("<name> n </name>", "n")])
def test_a_missing_include_leaves_a_frame(tmp_path: Path, uri: str, own: str, name: str) -> None:
    found = Expanded(tmp_path, include(uri, own))
    assert [(one.tag, one.get("name")) for one in found.world] == [("frame", name)]
    (note,) = found.xml.notes
    assert note.kind is NoteKind.MISSING
    assert note.text == (
        f"include: model '{uri}' does not exist, so it is left out; built in: sun, ground_plane"
    )


def test_lights_and_actors_are_included_and_others_are_said(tmp_path: Path) -> None:
    write(tmp_path, "lamp.sdf", "<light name='lamp'/>")
    write(tmp_path, "who.sdf", "<actor name='who'/>")
    write(tmp_path, "what.sdf", "<world name='what'/>")
    uris = ("lamp.sdf", "who.sdf", "what.sdf")
    found = Expanded(tmp_path, "".join(map(include, uris)))
    assert [(one.tag, one.get("name")) for one in found.world] == [
        *(("light", "lamp"), ("actor", "who"), ("frame", "what.sdf"))
    ]
    (note,) = found.notes()
    assert note.startswith("include 'what.sdf' is left out: sdf: holds no <model>, <actor> or <li")


def test_who_includes_himself_is_left_out_there(tmp_path: Path) -> None:
    write(tmp_path, "a.sdf", f"<model name='a'>{include('b.sdf')}</model>")
    write(tmp_path, "b.sdf", f"<model name='b'>{include('a.sdf')}</model>")
    found = Expanded(tmp_path, include("a.sdf") + include("b.sdf"))
    assert [one.get("name") for one in found.world.iter("model")] == ["a", "b", "b", "a"]
    assert "include 'a.sdf' is left out: model 'a.sdf' includes itself" in found.notes()


def test_populations_are_models_before_includes_are_looked_for(tmp_path: Path) -> None:
    write(tmp_path, "box.sdf", BOX)
    many = (
        "<population name='p'><model name='m'><include><uri>box.sdf</uri></include></model>"
        "<model_count>3</model_count><pose>0 0 0 0 0 0</pose><box><size>4 4 1</size></box>"
        "<distribution><type>random</type></distribution></population>"
    )
    found = Expanded(tmp_path, many)
    assert found.world.find("population") is None
    assert len(found.world.findall("model/model[@name='box']")) == 3
    broken = Expanded(tmp_path, many.replace("<model_count>3", "<model_count>x"))
    assert len(broken.world) == 0
    (note,) = broken.notes()
    assert note.startswith("population 'p' is left out")


def test_too_many_includes_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, "box.sdf", BOX)
    monkeypatch.setattr(module, "_MODELS_MAX", 3)
    Expanded(tmp_path, 3 * include("box.sdf"))
    with pytest.raises(ExcessError, match="is one of too many; valid: up to 3 includes"):
        Expanded(tmp_path, 4 * include("box.sdf"))


def test_models_are_nested_to_a_depth(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_NESTED_MAX", 3)

    def nested(depth: int) -> str:
        return "<model name='m'>" * depth + "</model>" * depth

    Expanded(tmp_path, nested(3))
    with pytest.raises(ExcessError, match="model 'm': is nested too deeply; valid: up to 3 models"):
        Expanded(tmp_path, nested(4))
    write(tmp_path, "deep.sdf", nested(2))
    Expanded(tmp_path, f"<model name='o'>{include('deep.sdf')}</model>")
    with pytest.raises(ExcessError, match="nested too deeply"):
        Expanded(tmp_path, f"<model name='o'><model name='p'>{include('deep.sdf')}</model></model>")


def test_what_is_broken_is_left_out_by_name_and_what_is_too_much_is_not() -> None:
    xml = sdf_file()
    for position in (None, "here", "there"):
        with leaving_out(xml, "here"):
            raise WorldError("w", "is odd", position)
    assert texts(xml.notes) == ("here is left out: is odd", "here is left out: there: is odd")
    assert {note.kind for note in xml.notes} == {NoteKind.BROKEN}
    with pytest.raises(ExcessError), leaving_out(xml, "here"):
        raise ExcessError("w", "is too much")
    with pytest.raises(ValueError, match="mine"), leaving_out(xml, "here"):
        raise ValueError("mine")
