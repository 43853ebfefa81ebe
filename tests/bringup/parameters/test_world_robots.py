"""Robots of a world's file: which of them are simulated, below which names, and where."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from arjuna_core.se2 import SE2
from bringup.cli import parse
from bringup.parameters.inputs import gather, groups_of
from bringup.stack import SIM_GROUP, WORLD_GROUP
from tests.sim.robot_worlds import Held, write

pytestmark = pytest.mark.ros
BLUE, GREEN = Held("blue", pose=SE2(1.0, 2.0, 0.5)), Held("7 green", pose=SE2(-1.0, 0.0, 0.0))


def _sim(*words: Any, command: str = "sim") -> dict[str, Any]:
    arguments = parse([command, *map(str, words)])
    values: dict[str, Any] = gather(arguments)["sim"]
    alone = "namespaces" not in values
    assert command != "sim" or groups_of(arguments) == ((SIM_GROUP if alone else WORLD_GROUP),)
    return values


def _start(values: dict[str, Any]) -> tuple[float, ...]:
    return tuple(values[f"initial_pose.{key}"] for key in ("x", "y", "yaw"))


@pytest.mark.parametrize("command", ["sim", "demo"])
def test_the_robot_of_a_world_is_the_robot(tmp_path: Path, command: str) -> None:
    world = write(tmp_path, BLUE)
    values = _sim("--world", world, command=command)
    assert values["robot"] == f"{world}#blue"
    assert _start(values) == pytest.approx((1.0, 2.0, 0.5))
    node = gather(parse([command, "--world", str(world)]))["robot_state_publisher"]
    assert node["robot"] == f"{world}#blue"


def test_what_is_asked_for_wins_over_the_world(tmp_path: Path) -> None:
    world = write(tmp_path, BLUE)
    other = _sim("--world", world, "--robot", "urdf/burger.urdf")
    assert other["robot"].endswith("burger.urdf")
    assert "initial_pose.x" not in other
    values = _sim("--world", world, "--at", "3", "0", "--heading", "0.1")
    assert (values["robot"], _start(values)) == (f"{world}#blue", (3.0, 0.0, 0.1))
    turned = _sim("--world", world, "--heading", "0.1")
    assert _start(turned) == pytest.approx((1.0, 2.0, 0.1))
    below = gather(parse(["sim", "--world", str(world), "--namespace", "a"]))["sim"]
    assert below["robot"] == f"{world}#blue"


@pytest.mark.parametrize("as_file", [True, False])
def test_a_world_of_a_parameter_gives_its_robot(tmp_path: Path, as_file: bool) -> None:
    world, file = write(tmp_path, BLUE), tmp_path / "given.yaml"
    file.write_text(f"sim:\n  ros__parameters:\n    world: {world}\n", encoding="utf-8")
    words = ("--params", file) if as_file else ("--param", f"sim:world:={world}")
    values = _sim(*words)
    assert (values["robot"], values["world"]) == (f"{world}#blue", str(world))
    assert _start(values) == pytest.approx((1.0, 2.0, 0.5))
    other = _sim(*words, "--param", "sim:robot:=urdf/burger.urdf")
    assert other["robot"] == "urdf/burger.urdf"
    assert "robot" not in _sim(*words, "--param", "sim:initial_pose.x:=3.0")


def test_several_robots_are_below_their_names(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    world = write(tmp_path, BLUE, GREEN)
    values = _sim("--world", world)
    assert values["robots"] == [f"{world}#blue", f"{world}#7 green"]
    assert values["namespaces"] == ["blue", "_7_green"]
    assert values["starts"] == pytest.approx([1.0, 2.0, 0.5, -1.0, 0.0, 0.0])
    said = f"{world} holds 2 robots: /blue/cmd_vel, /_7_green/cmd_vel\n"
    assert capsys.readouterr().err.count(said) == 1
    named = _sim("--world", world, "--namespace", "a", "--namespace", "b")
    assert (named["namespaces"], named["robots"]) == (["a", "b"], values["robots"])


def test_of_several_robots_one_can_be_chosen(tmp_path: Path) -> None:
    world = write(tmp_path, BLUE, GREEN)
    assert _sim("--world", world, "--namespace", "a")["robot"] == f"{world}#blue"
    assert _sim("--world", world, command="demo")["robot"] == f"{world}#blue"
    chosen = _sim("--world", world, "--robot", f"{world}#7 green")
    assert (chosen["robot"], _start(chosen)) == (f"{world}#7 green", (-1.0, 0.0, 0.0))
    only = _sim("--world", write(tmp_path, BLUE), "--robot", world)
    assert _start(only) == pytest.approx((1.0, 2.0, 0.5))


def test_more_namespaces_than_robots_are_of_the_shipped_one(tmp_path: Path) -> None:
    names = ("--namespace", "a", "--namespace", "b", "--namespace", "c")
    values = _sim("--world", write(tmp_path, BLUE, GREEN), *names)
    assert "robots" not in values
    assert "robot" not in values


def test_a_robot_that_is_broken_is_a_thing_with_the_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    world = write(tmp_path, BLUE)
    text = world.read_text(encoding="utf-8")
    world.write_text(text.replace(">front_left_wheel_joint<", ">no_joint<"), encoding="utf-8")
    assert "robot" not in _sim("--world", world)
    said = capsys.readouterr().err
    assert f"{world}#blue is taken for a thing" in said
    assert "joint 'no_joint' does not exist" in said
