"""Claims: a still shows map, robot and scan where they were, in agreement."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.errors import InputFileError
from arjuna_core.se2 import SE2
from bringup.viewing.pictures import draw_still
from bringup.viewing.still import still_of
from tests.bringup.viewing.drives import WALL, Drive, drive, make, png_size


def test_the_robot_stands_where_it_was_and_its_scan_meets_the_wall(tmp_path: Path) -> None:
    still = still_of(drive(tmp_path / "bag"))
    assert still.robot is not None
    assert still.robot.distance(SE2(0.95, 0.0, 0.0)) == pytest.approx(0.0, abs=1e-6)
    assert still.scan[0] == pytest.approx([WALL, 0.0], abs=1e-6)
    assert still.grid is not None
    row, column = still.grid.frame.to_cell(*still.scan[0])
    assert still.grid.data[row, column] == 100
    assert still.believed[0] == pytest.approx((0.0, 0.0))
    assert still.true[0] == pytest.approx((0.02, 0.0))
    assert still.goals == [SE2(1.0, 0.0, 0.0)]
    assert len(still.plan) == 3


def test_a_moment_is_shown_as_it_was_then(tmp_path: Path) -> None:
    still = still_of(drive(tmp_path / "bag"), 1.0)
    assert still.robot is not None
    assert still.robot.x == pytest.approx(0.5)
    assert len(still.plan) == 0


def test_the_picture_is_written_with_and_without_a_map(tmp_path: Path) -> None:
    still = still_of(drive(tmp_path / "bag"))
    draw_still(tmp_path / "with.png", still)
    still.grid = None
    draw_still(tmp_path / "without.png", still)
    assert png_size(tmp_path / "with.png") == (990, 990)
    assert png_size(tmp_path / "without.png") == (990, 990)


def test_a_recording_with_nothing_to_see_is_refused(tmp_path: Path) -> None:
    recording = Drive(tmp_path / "bag")
    recording.say(0.0, "/words", make("std_msgs/msg/String", data="hello"))
    with pytest.raises(InputFileError, match=r"neither map nor robot; its topics: /words"):
        still_of(recording.close())
