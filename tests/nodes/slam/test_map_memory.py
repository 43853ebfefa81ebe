"""Claims: a map outlives the process that makes it, where that is asked for."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("rclpy")
pytest.importorskip("slam_toolbox")

from rclpy.impl.rcutils_logger import RcutilsLogger
from slam_toolbox.srv import DeserializePoseGraph, Reset, SerializePoseGraph

from arjuna_slam.nodes.slam_toolbox import SlamToolboxNode
from tests.helpers.ros import RosBench
from tests.helpers.slam_robot import DT, Robot, started

pytestmark = pytest.mark.ros
DOWN = 10  # scans that nobody hears


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "slam_toolbox"


@pytest.fixture
def killed(robot: Robot, file: Path) -> SlamToolboxNode:
    """A mapper that has kept its map; no node learns that the process ends."""
    node = started(robot, resume_file=str(file), maps_folder=str(file.parent))
    robot.drive(55)
    node.memory.settle()
    return node


@pytest.fixture
def next_process(robot: Robot) -> Iterator[Robot]:
    """The robot as the next process meets it, which has driven on and is elsewhere by now."""
    bench = RosBench()
    later = Robot(bench)
    yield later
    bench.close()


def drive_on(robot: Robot, later: Robot, count: int = 10) -> None:
    """Let the robot be where it came to meanwhile, and drive on."""
    later.k, later.now = robot.k + DOWN, robot.now + DOWN * DT
    later.bench.advance(later.now)
    later.drive(count)


def test_the_next_process_goes_on_with_map_and_pose(
    robot: Robot, killed: SlamToolboxNode, file: Path, next_process: Robot
) -> None:
    again = started(next_process, resume_file=str(file))
    nodes = len(again.slam.graph)
    assert nodes > 5
    drive_on(robot, next_process)
    assert len(next_process.poses) == 10
    assert next_process.error() < 0.05
    assert len(again.slam.graph) > nodes
    again.memory.settle()
    assert file.is_file()


def test_a_process_that_dies_before_its_first_scan_leaves_the_map_to_the_next(
    killed: SlamToolboxNode, file: Path, next_process: Robot
) -> None:
    before = file.read_bytes()
    started(next_process, resume_file=str(file))
    next_process.bench.advance(6.0)
    assert file.read_bytes() == before


def test_a_damaged_file_is_refused_with_an_error_and_a_new_map_begins(
    robot: Robot,
    killed: SlamToolboxNode,
    file: Path,
    next_process: Robot,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    errors: list[str] = []
    monkeypatch.setattr(RcutilsLogger, "error", lambda self, text: errors.append(text))
    file.write_bytes(file.read_bytes()[:-100])
    again = started(next_process, resume_file=str(file))
    assert len(errors) == 1
    assert "a new map begins" in errors[0]
    assert "cut short" in errors[0]
    assert len(again.slam.graph) == 0
    drive_on(robot, next_process, 3)
    assert len(next_process.poses) == 3


def test_a_clock_that_was_set_back_meanwhile_begins_a_new_map(
    killed: SlamToolboxNode, file: Path, next_process: Robot
) -> None:
    again = started(next_process, resume_file=str(file))
    assert len(again.slam.graph) > 5
    next_process.drive(1)
    assert len(again.slam.graph) == 1
    assert not file.exists()


@pytest.mark.parametrize("how", ["reset", "deactivated", "another map"])
def test_what_is_given_up_is_not_gone_on_with(
    robot: Robot, killed: SlamToolboxNode, file: Path, how: str
) -> None:
    assert file.is_file()
    if how == "reset":
        robot.call(Reset, "reset")
    if how == "deactivated":
        killed.trigger_deactivate()
    if how == "another map":
        robot.call(SerializePoseGraph, "serialize_map", filename="room")
        robot.call(DeserializePoseGraph, "deserialize_map", filename="room", match_type=1)
    assert not file.exists()


def test_a_map_is_kept_only_where_that_is_asked_for(robot: Robot, tmp_path: Path) -> None:
    node = started(robot, maps_folder=str(tmp_path))
    robot.drive(55)
    node.memory.settle()
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_takes_nothing_does_not_end_the_mapping(robot: Robot, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    node = started(robot, resume_file=str(tmp_path / "file/slam_toolbox"))
    robot.drive(70)
    node.memory.settle()
    assert robot.error() < 0.03
