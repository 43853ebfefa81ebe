"""Claims: SDF's lights and scene are read with its defaults; what is broken is left out."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from arjuna_core.errors import WorldError
from arjuna_sim.files.sdf.world import read_world
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.look import AMBIENT, SUN, LightKind, Look
from tests.sim.builders import texts

SUN_TAG = "<include><uri>model://sun</uri></include>"


def look(inside: str, folder: Path = Path()) -> tuple[Look, tuple[str, ...]]:
    """Return the look of a world, and its notes."""
    text = f"<sdf version='1.9'><world name='w'>{inside}</world></sdf>"
    search = SearchPath.of([folder])
    world = read_world(XmlFile(folder / "w.world", "sdf", WorldError, text.encode(), search))
    return world.look, texts(world.notes)[:-1]  # that it has no ground is the last


def light(inside: str = "", kind: str = "point") -> str:
    return f"<light name='l' type='{kind}'>{inside}</light>"


def test_sun_and_nothing_are_the_same() -> None:
    assert look("") == look(SUN_TAG) == (Look(), ())
    assert look(SUN_TAG + light())[0].lights[0] is SUN


@pytest.mark.parametrize(
    ("tags", "kind", "values"),
    [
        ("", "point", {"diffuse": (1, 1, 1), "specular": (0.1,) * 3, "attenuation": (1, 1, 0)}),
        ("", "directional", {"attenuation": (1, 0, 0), "direction": (0, 0, -1)}),
        ("", "spot", {"cutoff": 0.5, "falloff": 1.0, "casts_shadow": False}),
        ("<cast_shadows>1</cast_shadows>", "spot", {"casts_shadow": True}),
        ("<diffuse>.5 .4 .3 1</diffuse><intensity>2</intensity>", "spot",
         {"diffuse": (1, 0.8, 0.6)}),
        ("<direction>0 0 -3</direction><pose>1 2 3 0 1.5707963 0</pose>", "spot",
         {"direction": (-1, 0, 0), "position": (1, 2, 3)}),
        ("<spot><outer_angle>1.2</outer_angle><falloff>.5</falloff></spot>", "spot",
         {"cutoff": 0.6, "falloff": 0.5}),
        ("<attenuation><constant>.5</constant><linear>.1</linear><quadratic>.02</quadratic>"
         "</attenuation>", "point", {"attenuation": (0.5, 0.1, 0.02)}),
        ("<attenuation><constant>0</constant><linear>0</linear><quadratic>1</quadratic>"
         "</attenuation>", "point", {"attenuation": (0, 0, 1)}),
        ("<attenuation><constant>0</constant><linear>0</linear></attenuation>", "point",
         {"attenuation": (1, 0, 0)}),
    ],
)  # fmt: skip
def test_lights_have_what_their_tags_say(tags: str, kind: str, values: dict[str, Any]) -> None:
    found, notes = look(light(tags, kind))
    (only,) = found.lights
    assert (only.kind, notes, found.ambient) == (LightKind(kind), (), AMBIENT)
    for name, value in values.items():
        assert getattr(only, name) == pytest.approx(value, abs=1e-6), name


def test_lights_of_links_and_of_included_files_stand_where_those_do(tmp_path: Path) -> None:
    (tmp_path / "lamp").mkdir()
    (tmp_path / "lamp" / "model.sdf").write_text(f"<sdf version='1.7'>{light()}</sdf>")
    link = f"<link name='a'><pose>0 0 2 0 0 0</pose>{light('<pose>0 1 0 0 0 0</pose>')}</link>"
    model = f"<model name='m'><pose>5 0 0 0 0 0</pose><static>1</static>{link}</model>"
    include = "<include><uri>model://lamp</uri><pose>7 8 9 0 0 0</pose></include>"
    found, notes = look(model + include + light("<light_on>0</light_on>"), tmp_path)
    assert notes == ()
    solid = (
        "<collision name='c'><geometry><sphere><radius>1</radius></sphere></geometry></collision>"
    )
    moving = model.replace("<static>1</static>", "").replace(
        "<link name='a'>", f"<link name='a'>{solid}"
    )
    assert "its light stays where it is at first" in look(moving)[1][0]
    assert sorted(each.position for each in found.lights) == [(5, 1, 2), (7, 8, 9)]


@pytest.mark.parametrize(
    ("tag", "problem"),
    [
        (light(kind="laser"), "type 'laser' is unknown; valid: directional, point, spot"),
        (light("<direction>0 0 0</direction>"), "must not be zero"),
        (light("<diffuse>red</diffuse>"), "1 numbers"),
        (light() * 9, "cameras see by the first 7"),
        ("<scene><fog><type>linear</type><start>9</start><end>3</end></fog></scene>", "9 to 3 m"),
    ],
)
def test_what_is_broken_or_too_much_is_noted(tag: str, problem: str) -> None:
    found, notes = look(tag)
    assert problem in notes[0]
    assert len(found.lights) in (1, 7)


@pytest.mark.parametrize(
    ("scene", "values"),
    [
        ("<ambient>.1 .2 .3 1</ambient>", {"ambient": (0.1, 0.2, 0.3), "background": None}),
        ("<background>.1 .2 .3</background>", {"ambient": None, "background": (0.1, 0.2, 0.3)}),
        ("<background>.1 .2 .3</background><sky/>", {"background": None}),
        ("<fog><type>none</type></fog>", {"fog": None}),
    ],
)
def test_scene_says_ambient_light_and_sky(scene: str, values: dict[str, Any]) -> None:
    found, notes = look(f"<scene>{scene}</scene>")
    assert notes == ()
    assert {name: getattr(found, name) for name in values} == values


@pytest.mark.parametrize(
    ("kind", "span"), [("linear", (2.0, 20.0)), ("constant", (0.0, 5.99)), ("quadratic", (0, 3.46))]
)
def test_fog_hides_by_its_kind(kind: str, span: tuple[float, float]) -> None:
    tags = f"<type>{kind}</type><start>2</start><end>20</end><density>.5</density>"
    fog = look(f"<scene><fog>{tags}</fog></scene>")[0].fog
    assert fog is not None
    assert (fog.start, fog.end) == pytest.approx(span, abs=0.01)


def test_scene_takes_shadows_away() -> None:
    casting = light("<cast_shadows>true</cast_shadows>", "spot")
    assert look(casting)[0].lights[0].casts_shadow
    assert not look(casting + "<scene><shadows>0</shadows></scene>")[0].lights[0].casts_shadow
