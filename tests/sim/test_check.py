"""`sim --check`: what is understood of a file is printed, and all else is listed."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from arjuna_core.errors import InputFileError
from arjuna_sim.check import check, is_robot
from arjuna_sim.files.search_path import SearchPath
from bringup.cli import OK, REFUSED, parse, run
from tests.sim.builders import ROBOT, ROOM, ROOT, texts

MACRO = """<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="width" default="0.2"/><xacro:include filename="$(find parts)/wheel.xacro"/>
<link name="base"><inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>
<collision><geometry><box size="0.3 $(arg width) 0.1"/></geometry></collision></link>
<xacro:wheel name="left" y="${$(arg width) / 2}"/>
<xacro:wheel name="right" y="${-$(arg width) / 2}"/></robot>"""
WHEEL = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:macro name="wheel" params="name y">
<link name="${name}_wheel"><inertial><mass value="0.2"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4"/>
</inertial><collision><geometry><cylinder radius="0.06" length="0.02"/></geometry></collision>
</link><joint name="${name}_joint" type="continuous"><parent link="base"/>
<child link="${name}_wheel"/>
<origin xyz="0 ${y} 0" rpy="-1.5707963 0 0"/><axis xyz="0 0 1"/></joint></xacro:macro></robot>"""


@pytest.fixture(autouse=True)
def _no_paths(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("ROS_PACKAGE_PATH", "GAZEBO_MODEL_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.setenv(name, "")


@pytest.fixture
def macro(tmp_path: Path) -> Path:
    """Return a xacro file whose package `parts` only a package path finds."""
    (tmp_path / "robot").mkdir()
    (tmp_path / "elsewhere" / "parts").mkdir(parents=True)
    (tmp_path / "elsewhere" / "parts" / "wheel.xacro").write_text(WHEEL, encoding="utf-8")
    path = tmp_path / "robot" / "r.xacro"
    path.write_text(MACRO, encoding="utf-8")
    return path


@pytest.mark.parametrize("path", [ROOM, ROOT / "maps" / "arjuna_room.yaml"], ids=["sdf", "map"])
def test_worlds_are_understood(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(parse(["sim", "--check", str(path)])) == OK
    assert "loads" in capsys.readouterr().out


def test_a_named_robot_is_checked_as_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ball = (
        "<collision name='c'><geometry><sphere><radius>1</radius></sphere></geometry></collision>"
    )
    path = tmp_path / "model.sdf"
    path.write_text(
        f"<sdf version='1.9'><model name='m'><link name='l'>{ball}</link></model></sdf>"
    )
    for options, said in (
        (["--check", str(path)], "world"),
        (["--check", "--robot", str(path)], "robot 'm'"),
    ):
        assert run(parse(["sim", *options])) == OK
        assert capsys.readouterr().out.splitlines()[1].startswith(said)


@pytest.mark.usefixtures("without_sills")
def test_check_takes_the_robot_and_the_world_that_are_named(
    capsys: pytest.CaptureFixture[str],
) -> None:
    robot, world = ["--robot", str(ROBOT)], ["--world", str(ROOM)]
    for options, files in ((robot, [ROBOT]), (world, [ROOM]), ([*robot, *world], [ROBOT, ROOM])):
        assert run(parse(["sim", *options, "--check"])) == OK
        said = capsys.readouterr().out
        assert [line for line in said.splitlines() if line.endswith(": loads")] == [
            f"{file}: loads" for file in files
        ]
    assert run(parse(["sim", "--check"])) == REFUSED
    assert "--check: lacks its file; valid: --check FILE" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["none.urdf", "cut.urdf", "notes.txt"])
def test_file_that_does_not_load_is_refused_in_one_line(
    tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "cut.urdf").write_bytes(ROBOT.read_bytes()[:2000])
    (tmp_path / "notes.txt").write_text("hello", encoding="utf-8")
    assert run(parse(["sim", "--check", str(tmp_path / name)])) == REFUSED
    said = capsys.readouterr()
    assert said.err.startswith(f"error: {tmp_path / name}: ")
    assert said.err.count("\n") == 1


@pytest.mark.usefixtures("without_sills")
@pytest.mark.parametrize("is_last", [False, True])
def test_path_and_arguments_reach_macros(
    macro: Path, capsys: pytest.CaptureFixture[str], is_last: bool
) -> None:
    folder = macro.parents[1] / "elsewhere"
    options = ["--package-path", str(folder), "width:=0.4", "colour:=red"]
    first = ["--check", str(macro), *options]
    last = ["--robot", str(macro), *options[:-2], "--check", *options[-2:]]
    assert run(parse(["sim", *(last if is_last else first)])) == OK
    said = capsys.readouterr().out
    assert "wheel separation 0.4 m, diameter 0.12 m" in said
    assert "argument 'colour' is used nowhere" in said
    assert os.environ["ROS_PACKAGE_PATH"] == str(folder)


@pytest.mark.usefixtures("without_sills")
def test_guess_is_saved_and_loads_again(macro: Path, tmp_path: Path) -> None:
    search = SearchPath((macro.parents[1] / "elsewhere",))
    saved = tmp_path / "saved.xacro"
    found = check(macro, search, {}, saved)
    assert any("guessed are the wheels left_joint (left)" in note for note in texts(found.notes))
    again = check(saved, search, {})
    assert not any("guess" in note for note in texts(again.notes))
    assert "    left: left_joint; right: right_joint" in again.lines
    with pytest.raises(InputFileError, match="has a drive plugin"):
        check(saved, search, {}, tmp_path / "twice.xacro")


def test_robots_and_worlds_differ_by_their_root(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text("<?xml version='1.0'?><robot name='r'/>", encoding="utf-8")
    assert is_robot(path)
    assert not is_robot(ROOM)
    path.write_text("<html/>", encoding="utf-8")
    with pytest.raises(InputFileError, match="neither <robot> nor <sdf>"):
        is_robot(path)
