from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.matching.contradiction import longest, seen_and_contradicted
from tests.slam.slam_room import box, scan_at

SHORT, LONG = box(0.0, 0.0, 6.0, 2.0), box(0.0, 0.0, 12.0, 2.0)
END = np.array([(6.0, y) for y in np.linspace(0.2, 1.8, 17)])
VIEWS = [SE2(1.0, 1.0, 0.3), SE2(3.0, 1.2, 2.0)]


def counts(points: Floats, scans: list[tuple[Scan, SE2]]) -> tuple[int, int]:
    """Return the numbers of points seen and contradicted."""
    seen, against = seen_and_contradicted(points, scans, 20.0)
    return int(seen.sum()), int(against.sum())


def test_beams_go_through_an_end_that_is_not_there() -> None:
    scans = [(scan_at(LONG, pose), pose) for pose in VIEWS]
    assert counts(END, scans) == (17, 17)


def test_an_end_that_is_there_is_seen() -> None:
    scans = [(scan_at(SHORT, pose, clockwise=True), pose) for pose in VIEWS]
    assert counts(END, scans) == (17, 0)


def test_what_lies_behind_a_wall_says_nothing() -> None:
    scans = [(scan_at(SHORT, pose), pose) for pose in VIEWS]
    assert counts(END + np.array([3.0, 0.0]), scans) == (0, 0)


def test_what_is_out_of_view_says_nothing() -> None:
    scans = [
        (scan_at(LONG, pose, field_of_view=math.pi), pose) for pose in (SE2(1.0, 1.0, math.pi),)
    ]
    assert counts(END, scans) == (0, 0)


def test_the_longest_thing_is_one_without_gaps() -> None:
    near = np.array([(0.0, y) for y in np.linspace(0.0, 0.6, 13)])
    assert longest(np.concatenate((END, near))) == pytest.approx(1.6)
    assert longest(np.concatenate((near, near + np.array([0.0, 1.0])))) == pytest.approx(0.6)
    assert longest(np.zeros((0, 2))) == 0.0


def test_one_beam_is_enough_and_seven_of_ten_must_speak_against() -> None:
    true, false = (scan_at(SHORT, VIEWS[0]), VIEWS[0]), (scan_at(LONG, VIEWS[0]), VIEWS[0])
    assert counts(END[:1], [false]) == (1, 1)
    assert counts(END[:1], [true]) == (1, 0)
    assert counts(END, [false] * 3 + [true]) == (17, 17)
    assert counts(END, [false] * 2 + [true]) == (17, 0)
    assert counts(END, []) == (0, 0)
