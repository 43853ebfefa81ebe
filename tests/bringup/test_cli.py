"""The command line: words, help, errors, the terminal's width."""

from __future__ import annotations

import argparse
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest

from bringup import cli, interrupts
from bringup.__main__ import main
from bringup.cli import parse
from bringup.commands import COMMANDS, module_of
from bringup.ros2 import main as ros2
from bringup.terminal import RIGHT, UP, Keys

EVERY = [name for group in COMMANDS.values() for name in group]
NODE_COMMANDS = {"sim": [], "slam": [], "nav": ["--map", "m.yaml"], "demo": []}


@pytest.mark.parametrize("command", NODE_COMMANDS)
def test_every_command_takes_parameter_files_in_order(command: str) -> None:
    arguments = parse(
        [command, *NODE_COMMANDS[command], "--params", "a.yaml", "--params", "b.yaml"]
    )
    assert arguments.params == [Path("a.yaml"), Path("b.yaml")]


@pytest.mark.parametrize("command", NODE_COMMANDS)
def test_every_command_has_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        parse([command, "--help"])
    assert "--log-level" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("argv", "problem"),
    [
        (["nav"], "one of the arguments --map --slam --without-localization is required"),
        (["nav", "--map", "m", "--slam"], "not allowed with argument --map"),
        (["fly"], "invalid choice: 'fly'"),
        (["simm"], "invalid choice: 'simm'; did you mean 'sim'?"),
        (["lesson", "9"], "invalid choice: 9; valid: 1, 2, 3, 4, 5"),
        (["sim", "--plugin-path", "no.py"], "'no.py' is no folder, package or .py file"),
        (["sim", "--wrld", "a"], "unrecognized arguments: --wrld; the nearest is '--world'"),
        (["sim", "--wrld=a"], "unrecognized arguments: --wrld; the nearest is '--world'"),
        (["entity", "spawn", "a", "box", "--yow", "1"], "--yow; the nearest is '--yaw'"),
        (["params", "chek", "a.yaml"], "did you mean 'check'?"),
        (["sim", "--seed", "-1"], "'-1' is no seed; valid: a whole number from 0"),
        (["sim", "--seed", "1.5"], "'1.5' is no seed"),
        (["sim", "--seed", "9223372036854775808"], "is no seed"),
        (["sim", "--rtf", "-0.1"], "'-0.1' is no factor; valid: a number from 0"),
        (["sim", "--rtf", "nan"], "'nan' is no factor"),
        (["sim", "--rtf", "inf"], "'inf' is no factor"),
        (["sim", "--log-level", "loud"], "invalid choice: 'loud'"),
        (["sim", "--namespace", "a b"], "'a b' is no namespace; valid: words"),
        (["goto", "1", "2", "--namespace", "a//b"], "'a//b' is no namespace"),
        (["nav", "--slam", "--domain-id", "233"], "'233' is no domain; valid: 0 to 232"),
        (["explore", "--world", "w.world"], "unrecognized arguments: --world"),
        (["entity"], "required: ACTION"),
        (["entity", "fly"], "invalid choice: 'fly'"),
        (["entity", "spawn", "a"], "required: WHAT"),
        (["entity", "move", "a", "1", "nan"], "'nan' is no finite number"),
        (["entity", "spawn", "a", "person", "--path", "1,1"], "is no path"),
        (["entity", "spawn", "a", "person", "--path", "1 2"], "'1' is no point; valid: X,Y"),
        (["entity", "spawn", "a", "person", "--speed", "0"], "'0' is no number above 0"),
        (["world", "step", "0"], "'0' is no count; valid: 1 to"),
        (["world", "step", "1.5"], "'1.5' is no count"),
        (["world", "reset", "--scope", "half"], "invalid choice: 'half'"),
    ],
)
def test_a_wrong_command_line_is_refused_with_exit_code_2(
    argv: list[str], problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        parse(argv)
    first, blank, usage = capsys.readouterr().err.split("\n", 2)
    assert first.startswith("error: ")
    assert problem in first
    assert blank == ""
    assert usage.startswith("usage: python -m bringup")


@pytest.mark.parametrize("command", ["sim", "teleop", "avoid", "explore", "world list"])
def test_a_robot_is_chosen_by_namespace_and_domain(command: str) -> None:
    name, *rest = command.split()
    arguments = parse([name, "--namespace", "/robot1/", "--domain-id", "7", *rest])
    assert (arguments.namespace, arguments.domain_id) == ("robot1", 7)
    assert parse([name, *rest]).namespace == ""


@pytest.mark.parametrize("name", EVERY)
def test_a_commands_examples_are_understood(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        parse([name, "--help"])
    shown = capsys.readouterr().out
    for line in module_of(name).EXAMPLES:
        assert f"bringup {line}\n" in shown
        assert parse(shlex.split(line)).command == name


def test_the_demo_writes_to_out_demo_by_default() -> None:
    assert parse(["demo"]).out == Path("out/demo")
    assert parse(["demo", "--out", "x"]).out == Path("x")


def test_without_a_command_the_first_page_is_shown(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cli.run(parse([])) == 0
    page = capsys.readouterr().out
    assert "nav --map" in page
    assert all(f"  {name} " in page for name in EVERY)


def test_help_imports_neither_numpy_nor_ros() -> None:
    source = (
        "import sys; sys.argv = ['bringup', '--help']\n"
        "import bringup.__main__ as m\n"
        "try: m.main()\n"
        "except SystemExit: pass\n"
        "print(sorted({'numpy', 'rclpy', 'mujoco', 'yaml'} & set(sys.modules)))"
    )
    run = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines()[-1] == "[]"


def test_ctrl_c_while_the_command_line_is_read_ends_without_a_traceback(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "parse", interrupted)
    monkeypatch.setattr(interrupts, "watch_interrupts", lambda: None)  # the handler stays pytest's
    assert main() == 130


def test_sim_takes_several_robots_each_with_its_namespace_and_start() -> None:
    first, second = "--robot a.urdf --namespace /a/ --at 1 -2", "--robot b.urdf --namespace b"
    arguments = parse(["sim", *first.split(), *second.split(), "--at", "0", "0"])
    assert arguments.robots == [Path("a.urdf"), Path("b.urdf")]
    assert arguments.namespaces == ["a", "b"]
    assert arguments.ats == [[1.0, -2.0], [0.0, 0.0]]


PYPROJECT = Path(__file__).resolve().parents[2] / "pyproject.toml"


def said_without(module: str, capsys: pytest.CaptureFixture[str]) -> str:
    """Return what is said where a command's module is missing."""

    def command(arguments: argparse.Namespace) -> int:
        raise ModuleNotFoundError(f"No module named {module!r}", name=module)

    assert cli.run(argparse.Namespace(run=command)) == cli.REFUSED
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("module", "extra"),
    [("rerun", "view"), ("rerun.blueprint", "view"), ("optuna", "tune"), ("pyarrow", "campaign")],
)
def test_a_module_of_an_extra_is_named_with_the_words_that_install_it(
    module: str, extra: str, capsys: pytest.CaptureFixture[str]
) -> None:
    said = said_without(module, capsys)
    assert said.startswith(f"error: the module {module} is not installed")
    assert f"'make setup EXTRAS={extra}'" in said


def test_ctrl_c_while_an_extension_is_imported_ends_as_at_any_time(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def command(arguments: Any) -> int:
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            raise ImportError("initialization failed") from error

    assert cli.run(argparse.Namespace(run=command)) == cli.INTERRUPTED
    assert capsys.readouterr().err == "\nstopped\n"
    monkeypatch.setattr(ros2, "load", lambda name: command)
    assert ros2.main(["run", "tf2_ros", "tf2_echo", "a", "b"]) == 0
    assert ros2.main(["topic", "list"]) == ros2.INTERRUPTED
    broken = Mock(side_effect=ImportError("no symbol"))
    monkeypatch.setattr(ros2, "load", lambda name: broken)
    with pytest.raises(ImportError, match="no symbol"):
        ros2.main(["topic", "list"])
    with pytest.raises(ImportError, match="no symbol"):
        cli.run(argparse.Namespace(run=broken))
    monkeypatch.setattr(cli, "was_interrupted", lambda: True)  # which the extension dropped
    assert cli.run(argparse.Namespace(run=broken)) == cli.INTERRUPTED


def test_another_module_asks_for_the_whole_set_up(capsys: pytest.CaptureFixture[str]) -> None:
    assert "run 'make setup'\n" in said_without("numba", capsys)


def test_the_extras_are_those_of_the_project() -> None:
    text = PYPROJECT.read_text(encoding="utf-8")
    for module, extra in cli.EXTRAS.items():
        (packages,) = re.findall(rf"^{extra} = \[(.*)\]", text, re.MULTILINE)
        assert re.search(rf'"{module.replace("_", "-")}(-sdk)?"', packages), module


def test_arrows_and_escape_are_keys(monkeypatch: pytest.MonkeyPatch) -> None:
    ours, theirs = os.openpty()
    with open(theirs) as terminal:  # noqa: PTH123 - a descriptor
        monkeypatch.setattr("sys.stdin", terminal)
        with Keys() as keys:
            assert keys.live
            os.write(ours, f"a{UP}{RIGHT} \x1b".encode())
            assert [keys.wait(5.0) for _ in range(5)] == ["a", UP, RIGHT, " ", "\x1b"]
            assert keys.wait(0.0) == ""
    os.close(ours)
