"""`rosdep`, as tutorials print it before `colcon build`: it says what a workspace lacks."""

from __future__ import annotations

from pathlib import Path

import pytest

from bringup.ros2.workspace.rosdep import main

pytestmark = pytest.mark.ros
_TUTORIAL = "install -i --from-path src --rosdistro jazzy -y"
_MANIFEST = (
    "<package><name>{}</name>{}<export><build_type>ament_python</build_type></export></package>"
)


@pytest.fixture
def source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("AMENT_PREFIX_PATH", "")
    return tmp_path / "src"


def _package(source: Path, name: str, depends: str) -> None:
    folder = source / name
    folder.mkdir(parents=True)
    needs = "".join(f"<depend>{one}</depend>" for one in depends.split())
    (folder / "package.xml").write_text(_MANIFEST.format(name, needs))


@pytest.mark.parametrize(
    "words",
    [_TUTORIAL, "install --from-paths src --ignore-src -r -y", "install -iy --from-paths src"],
)
def test_a_workspace_of_what_is_here_is_well(
    source: Path, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    _package(source, "one", "rclpy nav_msgs tf2_ros cv_bridge launch_ros nav2_bringup two ros_gz")
    _package(source, "two", "ament_python python3-numpy python3-yaml-pip rosidl_default_generators")
    assert main(words.split()) == 0
    assert capsys.readouterr().out == "#All required rosdeps installed successfully\n"
    assert main(["check", "--from-paths", "src"]) == 0
    assert capsys.readouterr().out == "All system dependencies have been satisfied\n"


def test_what_is_lacking_is_named_with_who_needs_it(
    source: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _package(source, "one", "rclpy rplidar_ros python3-nothing-there python3-sklearn")
    _package(source, "two", "rplidar_ros")
    assert main(_TUTORIAL.split()) == 1
    said = capsys.readouterr().err
    assert "python3-nothing-there (of one) is not here; 'pip install nothing-there'" in said
    assert "python3-sklearn (of one) is not here; 'pip install scikit-learn'" in said
    assert "rplidar_ros (of one, two) is not here; its driver is ROS's" in said
    assert "'colcon build' builds what does without" in said
    assert main(["install", "--from-paths", "src", "--ignore-src", "-ry"]) == 0
    skipped = ["--skip-keys", "rplidar_ros python3-nothing-there python3-sklearn"]
    assert main([*_TUTORIAL.split(), *skipped]) == 0
    assert main(["keys", "--from-paths", "src"]) == 0
    assert capsys.readouterr().out.splitlines()[1:] == [
        "python3-nothing-there",
        "python3-sklearn",
        "rclpy",
        "rplidar_ros",
    ]


def test_there_is_nothing_to_update_and_no_workspace_is_told(
    source: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["update", "--rosdistro", "jazzy"]) == 0
    assert "nothing to update" in capsys.readouterr().out
    assert main(_TUTORIAL.split()) == 1
    assert "no packages below src" in capsys.readouterr().err
    with pytest.raises(SystemExit, match="2"):
        main(["leap"])
    assert "invalid choice: 'leap'" in capsys.readouterr().err
