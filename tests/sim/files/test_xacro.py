"""xacro macros: what is missing is noted, and an empty condition is false."""

from __future__ import annotations

import json
import os
import signal
from contextlib import closing
from pathlib import Path

import pytest

from arjuna_core.errors import RobotError
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.urdf.xacro_file import EXPANDER, Expanded, Expander, expand, has_macros
from arjuna_sim.model.notes import NoteKind
from tests.helpers.processes import Lines, ended
from tests.sim.builders import texts

pytest.importorskip("xacro")
SEED = Path(__file__).parents[2] / "fuzz" / "corpus" / "macros.xacro"
ROBOT = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{}</robot>'


def _expand(folder: Path, inside: str, **arguments: str) -> Expanded:
    path = folder / "package" / "urdf" / "r.xacro"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(ROBOT.format(inside), encoding="utf-8")
    return expand(path, SearchPath((folder / "elsewhere",)), arguments)


def request(path: Path) -> bytes:
    nothing: dict[str, object] = {"arguments": {}, "packages": [], "models": [], "environment": {}}
    return json.dumps({"path": str(path), **nothing}).encode()


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


def test_files_are_expanded_by_forks_of_one_process_that_keep_nothing_of_each_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    inside = '<xacro:property name="b" value="${load_yaml(\'b.yaml\').x}"/><a b="${b}"/>'
    monkeypatch.setenv("HEARD", "one")
    assert b'b="one"' in _expand(tmp_path, '<a b="$(env HEARD)"/>').text
    process = EXPANDER.process
    monkeypatch.setenv("HEARD", "two")
    assert b'b="two"' in _expand(tmp_path, '<a b="$(env HEARD)"/>').text
    (tmp_path / "package" / "urdf" / "b.yaml").write_text("x: 5", encoding="utf-8")
    assert b'b="5"' in _expand(tmp_path, inside).text
    with pytest.raises(RobotError, match="more than 1 s of computing"):
        _expand(tmp_path, "<a b='${9**9**9}'/>")
    assert EXPANDER.process is process
    assert b'b="two"' in _expand(tmp_path, '<a b="$(env HEARD)"/>').text


def test_an_expansion_that_waits_or_was_killed_answers_no_other_file() -> None:
    expander, good = Expander(), request(SEED)
    with closing(expander):
        assert b"left_joint" in expander.ask(good)
        killed = expander.process
        killed.kill()
        killed.wait()
        assert b"left_joint" in expander.ask(good)
        os.killpg(expander.process.pid, signal.SIGSTOP)
        expander.patience = 0.1
        with pytest.raises(TimeoutError, match=r"no end after 0\.1 s"):
            expander.ask(good)
        expander.patience = 60.0
        assert b"cannot be read" in expander.ask(request(Path("/none")))


def test_the_process_ends_with_the_one_that_started_it() -> None:
    code = (
        "from arjuna_sim.files.urdf.xacro_file import EXPANDER; import os, time;"
        "print('started', EXPANDER.process.pid, flush=True); time.sleep(60.0)"
    )
    with Lines("-c", code) as lines:
        pid = int(lines.wait_for("started")[0].split()[1])
        lines.process.kill()
        assert ended(pid)
