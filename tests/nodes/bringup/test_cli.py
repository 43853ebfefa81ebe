"""The commands' inputs: what they become, and that a bad one starts nothing."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any, ClassVar

import pytest

from arjuna_core.errors import ArjunaError
from arjuna_core.files.shipped import shipped_file
from bringup import cli
from bringup.cli import parse
from bringup.parameters import inputs
from bringup.processes import interactive
from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SLAM_GROUP, Group
from tests.helpers.processes import given_parameters

BURGER = str(shipped_file("urdf/burger.urdf"))


class Starts:
    """Stands in for the supervisor: remembers what it was to start."""

    specs: tuple[Any, ...] = ()
    parameters: ClassVar[dict[str, Any]] = {}

    def __init__(self, specs: Any, output: Any) -> None:
        Starts.specs = tuple(specs)
        Starts.parameters = given_parameters(Starts.specs[0].command)

    def run(self) -> int:
        """Pretend a clean stop."""
        return 0


@pytest.fixture(autouse=True)
def _nothing_starts(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(interactive, "Supervisor", Starts)
    monkeypatch.setattr(Starts, "specs", ())
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))


def _write(name: str, text: str) -> str:
    Path(name).write_text(text)
    return name


def _sim(key: str, value: Any, node: str = "sim") -> str:
    return f"{node}:\n  ros__parameters:\n    {key}: {value}\n"


def test_sim_starts_one_process_that_gets_the_checked_parameters() -> None:
    assert cli.run(parse(["sim", "--seed", "7", "--log-level", "warn"])) == 0
    (spec,) = Starts.specs
    assert spec.name == "sim"
    assert Starts.parameters["sim"]["seed"] == 7
    assert len(" ".join(spec.command)) < 300, "a line of ps"
    assert spec.command[-3:] == ["--disable-external-lib-logs", "--log-level", "warn"]


def test_options_win_over_files_and_later_files_over_earlier() -> None:
    first = _write("a.yaml", _sim("seed", 1) + "    real_time_factor: 2.0\n")
    second = _write("b.yaml", _sim("real_time_factor", 3.0))
    arguments = parse(["sim", "--params", first, "--params", second, "--seed", "5"])
    values = inputs.gather(arguments)["sim"]
    assert (values["seed"], values["real_time_factor"]) == (5, 3.0)


def test_files_are_handed_on_as_absolute_paths() -> None:
    robot = _write("my.urdf", shipped_file("urdf/arjuna.urdf").read_text())
    parameters = inputs.gather(parse(["sim", "--robot", robot, "--rtf", "0"]))
    assert parameters["sim"]["robot"] == str(Path("my.urdf").resolve())
    assert parameters["robot_state_publisher"]["robot"] == parameters["sim"]["robot"]
    assert parameters["sim"]["real_time_factor"] == 0.0


def test_shipped_files_are_found_from_any_folder_unless_one_of_that_name_is_there() -> None:
    names = ["maps/office.yaml", "urdf/burger.urdf", "guides/ros2/params.yaml"]
    shipped = [shipped_file(name) for name in names]
    options = zip(["--map", "--robot", "--params"], names, strict=True)
    argv = ["nav", *(word for pair in options for word in pair)]
    arguments = parse(argv)
    assert [arguments.map, arguments.robot, *arguments.params] == shipped
    Path("maps").mkdir()
    Path("maps/office.yaml").touch()
    assert parse(argv).map == Path("maps/office.yaml")


def test_several_robots_are_parameters_of_a_simulator_without_a_namespace() -> None:
    argv = ["sim", "--robot", BURGER, "--namespace", "a", "--namespace", "b", "--at", "1", "2"]
    argv += ["--yaw", "3", "--at", "4", "5", "--yaw", "6"]
    assert cli.run(parse(argv)) == 0
    (host,) = Starts.specs
    assert host.name == "world"
    assert "--namespace" not in host.command


def test_a_namespaced_robot_takes_files_with_and_without_its_namespace() -> None:
    plain = _write("a.yaml", _sim("seed", 3))
    below = _write("b.yaml", _sim("real_time_factor", 2.0, "robot1/sim"))
    argv = ["sim", "--namespace", "robot1", "--params", plain, "--params", below]
    values = inputs.gather(parse(argv))["sim"]
    assert (values["seed"], values["real_time_factor"]) == (3, 2.0)
    assert cli.run(parse(argv)) == 0
    assert "--namespace robot1" in " ".join(Starts.specs[0].command)


def test_a_maps_folder_is_that_of_every_node_that_reads_or_writes_maps() -> None:
    parameters = inputs.gather(parse(["slam", "--maps-folder", "mine"]))
    for node in ("map_saver", "slam_toolbox"):
        assert parameters[node]["maps_folder"] == str(Path("mine").resolve())


@pytest.mark.parametrize("command", ["nav", "robot"])
@pytest.mark.parametrize(
    ("words", "groups"),
    [
        ("--map m.yaml", (LOCALIZATION_GROUP, NAVIGATION_GROUP)),
        ("--map m.yaml --without-navigation", (LOCALIZATION_GROUP,)),
        ("--slam --without-navigation", (SLAM_GROUP,)),
        ("--without-localization", (NAVIGATION_GROUP,)),
    ],
)
def test_halves_may_be_left_out(command: str, words: str, groups: tuple[Group, ...]) -> None:
    assert inputs.groups_of(parse([command, *words.split()])) == groups


def test_both_halves_may_not_be_left_out() -> None:
    with pytest.raises(ArjunaError, match="nothing is left to run"):
        inputs.groups_of(parse(["nav", "--without-localization", "--without-navigation"]))


def test_parameters_of_the_command_line_win_over_files(tmp_path: Path) -> None:
    path = tmp_path / "slam.yaml"
    path.write_text("slam_toolbox: {ros__parameters: {mode: mapping, resolution: 0.1}}")
    words = ["--param", "mode:=lifelong", "--param", "slam_toolbox:map_update_interval:=3.0"]
    values = inputs.gather(parse(["slam", "--params", str(path), *words]))["slam_toolbox"]
    named = {"mode": "lifelong", "resolution": 0.1, "map_update_interval": 3.0}
    assert {key: values[key] for key in named} == named


PLUGIN = """
from arjuna_nav.controllers.graceful.controller import Graceful


class Mine(Graceful):
    pass
"""


@pytest.mark.parametrize("path", ["lib", "lib/mine_one.py", "lib/mine_two"])
def test_plug_ins_are_found_below_a_path_of_their_own(
    path: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.delenv("PYTHONPATH", raising=False)
    for name in ("lib/mine_one.py", "lib/mine_two/__init__.py"):
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        _write(name, PLUGIN)
    module = "mine_two" if path.endswith("two") else "mine_one"
    monkeypatch.delitem(sys.modules, module, raising=False)
    plugin = f"FollowPath: {{plugin: '{module}:Mine'}}"
    file = _write("mine.yaml", f"controller_server: {{ros__parameters: {{{plugin}}}}}")
    assert cli.run(parse(["params", "check", file])) == 1
    assert "--plugin-path says where it is" in capfd.readouterr().out
    assert cli.run(parse(["params", "check", file, "--plugin-path", path])) == 0
    argv = ["nav", "--slam", "--params", file, "--plugin-path", path]
    assert cli.run(parse(argv)) == 0
    assert os.environ["PYTHONPATH"].split(os.pathsep)[0] == str(Path("lib").resolve())


def test_a_domain_is_that_of_the_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "1")
    assert cli.run(parse(["sim", "--domain-id", "9"])) == 0
    assert os.environ["ROS_DOMAIN_ID"] == "9"


@pytest.mark.parametrize(
    ("files", "argv", "problem"),
    [
        ({}, ["--world", "no.world"], "no.world: cannot be read"),
        ({}, ["--viewer"], "needs a screen: neither DISPLAY nor WAYLAND_DISPLAY is set; 'python"),
        ({"w": "<sdf>"}, ["--world", "w"], "w: line 1: "),
        ({"r": "<sdf/>"}, ["--robot", "r"], "r: "),
        ({}, ["--params", "no.yaml"], "no.yaml: cannot be read"),
        ({"p": "a: [1"}, ["--params", "p"], "p: "),
        (
            {"p": _sim("sed", 1)},
            ["--params", "p", "--strict"],
            "p:3: unknown: sim: sed: no such parameter; the nearest is 'seed'",
        ),
        ({"p": _sim("tick", 0.03)}, ["--params", "p"], "'tick' 0.03 s must be a whole number of"),
    ],
)
def test_a_bad_input_is_refused_in_one_line_and_starts_nothing(
    files: dict[str, str],
    argv: list[str],
    problem: str,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    for name, text in files.items():
        _write(name, text)
    assert cli.run(parse(["sim", *argv])) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith("error: ")
    assert problem in line
    assert Starts.specs == ()


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (None, "cannot be read"),
        ("imag: m.pgm\n", "lacks the key 'image'; required: image, resolution, origin"),
        ("image: m.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n", "m.pgm does not exist"),
    ],
)
def test_a_bad_map_is_refused(
    text: str | None,
    problem: str,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(inputs, "groups_of", lambda arguments: (LOCALIZATION_GROUP,))
    if text is not None:
        _write("m.yaml", text)
    assert cli.run(parse(["nav", "--map", "m.yaml"])) == 2
    assert problem in capfd.readouterr().err
    assert Starts.specs == ()


def test_a_demo_folder_that_cannot_be_written_is_refused(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    _write("taken", "a file")
    monkeypatch.setattr(inputs, "gather", lambda arguments: {})
    assert cli.run(parse(["demo", "--out", "taken/demo"])) == 2
    assert "taken/demo: cannot be written: Not a directory" in capfd.readouterr().err
