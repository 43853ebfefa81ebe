from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.errors import InputFileError
from arjuna_core.se2 import SE2
from arjuna_slam.logs.log import read_carmen
from arjuna_slam.offline import evaluate, map_log, read_relations, run
from arjuna_slam.slam import Slam
from tests.slam.slam_room import ranges_at, room


def line(ranges: Floats, odometry: SE2, stamp: float) -> str:
    values = " ".join(f"{r:.3f}" for r in ranges)
    pose = f"{odometry.x} {odometry.y} {odometry.theta}"
    return f"FLASER {len(ranges)} {values} {pose} {pose} {stamp} host {stamp}\n"


def text() -> list[str]:
    angles = np.radians(np.arange(180) - 90.0)
    lines = ["# a comment\n", "ODOM 0 0 0 0 0 0 1.0 host 1.0\n"]
    for k in range(20):
        pose = SE2(3.0 + 0.1 * k, 5.0, 0.0)
        stamp = 100.0 + k if k != 5 else 103.5  # logged late
        lines.append(line(ranges_at(room(), pose, angles), pose, stamp))
    return lines


def test_a_replayed_log_meets_its_relations_and_a_stamp_that_steps_back_is_used() -> None:
    trajectory = run(Slam(), read_carmen(text()))
    assert len(trajectory) == 20
    relations = np.array([(100.0, 110.0, 1.0, 0, 0, 0, 0, 0), (104.0, 119.0, 1.5, 0, 0, 0, 0, 0)])
    result = evaluate(trajectory, relations)
    assert result.count == 2
    assert result.translation[0] < 0.01
    assert result.rotation[0] < 0.003


# 20 scans, each second and 0.1 m, one of them stamped 1.5 s before the one ahead of it
@pytest.mark.parametrize(
    ("values", "count"),
    [
        ({"minimum_time_interval": 0.0}, 20),
        ({"minimum_time_interval": 0.0, "throttle_scans": 3}, 7),
        ({"minimum_time_interval": 0.0, "process_between_keyframes": False}, 4),
        ({"minimum_time_interval": 2.0}, 11),
    ],
)
def test_a_log_is_mapped_at_the_pace_of_the_parameters(
    values: dict[str, object], count: int, tmp_path: Path
) -> None:
    file = tmp_path / "drive.clf"
    file.write_text("".join(text()), encoding="utf-8")
    assert len(map_log(file, values).trajectory) == count


def test_relations_are_read_from_a_file_of_eight_columns(tmp_path: Path) -> None:
    path = tmp_path / "a.relations"
    path.write_text("# t1 t2 x y z roll pitch yaw\n1 2 0.5 -0.1 0 0 0 0.3\n", encoding="utf-8")
    assert read_relations(path).tolist() == [[1.0, 2.0, 0.5, -0.1, 0.0, 0.0, 0.0, 0.3]]
    for text, problem in (("1 2 3\n", "has 3 columns"), ("a b\n", "cannot be read as relations")):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputFileError, match=problem):
            read_relations(path)


def test_relation_errors_are_those_of_the_metric() -> None:
    trajectory = [(0.0, SE2(0.0, 0.0, math.pi / 2)), (2.0, SE2(0.0, 2.0, math.pi / 2))]
    relations = np.array([(0.0, 1.0, 1.0, 0.1, 0, 0, 0, 0.2), (0.0, 9.0, 0, 0, 0, 0, 0, 0)])
    result = evaluate(trajectory, relations)
    assert result.count == 1
    assert result.translation[0] == pytest.approx(0.1)
    assert result.rotation[0] == pytest.approx(0.2)
    both = evaluate(trajectory, np.vstack((relations[:1], [(0.0, 2.0, 2.0, 0, 0, 0, 0, 0)])))
    assert both.translation == pytest.approx((0.05, 0.05))
    assert both.rotation == pytest.approx((0.1, 0.1))


def test_no_relation_in_time_is_an_error() -> None:
    with pytest.raises(ValueError, match=r"no relation within 0\.000"):
        evaluate([(0.0, SE2()), (1.0, SE2())], np.array([(5.0, 6.0, 0, 0, 0, 0, 0, 0)]))
