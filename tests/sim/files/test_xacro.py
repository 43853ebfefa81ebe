"""Robots' files: xacro and how wheels are found."""

from __future__ import annotations

import dataclasses
import subprocess
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import RobotError
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.urdf.xacro_file import Expanded, expand, has_macros
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import DriveKind
from arjuna_sim.simulation import Simulation, solo
from tests.sim.builders import run, texts
from tests.sim.generated import level
from tests.sim.robot_files.options import RobotFile, robot_files
from tests.sim.robot_files.package import write

pytest.importorskip("xacro")
ALL = {"arm": "true", "use_sim": "true"}
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


def test_what_is_false_by_default_is_named_where_a_drive_or_a_sensor_lacks(tmp_path: Path) -> None:
    arguments = "".join(
        f'<xacro:arg name="{name}" default="{value}"/>'
        for name, value in (("arm", "False"), ("use_sim", "false"), ("rate", "9"), ("idle", "0"))
    )
    sensor = '<gazebo reference="a"><sensor type="imu" name="i"/></gazebo>'
    inside = arguments + (
        '<link name="a"/><xacro:if value="$(arg arm)"/>'
        f'<xacro:if value="$(arg use_sim)">{sensor}</xacro:if><!-- $(arg rate) -->'
        '<xacro:arg name="shown" default="false"/><gazebo><visible>$(arg shown)</visible></gazebo>'
    )
    expanded = _expand(tmp_path, inside)
    assert expanded.off == ("arm", "use_sim")
    assert _expand(tmp_path, inside, arm="false").off == ("use_sim",)
    path = tmp_path / "package" / "urdf" / "r.xacro"
    (said,) = [note for note in texts(load_robot(path).notes) if "false by default" in note]
    assert said.startswith("no drive plugin and no sensors: use_sim:=true may bring ")
    assert said.endswith("; false by default are use_sim, arm")
    on = load_robot(path, arguments={"use_sim": "true"})
    assert "no drive plugin: arm:=true may bring" in " ".join(texts(on.notes))
    assert not any("by default" in n for n in texts(load_robot(path, arguments=ALL).notes))


@pytest.mark.parametrize(
    ("inside", "remedy"),
    [
        (
            '<xacro:macro name="m"><xacro:insert_block name="b"/></xacro:macro><xacro:m/>',
            "params names it with a star, *NAME",
        ),
        ('<xacro:macro name="m" params="p"/><xacro:m/>', "params a default"),
        ('<a b="${width}"/>', "<xacro:property> or <xacro:arg> defines it"),
        ('<macro name="m" params="p"><a b="${p}"/></macro><xacro:m p="1"/>', "<xacro:macro> is"),
    ],
)
def test_a_refusal_says_what_is_missing(tmp_path: Path, inside: str, remedy: str) -> None:
    with pytest.raises(RobotError) as refused:
        _expand(tmp_path, inside)
    assert remedy in refused.value.problem


def test_bare_tags_of_old_xacro_are_noted_once_unless_in_comments(tmp_path: Path) -> None:
    commented = '<!-- <macro name="m"/> --><link name="a"/>'
    assert not _expand(tmp_path, commented).notes
    bare = '<property name="p" value="1"/><property name="q" value="1"/><link name="a"/>'
    (note,) = _expand(tmp_path, bare).notes
    assert (note.kind, "<xacro:property> is" in note.text) == (NoteKind.BROKEN, True)


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


def test_a_package_is_the_folder_of_its_name_that_has_a_manifest(tmp_path: Path) -> None:
    inner = tmp_path / "parts" / "parts"  # as in a repository named as its package
    inner.mkdir(parents=True)
    search, beside = SearchPath((tmp_path / "parts",)), tmp_path / "r.xacro"
    assert search.package(beside, "parts") == tmp_path / "parts"
    (inner / "package.xml").write_text("<package><name>parts</name></package>", encoding="utf-8")
    assert search.package(beside, "parts") == inner


def test_files_are_expanded_by_the_environment_of_the_call(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    inside = '<xacro:property name="b" value="${load_yaml(\'b.yaml\').x}"/><a b="${b}"/>'
    for value in ("one", "two"):
        monkeypatch.setenv("HEARD", value)
        assert f'b="{value}"'.encode() in _expand(tmp_path, '<a b="$(env HEARD)"/>').text
    (tmp_path / "package" / "urdf" / "b.yaml").write_text("x: 5", encoding="utf-8")
    assert b'b="5"' in _expand(tmp_path, inside).text


def test_an_expansion_that_does_not_end_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(RobotError, match="more than 1 s of computing"):
        _expand(tmp_path, "<a b='${9**9**9}'/>")
    with pytest.raises(RobotError, match="it takes more than 400 MB"):
        _expand(tmp_path, "<a b='${len(2**29 * [0])}'/>")

    def run(command: object, timeout: float, **given: object) -> None:
        raise subprocess.TimeoutExpired("xacro", timeout)

    monkeypatch.setattr("subprocess.run", run)
    with pytest.raises(RobotError, match="no end after 20 s"):
        _expand(tmp_path, "<a/>")


_PLAIN = [dataclasses.replace(file, macros=False) for file in robot_files(20, seed=3)]


def _read(file: RobotFile, folder: Path) -> RobotModel:
    return load_robot(write(file, folder))


@pytest.mark.parametrize("file", _PLAIN, ids=lambda file: file.name)
def test_wheels_are_found_however_they_are_written(file: RobotFile, tmp_path: Path) -> None:
    robot = _read(file, tmp_path)
    count = {"two": 2, "six": 6, "skid": 4, "ackermann": 2, "tricycle": 2}[file.layout]
    assert len(robot.drive.wheels) == count
    assert robot.drive.effective_radius == pytest.approx(file.radius, rel=0.01)
    assert (robot.drive.kind is DriveKind.STEERED) is file.steers
    if not file.steers:
        assert robot.drive.separation == pytest.approx(file.track, rel=0.01)


def test_macros_and_what_they_expand_to_are_one_robot(tmp_path: Path) -> None:
    file = RobotFile(hubs=1, macros=True, friction=0.9)
    of_macros = _read(file, tmp_path / "macros")
    plain = _read(dataclasses.replace(file, macros=False), tmp_path / "plain")
    assert of_macros.drive == plain.drive
    assert of_macros.urdf.mass == plain.urdf.mass
    assert of_macros.settings.friction == plain.settings.friction


@pytest.mark.parametrize("solid", ["cylinder", "drawn mesh", "none"])
def test_an_inertia_that_no_wheel_can_have_is_replaced(tmp_path: Path, solid: str) -> None:
    robot = _read(RobotFile(inertia="one", solid=solid), tmp_path)
    note = next(n for n in texts(robot.notes) if "cannot have an inertia of 1 kg m^2" in n)
    assert note.startswith("link 'left_wheel_link'")
    sim = Simulation(solo(robot), level(), SimulatorConfig(), np.random.default_rng(0))
    assert run(sim, 2.0, Velocity(0.3)).truth.v == pytest.approx(0.3, rel=0.02)


def test_a_great_inertia_that_its_size_allows_is_kept(tmp_path: Path) -> None:
    robot = _read(RobotFile(inertia="solid"), tmp_path)
    inertial = robot.urdf.links["left_wheel_link"].inertial
    assert inertial is not None
    mass, radius = 0.02 * 5.0, 0.05
    assert np.linalg.eigvalsh(inertial.inertia)[2] == pytest.approx(mass * radius**2 / 2.0)


def test_wheels_that_are_only_drawn_leave_a_caster_to_slide(tmp_path: Path) -> None:
    robot = _read(RobotFile(solid="drawn mesh", caster="mesh"), tmp_path)
    assert robot.settings.friction["caster_link"] == pytest.approx(0.01)


def test_free_wheels_hardly_brake_the_lightest_robot(tmp_path: Path) -> None:
    file = RobotFile("ackermann", radius=0.025, mass=0.2, friction=0.7)
    sim = Simulation(
        solo(_read(file, tmp_path)), level(), SimulatorConfig(), np.random.default_rng(0)
    )
    assert run(sim, 2.0, Velocity(0.3)).truth.v == pytest.approx(0.3, rel=0.01)


def test_a_robot_without_a_radius_is_refused_by_name(tmp_path: Path) -> None:
    file = RobotFile("skid", solid="none", drive="gz")
    path = write(file, tmp_path)
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace(f"<wheel_radius>{file.radius}</wheel_radius>", ""), "utf-8")
    with pytest.raises(RobotError, match="the wheels' radius is unknown; <wheel_diameter> gives"):
        load_robot(path)
