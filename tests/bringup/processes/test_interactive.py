"""Processes that the orchestrator starts beside the robot's processes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from arjuna_core.errors import InputFileError
from bringup.processes.interactive import record_command

pytestmark = pytest.mark.ros


def test_a_robot_s_recorder_leaves_other_robots_alone() -> None:
    *_, option, pattern = record_command(Path(), "one")
    assert option == "--topics"
    assert re.fullmatch(pattern, "/one/scan")
    assert not re.fullmatch(pattern, "/one_more/scan")


def test_a_robot_without_a_namespace_records_everything() -> None:
    assert record_command(Path(), "")[-1] == "record"


def test_a_recording_is_not_overwritten(tmp_path: Path) -> None:
    with pytest.raises(InputFileError, match="exists already"):
        record_command(tmp_path, "")
