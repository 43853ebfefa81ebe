"""Claims: a picture shows map, robot and scan where they were, in agreement."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from arjuna_core.errors import InputFileError
from arjuna_core.se2 import SE2
from bringup.viewing.pictures import draw_snapshot
from bringup.viewing.snapshot import snapshot_of
from tests.bringup.viewing.drives import WALL, Drive, drive, make, png_size


def test_the_robot_stands_where_it_was_and_its_scan_meets_the_wall(tmp_path: Path) -> None:
    snapshot = snapshot_of(drive(tmp_path / "bag"))
    assert snapshot.robot is not None
    assert snapshot.robot.distance(SE2(0.95, 0.0, 0.0)) == pytest.approx(0.0, abs=1e-6)
    assert snapshot.scan[0] == pytest.approx([WALL, 0.0], abs=1e-6)
    assert snapshot.grid is not None
    row, column = snapshot.grid.frame.to_cell(*snapshot.scan[0])
    assert snapshot.grid.data[row, column] == 100
    assert snapshot.believed[0] == pytest.approx((0.0, 0.0))
    assert snapshot.true[0] == pytest.approx((0.02, 0.0))
    assert snapshot.goals == [SE2(1.0, 0.0, 0.0)]
    assert len(snapshot.plan) == 3


def test_a_moment_is_shown_as_it_was_then(tmp_path: Path) -> None:
    snapshot = snapshot_of(drive(tmp_path / "bag"), 1.0)
    assert snapshot.robot is not None
    assert snapshot.robot.x == pytest.approx(0.5)
    assert len(snapshot.plan) == 0


def test_the_picture_is_written_with_and_without_a_map(tmp_path: Path) -> None:
    snapshot = snapshot_of(drive(tmp_path / "bag"))
    draw_snapshot(tmp_path / "with.png", snapshot)
    snapshot.grid = None
    draw_snapshot(tmp_path / "without.png", snapshot)
    assert png_size(tmp_path / "with.png") == (990, 990)
    assert png_size(tmp_path / "without.png") == (990, 990)
    snapshot.touches.append(SE2(0.5, 0.0))
    draw_snapshot(tmp_path / "touched.png", snapshot)
    assert (tmp_path / "touched.png").read_bytes() != (tmp_path / "without.png").read_bytes()
    snapshot.missed = frozenset({1})
    draw_snapshot(tmp_path / "missed.png", snapshot)
    assert (tmp_path / "missed.png").read_bytes() != (tmp_path / "touched.png").read_bytes()


def test_the_believed_path_is_seen_on_the_true_one(tmp_path: Path) -> None:
    snapshot = snapshot_of(drive(tmp_path / "bag"))
    snapshot.true = snapshot.believed
    snapshot.plan, snapshot.grid = np.empty((0, 2)), None
    draw_snapshot(tmp_path / "paths.png", snapshot)
    picture = Image.open(tmp_path / "paths.png").convert("RGB")
    red, green, blue = np.moveaxis(np.asarray(picture).astype(int), 2, 0)
    legend = 60  # pixels of a line there
    assert ((blue - red > 80) & (blue - green > 20)).sum() > 2 * legend, "the believed one"
    assert ((green - blue > 40) & (green - red > 40)).sum() > 2 * legend, "the true one"


def test_a_recording_with_nothing_to_see_is_refused(tmp_path: Path) -> None:
    recording = Drive(tmp_path / "bag")
    recording.say(0.0, "/words", make("std_msgs/msg/String", data="hello"))
    with pytest.raises(InputFileError, match=r"neither map nor robot; its topics: /words"):
        snapshot_of(recording.close())
