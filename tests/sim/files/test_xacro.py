"""xacro macros: what is missing is noted, and an empty condition is false."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.errors import RobotError
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.urdf.xacro_file import Expanded, expand, has_macros
from arjuna_sim.model.notes import NoteKind
from tests.sim.builders import texts

pytest.importorskip("xacro")
ROBOT = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{}</robot>'


def _expand(folder: Path, inside: str, **arguments: str) -> Expanded:
    path = folder / "package" / "urdf" / "r.xacro"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(ROBOT.format(inside), encoding="utf-8")
    return expand(path, SearchPath((folder / "elsewhere",)), arguments)


@pytest.mark.parametrize("value", ["$(arg on)", "${on}", "$(optenv NOT_SET_ANYWHERE)"])
def test_empty_condition_is_false(tmp_path: Path, value: str) -> None:
    inside = (
        f'<xacro:property name="on" value="$(arg on)"/><xacro:if value="{value}"><a/></xacro:if>'
    )
    assert b"<a/>" not in _expand(tmp_path, inside).text
    inside = inside.replace("xacro:if", "xacro:unless")
    assert b"<a/>" in _expand(tmp_path, inside).text


@pytest.mark.parametrize("inside", ["<a b='$(optenv NOT_SET 1)'/>", "<a b='${1}'/>"])
def test_a_urdf_with_something_left_to_expand_is_expanded(inside: str) -> None:
    assert has_macros(Path("r.urdf"), ROBOT.format(inside).encode())
    assert not has_macros(Path("r.urdf"), ROBOT.format("<a b='1'/>").encode())


@pytest.mark.parametrize("value", ["$(arg on)", "${on}", "$(eval on)"])
def test_condition_follows_its_argument(tmp_path: Path, value: str) -> None:
    inside = (
        f'<xacro:arg name="on" default="false"/><xacro:property name="on" value="$(arg on)"/>'
        f'<xacro:if value="{value}"><a/></xacro:if>'
    )
    assert b"<a/>" not in _expand(tmp_path, inside).text
    assert b"<a/>" in _expand(tmp_path, inside, on="true").text


def test_argument_without_a_value_is_empty_and_one_without_a_use_is_noted(tmp_path: Path) -> None:
    expanded = _expand(tmp_path, '<link name="$(arg prefix)base"/>', colour="red")
    assert b'name="base"' in expanded.text
    assert {note.kind: note.text.partition(";")[0] for note in expanded.notes} == {
        NoteKind.CHANGED: "argument 'prefix' has no value, so it is empty",
        NoteKind.IGNORED: "argument 'colour' is used nowhere",
    }


def test_macros_of_a_missing_include_are_left_out_each_with_a_note(tmp_path: Path) -> None:
    inside = '<xacro:include filename="none.xacro"/><xacro:wheel/><xacro:arm/><link name="a"/>'
    expanded = _expand(tmp_path, inside)
    assert b'<link name="a"/>' in expanded.text
    assert {note.kind for note in expanded.notes} == {NoteKind.MISSING}
    assert sum("is left out" in text for text in texts(expanded.notes)) == 3
    with pytest.raises(RobotError, match="unknown macro name: xacro:wheel"):
        _expand(tmp_path, "<xacro:wheel/>")


def test_packages_and_files_of_values_are_found(tmp_path: Path) -> None:
    values = tmp_path / "elsewhere" / "parts" / "sizes.yaml"
    values.parent.mkdir(parents=True)
    values.write_text("radius: 0.07", encoding="utf-8")
    inside = "<link name=\"${xacro.load_yaml('$(find parts)/sizes.yaml')['radius']}\"/>"
    assert b'name="0.07"' in _expand(tmp_path, inside).text
    with pytest.raises(RobotError, match="No such file"):
        _expand(tmp_path, inside.replace("sizes", "none"))
