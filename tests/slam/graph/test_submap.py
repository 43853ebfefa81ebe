"""None"""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.graph.submap import LocalMap, PackedField, Submap, SubmapConfig
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.surface import Surface

WALL = np.column_stack((np.arange(0.0, 40.0, 0.05), np.full(800, 0.02)))
UP = np.tile((0.0, 1.0), (800, 1))


@pytest.mark.parametrize("walls", [1, 4, 16])
def test_a_field_unpacked_is_the_field(walls: int) -> None:
    field = Field(0.05, 0.05)
    for k in range(walls):
        field.add(WALL + np.array([0.0, float(k)]), UP)
        field.add(WALL[:20] * 0.3 + np.array([1.0, k + 0.5]), np.zeros((20, 2)))  # no surface
    field.trim()
    packed = PackedField.of(field)
    unpacked = packed.unpacked()
    assert np.array_equal(unpacked.score, field.score)
    assert np.array_equal(unpacked.origin, field.origin)
    assert np.array_equal(unpacked.planes[unpacked.index], field.planes[field.index])
    assert np.array_equal(unpacked.surface(), field.surface())


def test_a_field_at_rest_takes_the_room_of_its_walls_alone() -> None:
    field = Field(0.05, 0.05)
    for k in (0.0, 39.0):
        field.add(WALL + np.array([0.0, k]), UP)
    field.trim()
    packed = PackedField.of(field)
    kept = sum(each.nbytes for each in vars(packed).values() if isinstance(each, np.ndarray))
    assert kept < 0.2 * (field.score.nbytes + field.index.nbytes)


SEEN = Surface(np.array([[1.0, 0.0]]), np.array([[-1.0, 0.0]]), np.zeros(1, np.bool_))


def test_a_robot_that_drives_and_then_turns_stays_where_it_is() -> None:
    """Half full by length, then half full by count: three submaps are built at a time then."""
    local, at = LocalMap(SubmapConfig(submap_size=20, submap_length=10.0)), SE2()
    world: list[SE2] = []
    most = 0
    for node in range(60):
        step = SE2(0.0, 0.0, 0.4) if node % 20 > 6 else SE2(0.9, 0.0, 0.0)
        world.append((world[-1] if world else SE2(2.0, 1.0, 0.3)) @ step)
        if node:
            at = at @ (world[-2].inverse() @ world[-1])
        at = local.insert(node, SEEN, at)
        most = max(most, len(local.active))
        assert (world[local.reference.anchor] @ at).distance(world[-1]) < 1e-9
    assert most == 3
    assert all(submap.poses[0].distance(SE2()) < 1e-9 for submap in local.finished)


def test_only_the_fields_that_were_asked_for_last_stay_grids() -> None:
    local, at = LocalMap(SubmapConfig(submap_length=2.0)), SE2()
    for node in range(60):
        at = local.insert(node, SEEN, at @ SE2(0.9, 0.0, 0.0))
    assert len(local.finished) > 15
    first = local.finished[0].field
    assert local.finished[0].field is first
    assert all(len(submap.field.planes) > 1 for submap in local.finished)
    assert local.finished[0].field is not first
    assert np.array_equal(local.finished[0].field.score, first.score)


NONE = np.zeros((3, 3))


def uncertain(x: float, y: float = 0.0, heading: float = 0.0) -> Floats:
    return np.diag([x, y, heading])


def test_what_a_keyframe_saw_lies_where_it_was() -> None:
    submap = Submap(Field(0.05, 0.05))
    wall = np.column_stack((np.ones(41), np.linspace(-1.0, 1.0, 41)))
    seen = Surface(wall, np.tile([-1.0, 0.0], (41, 1)), np.ones(41, np.bool_))
    pose = SE2(3.0, -2.0, 0.7)
    submap.insert(5, seen, pose)
    points, normals = submap.field.surface()
    back = pose.inverse().apply(points)
    assert back[:, 0] == pytest.approx(1.0, abs=0.01)
    assert np.abs(back[:, 1]).max() == pytest.approx(1.0, abs=0.15)
    np.testing.assert_allclose(
        normals, np.tile((-math.cos(0.7), -math.sin(0.7)), (len(normals), 1)), atol=1e-5
    )


def test_a_new_keyframe_is_tied_to_one_at_most_four_metres_back() -> None:
    """And on what comes after a tear; what was not seen since then counts."""
    submap, travel = Submap(Field(0.05, 0.05)), 0.0
    steps = [0.0, 1.5, 1.5, 0.9, 0.2, 1.0, 1.0, 1.0, 0.5]
    posts = [0, 0, 0, 0, 4, 4, 4, 7, 7]  # at 4.1 m; torn at 7.1 m
    tears = {3: uncertain(0.02, 0.01), 6: uncertain(0.0, 0.05), 7: uncertain(0.3, 0.1, 0.02)}
    uncertainties = [NONE, NONE, NONE, tears[3], NONE, NONE, tears[6], NONE, NONE]
    for k, step in enumerate(steps):
        travel += step
        pose = SE2(travel, 0.0, math.pi / 2)  # looking aside
        submap.insert(10 + k, SEEN, pose, tears.get(k, NONE))
        assert submap.path_length == pytest.approx(travel)
        assert (submap.anchor, submap.nodes[-1], submap.poses[-1]) == (10, 10 + k, pose)
        post, T_post_base, unseen_since = submap.constraint_to(SE2(travel + 0.3, 0.1, 0.0))
        assert post == 10 + posts[k]
        back = travel - sum(steps[: posts[k] + 1])
        assert T_post_base.array() == pytest.approx((0.1, -0.3 - back, -math.pi / 2))
        x, y, heading = uncertainties[k].diagonal()
        np.testing.assert_allclose(
            unseen_since, np.diag([y, x, heading]), atol=1e-12
        )  # in its own axes
    np.testing.assert_allclose(submap.bend, tears[7])  # a heading that nothing has seen
    assert submap.nearest(SE2(1.6, 2.0, 0.0)) == (11, SE2(1.5, 0.0, math.pi / 2))


def test_a_tear_before_the_first_keyframe_bends_nothing() -> None:
    submap = Submap(Field(0.05, 0.05))
    for k, heading in enumerate((0.1, 0.2, 0.0, 0.3)):
        submap.insert(k, SEEN, SE2(0.1 * k, 0.0, 0.0), uncertain(0.01, 0.02, heading))
    np.testing.assert_allclose(submap.bend, uncertain(0.02, 0.04, 0.5))


@pytest.mark.parametrize(
    ("gone", "nodes", "post"),
    [
        ((), [0, 1, 2, 3, 4, 5, 6], 4),
        ((0, 1), [0, 1, 2, 3, 4], 4),
        ((4,), [0, 1, 2, 3, 4, 5], 3),  # the one before it
        ((3, 4, 5), [0, 1, 2, 3], 2),
        ((0, 1, 2, 3, 4), [0, 1], 5),  # none before it: the first
    ],
)
def test_lost_keyframes_are_followed(gone: tuple[int, ...], nodes: list[int], post: int) -> None:
    submap = Submap(Field(0.05, 0.05))
    for k in range(7):
        submap.insert(k, SEEN, SE2(float(k), 0.0, 0.0))
    assert submap.constraint_to(IDENTITY)[0] == 4
    keep = ~np.isin(np.arange(7), gone)
    index = np.where(keep, np.cumsum(keep) - 1, -1)
    submap.renumber(index)
    assert submap.nodes == nodes
    assert [pose.x for pose in submap.poses] == np.flatnonzero(keep).tolist()
    assert submap.constraint_to(IDENTITY)[0] == index[post]


@pytest.mark.parametrize(
    ("size", "length", "starts", "ends"),
    [
        (4, 1e4, [0, 2, 4, 6, 8], [3, 5, 7, 9]),  # by count
        (5, 1e4, [0, 2, 4, 6, 8], [4, 6, 8]),  # half of five is two
        (1000, 2.0, [0, 3, 6, 9], [4, 7]),  # by travel: nodes are half a metre apart
    ],
)
def test_a_submap_begins_when_the_newest_is_half_full_and_ends_when_it_is_full(
    size: int, length: float, starts: list[int], ends: list[int]
) -> None:
    local, at, heading = LocalMap(SubmapConfig(submap_size=size, submap_length=length)), SE2(), 0.0
    began, ended, world = [], [], [SE2(2.0, 1.0, 0.3)]
    for node in range(10):
        if node:
            heading += 0.1
            world.append(world[-1] @ SE2(0.5, 0.0, 0.1))
            at = at @ SE2(0.5, 0.0, 0.1)
        known, finished = {submap.anchor for submap in local.active}, len(local.finished)
        unseen = uncertain(0.04, 0.01, 0.001 * (node == 5))  # a tear at the sixth
        turn = SE2(0.0, 0.0, at.theta).matrix().T  # along the robot's own axes
        at = local.insert(node, SEEN, at, turn.T @ unseen @ turn)
        began += [submap.anchor for submap in local.active if submap.anchor not in known]
        ended += [node] * (len(local.finished) - finished)
        for submap, pose in local.poses(at):
            expected = world[submap.anchor].inverse() @ world[node]
            assert pose.array() == pytest.approx(expected.array(), abs=1e-9)
            if node == 5 and submap.anchor < 5:
                turn = SE2(0.0, 0.0, pose.theta).matrix()
                np.testing.assert_allclose(submap.bend, turn @ unseen @ turn.T, atol=1e-12)
    assert began == starts
    assert ended == ends


def test_finished_submaps_go_with_their_anchors() -> None:
    local, at = LocalMap(SubmapConfig(submap_size=4)), SE2()
    for node in range(10):
        at = local.insert(node, SEEN, at)
    assert [submap.nodes for submap in local.finished[:2]] == [[0, 1, 2, 3], [2, 3, 4, 5]]
    index = np.array([0, 1, -1, 2, 3, 4, 5, 6, 7, 8])
    local.renumber(index)
    assert [submap.anchor for submap in local.finished] == [0, 3, 5]
    assert local.finished[0].nodes == [0, 1, 2]
    assert [submap.nodes for submap in local.active] == [[7, 8]]
