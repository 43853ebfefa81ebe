"""`ros2 run controller_manager ros2_control_node`: whose hardware is mock is simulated."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from bringup.ros2.programs import mock_hardware

pytestmark = pytest.mark.ros
_ROBOT = """<robot name="bot"><link name="base_link"/>
<joint name="a" type="continuous"><parent link="base_link"/><child link="l"/></joint>
<link name="l"/><ros2_control name="s" type="system">
<hardware><plugin> {} </plugin></hardware><joint name="a"/></ros2_control></robot>"""
_YAML = "arm:\n  ros__parameters: {type: forward_command_controller/ForwardCommandController}\n"


def _run(plugin: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """Return what is started; a file of parameters has the robot's description."""
    started: list[list[str]] = []

    def start(command: str, words: list[str]) -> None:
        started.append([command, *words])
        if "--robot" in words:
            robot = Path(words[words.index("--robot") + 1])
            started.append([robot.read_text(encoding="utf-8")])

    monkeypatch.setattr(mock_hardware, "arjuna", start)
    monkeypatch.setattr("signal.pause", lambda: started.append(["waits"]))
    controllers, robot = folder / "a&b.yaml", folder / "robot.yaml"
    controllers.write_text(_YAML, encoding="utf-8")
    text = _ROBOT.format(plugin).replace("\n", " ").replace('"', "'")
    robot.write_text(f'/**: {{ros__parameters: {{robot_description: "{text}"}}}}', encoding="utf-8")
    files = [word for path in (controllers, robot) for word in ("--params-file", str(path))]
    mock_hardware.main(["--ros-args", *files, "-r", "__ns:=/r1"])
    return started


@pytest.mark.parametrize("package", ["mock", "fake"])
def test_mock_hardware_is_simulated_with_its_controllers(
    package: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plugin = f"{package}_components/GenericSystem"
    (command, *words), (text,) = _run(plugin, tmp_path, monkeypatch)
    assert (command, text[-8:]) == ("sim", "</robot>")
    assert words[1].endswith("empty.world")
    assert words[4:] == ["--without-description", "--namespace", "/r1"]
    assert f"<parameters>{tmp_path}/a&amp;b.yaml</parameters>" in text


def test_other_hardware_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert _run("my_arm/Bus", tmp_path, monkeypatch) == [["waits"]]
    assert "hardware is ROS's: my_arm/Bus" in capsys.readouterr().out
