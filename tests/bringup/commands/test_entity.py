"""The commands `entity` and `world`: what they take and refuse."""

from __future__ import annotations

import pytest

from bringup.cli import parse


def test_spawn_takes_a_position_and_a_path() -> None:
    words = ["entity", "spawn", "bob", "person", "--at", "-1", "2", "--path", "-2,-2 2,-2 2,2.5"]
    arguments = parse([*words, "--speed", "0.8", "--once"])
    assert arguments.at == [-1.0, 2.0]
    assert arguments.path == [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.5)]
    assert (arguments.speed, arguments.once, arguments.yaw) == (0.8, True, 0.0)


def test_robot_is_moved_by_name_with_negative_coordinates() -> None:
    arguments = parse(["entity", "move", "robot", "-1.5", "-2", "--yaw", "-0.5"])
    assert (arguments.name, arguments.x, arguments.y) == ("robot", -1.5, -2.0)
    assert arguments.yaw == -0.5


@pytest.mark.parametrize("action", ["spawn", "move", "delete", "list"])
def test_every_action_has_help(action: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        parse(["entity", action, "--help"])
    assert "usage: " in capsys.readouterr().out
