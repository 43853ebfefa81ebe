"""Processes that the orchestrator starts beside the robot's processes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from arjuna_core.errors import InputFileError
from bringup.cli import parse
from bringup.processes.interactive import host_command, record_command

pytestmark = pytest.mark.ros


def test_a_robot_s_recorder_leaves_other_robots_alone() -> None:
    *_, option, pattern = record_command(Path(), "one")
    assert option == "--topics"
    assert re.fullmatch(pattern, "/one/scan")
    assert not re.fullmatch(pattern, "/one_more/scan")


def test_remappings_reach_the_processes() -> None:
    arguments = parse(["nav", "--slam", "--remap", "/scan:=/front", "--remap", "tf:=/tf"])
    words = host_command("navigation", Path("p"), arguments)
    assert words[words.index("--remap") :] == ["--remap", "/scan:=/front", "--remap", "tf:=/tf"]
    assert "--remap" not in host_command("sim", Path("p"), parse(["sim"]))


@pytest.mark.parametrize("rule", ["docking_server:cmd_vel:=unused", "amcl:rostopic://scan:=front"])
def test_a_remapping_may_be_that_of_one_node(rule: str) -> None:
    arguments = parse(["nav", "--slam", "--remap", rule])
    assert host_command("navigation", Path("p"), arguments)[-1] == rule


def test_a_remapping_is_checked(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        parse(["nav", "--slam", "--remap", "scan=/front"])
    assert "'scan=/front' is no remapping; valid: OLD:=NEW" in capsys.readouterr().err


def test_a_robot_without_a_namespace_records_everything() -> None:
    assert record_command(Path(), "")[-1] == "record"


def test_a_recording_is_not_overwritten(tmp_path: Path) -> None:
    with pytest.raises(InputFileError, match="exists already"):
        record_command(tmp_path, "")
