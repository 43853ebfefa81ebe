"""`ros2 run robot_state_publisher robot_state_publisher`: a description's text reaches the node."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

from bringup.ros2.errors import Ros2Error
from bringup.ros2.programs import robot_state_publisher
from bringup.ros2.verbs.forward import ros_arguments

TEXT = '<?xml version="1.0"?>\n<robot name="r"><link name="base_link"/></robot>'


def _started(words: list[str], monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    started: list[list[str]] = []
    monkeypatch.setattr(os, "execv", lambda path, words: started.append(words))
    robot_state_publisher.start(ros_arguments(words))
    values: dict[str, Any] = json.loads(started[0][-1])["robot_state_publisher"]
    return values


def test_the_text_goes_by_a_file(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    description = ["-p", f"robot_description:={TEXT}"]
    others = ["-p", "use_sim_time:=true", "-p", "publish_frequency:=30", "-r", "tf:=other"]
    values = _started(["--ros-args", *description, *others], monkeypatch)
    path = Path(values.pop("robot"))
    assert path.read_text(encoding="utf-8") == TEXT
    path.unlink()
    assert values == {"use_sim_time": True, "publish_frequency": 30.0}
    assert capsys.readouterr().out == "no effect: tf\n"


def test_a_file_is_taken_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    values = _started([str(tmp_path / "a.urdf")], monkeypatch)
    assert values == {"robot": str(tmp_path / "a.urdf"), "use_sim_time": False}


def test_no_description_is_refused() -> None:
    with pytest.raises(Ros2Error, match="no robot: -p robot_description:="):
        robot_state_publisher.start(ros_arguments([]))
