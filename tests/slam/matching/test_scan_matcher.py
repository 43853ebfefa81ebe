from __future__ import annotations

import dataclasses
import math
from collections.abc import Generator

import numpy as np
import pytest

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.mapping.submap import Submap
from arjuna_slam.matching.correlative import Window, search, searching
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatcherConfig, MatchStatus, ScanMatcher
from arjuna_slam.matching.surface import extract
from tests.slam.slam_room import box, room, scan_at

MATCHER = ScanMatcher(MatcherConfig())
CENTRE = SE2(5.0, 5.0, 0.3)
WINDOW = Window(0.5, 0.35, 3)


def reference(scan: Scan) -> Field:
    submap = Submap(Field(0.05, 0.05))
    submap.insert(0, extract(scan, 20.0), SE2())
    return submap.field


def match(scan: Scan, field: Field) -> Match:
    return MATCHER.match(field, extract(scan, 20.0), SE2(), WINDOW, 0.3)


@pytest.mark.parametrize(
    ("x", "y", "degrees"), [(0.0, 0.0, 0.0), (0.12, -0.31, 8.0), (-0.44, 0.05, -17.0)]
)
def test_a_known_offset_is_found_within_2_mm_and_a_tenth_of_a_degree(
    x: float, y: float, degrees: float
) -> None:
    offset = SE2(x, y, math.radians(degrees))
    field = reference(scan_at(room(), CENTRE))
    found = match(scan_at(room(), CENTRE @ offset), field)
    assert found.status is MatchStatus.MATCHED
    assert offset.distance(found.T_field_base) < 0.002
    assert abs(found.T_field_base.theta - offset.theta) < math.radians(0.1)


@pytest.mark.parametrize(
    ("beams", "view", "clockwise"),
    [(181, math.pi, False), (720, 1.5 * math.pi, True), (97, 2.0 * math.pi, True)],
)
def test_beam_count_direction_and_view_are_free(beams: int, view: float, clockwise: bool) -> None:
    mount = SE2(0.2, -0.1, 2.8)
    offset = SE2(0.1, 0.2, -0.1)
    field = reference(scan_at(room(), CENTRE))
    scan = scan_at(
        room(), CENTRE @ offset, beams=beams, field_of_view=view, clockwise=clockwise,
        T_base_sensor=mount,
    )  # fmt: skip
    found = match(scan, field)
    assert offset.distance(found.T_field_base) < 0.01
    assert abs(found.T_field_base.theta - offset.theta) < math.radians(0.2)


def test_branch_and_bound_finds_what_exhaustive_search_finds() -> None:
    field = reference(scan_at(room(), CENTRE))
    points = extract(scan_at(room(), CENTRE @ SE2(0.21, -0.13, 0.05)), 20.0).points
    deep = search(field, points, SE2(), Window(0.4, 0.1, 4), 0.0)
    flat = search(field, points, SE2(), Window(0.4, 0.1, 0), 0.0)
    assert deep is not None
    assert flat is not None
    assert deep[1] == pytest.approx(flat[1], abs=1e-12)


def test_a_search_in_steps_finds_what_one_at_once_finds() -> None:
    field = reference(scan_at(room(), CENTRE))
    points = extract(scan_at(room(), CENTRE @ SE2(0.21, -0.13, 0.05)), 20.0).points
    at_once = search(field, points, SE2(), Window(0.4, 0.1, 2), 0.0)
    found: list[tuple[SE2, float] | None] = []

    def in_steps() -> Generator[None, None, None]:
        found.append(
            (yield from searching(field, points, SE2(), Window(0.4, 0.1, 2), 0.0, work=20))
        )

    assert len(list(in_steps())) > 3
    assert found == [at_once]


@pytest.mark.parametrize("heading", [0.0, 0.5, -0.5, 1.5, 2.2])
def test_covariance_is_larger_along_a_corridor_than_across(heading: float) -> None:
    corridor, pose = box(-40.0, -1.0, 40.0, 1.0), SE2(0.0, 0.0, heading)
    field = reference(scan_at(corridor, pose))
    found = MATCHER.track(field, extract(scan_at(corridor, pose), 20.0), SE2(0.02, 0.02, 0.0))
    assert found.status is MatchStatus.MATCHED
    covariance = found.covariance_in(pose)
    assert covariance[0, 0] > 100.0 * covariance[1, 1]


def test_covariance_covers_the_actual_error() -> None:
    """The mean normalised error squared of 3 values is about 3; far above is overconfident."""
    rng = np.random.default_rng(3)
    field = reference(scan_at(room(), CENTRE, sigma=0.01, rng=rng))
    total = 0.0
    for _ in range(30):
        scan = extract(scan_at(room(), CENTRE, sigma=0.01, rng=rng), 20.0)
        found = MATCHER.track(field, scan, SE2(0.03, -0.02, 0.01))
        error = found.T_field_base.array()
        total += float(error @ found.information @ error)
    assert total / 30.0 < 6.0


def test_an_empty_scan_and_a_foreign_place_say_so() -> None:
    field = reference(scan_at(room(), CENTRE))
    scan = scan_at(room(), CENTRE)
    blind = Scan(np.full(360, np.inf), 0.0, scan.angle_increment, 0.1, 30.0)
    assert match(blind, field).status is MatchStatus.TOO_FEW_POINTS
    elsewhere = match(scan_at(box(-1.0, -0.7, 0.9, 1.1), SE2()), field)
    assert elsewhere.status is MatchStatus.LOW_RESPONSE


def test_normals_are_unit_face_the_sensor_and_lie_across_walls() -> None:
    surface = extract(scan_at(box(-2.0, -2.0, 2.0, 2.0), SE2()), 20.0)
    length = np.hypot(*surface.normals.T)
    assert ((np.abs(length - 1.0) < 1e-9) | (length == 0.0)).all()
    assert (length > 0.0).mean() > 0.85
    assert ((surface.normals * surface.points).sum(axis=1) <= 0.0).all()
    right = (surface.points[:, 0] > 1.99) & (np.abs(surface.points[:, 1]) < 1.5)
    assert np.abs(surface.normals[right] - (-1.0, 0.0)).max() < 1e-6


@pytest.mark.parametrize("clockwise", [False, True])
def test_a_scan_taken_while_turning_is_straightened_by_its_motion(clockwise: bool) -> None:
    motion = SE2(0.1, 0.0, 0.2)  # in one sweep: 1 m/s and 2 rad/s at 10 Hz
    exact = scan_at(room(), CENTRE, beams=360, clockwise=clockwise)
    swept = dataclasses.replace(exact, ranges=np.empty(360))
    for k in range(360):
        pose = CENTRE @ SE2.exp(motion.log() * k / 359)
        swept.ranges[k] = scan_at(room(), pose, beams=360, clockwise=clockwise).ranges[k]
    field = reference(exact)
    bent = match(swept, field)
    straight = match(dataclasses.replace(swept, motion=motion), field)
    assert bent.T_field_base.distance(SE2()) > 0.02
    assert straight.T_field_base.distance(SE2()) < 0.002
    assert abs(straight.T_field_base.theta) < math.radians(0.1)
