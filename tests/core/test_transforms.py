"""A tree of frames over time: found along its branches, between its stamps, never beyond them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_core.transforms import TransformBuffer, TransformError

MAP_ODOM, ODOM_BASE, BASE_LIDAR = SE2(1.0, 2.0, 0.5), SE2(3.0, -1.0, 1.0), SE2(0.2, 0.1, -0.3)


def robot(stamp: float = 1.0) -> TransformBuffer:
    """Return a buffer with map, odom, base, lidar and, beside it, camera."""
    buffer = TransformBuffer()
    buffer.insert("map", "odom", stamp, MAP_ODOM)
    buffer.insert("odom", "base", stamp, ODOM_BASE)
    buffer.insert("base", "lidar", 0.0, BASE_LIDAR, static=True)
    buffer.insert("base", "camera", 0.0, SE2(0.3, 0.0), static=True)
    return buffer


@pytest.mark.parametrize(
    ("target", "source", "expected"),
    [
        ("map", "lidar", MAP_ODOM @ ODOM_BASE @ BASE_LIDAR),
        ("lidar", "map", (MAP_ODOM @ ODOM_BASE @ BASE_LIDAR).inverse()),
        ("lidar", "camera", BASE_LIDAR.inverse() @ SE2(0.3, 0.0)),
        ("base", "base", SE2()),
        ("odom", "base", ODOM_BASE),
    ],
)
@pytest.mark.parametrize("stamp", [None, 1.0])
def test_a_frame_is_found_in_another_along_the_branches(
    target: str, source: str, expected: SE2, stamp: float | None
) -> None:
    np.testing.assert_allclose(robot().lookup(target, source, stamp).array(), expected.array())


def test_between_two_stamps_it_interpolates_and_beyond_it_says_by_how_much() -> None:
    buffer = robot()
    buffer.insert("odom", "base", 2.0, SE2(4.0, -1.0, 1.0))
    buffer.insert("odom", "base", 1.5, SE2(3.1, -1.0, 1.0))  # late: it takes its place
    assert buffer.lookup("odom", "base", 1.75).x == pytest.approx(3.55)
    assert buffer.lookup("odom", "base", 1.5).x == 3.1
    assert buffer.lookup("odom", "base").x == 4.0
    with pytest.raises(TransformError, match=r"its newest is at 2.000 s \(0.500 s off\)"):
        buffer.lookup("odom", "base", 2.5)
    with pytest.raises(TransformError, match=r"its oldest is at 1.000 s \(0.250 s off\)"):
        buffer.lookup("odom", "base", 0.75)
    assert buffer.try_lookup("odom", "base", 2.5) is None
    assert buffer.latest_common("map", "base") == 1.0  # map -> odom has not come since
    assert buffer.latest_common("lidar", "camera") == 0.0


def test_a_stamp_that_comes_again_replaces_and_old_ones_go() -> None:
    buffer = robot(0.0)
    buffer.insert("odom", "base", 0.0, SE2(9.0))
    assert buffer.lookup("odom", "base", 0.0) == SE2(9.0)
    for second in range(1, 31):
        buffer.insert("odom", "base", float(second), SE2(float(second)))
    assert buffer.lookup("odom", "base", 0.5) == SE2(5.0)
    buffer.insert("odom", "base", 31.0, SE2(31.0))
    assert buffer.lookup("odom", "base", 1.0) == SE2(1.0)
    assert buffer.try_lookup("odom", "base", 0.5) is None


@pytest.mark.parametrize(("back", "forgets"), [(0.9, False), (1.1, True)])
def test_time_that_jumps_back_is_another_run(back: float, forgets: bool) -> None:
    buffer = robot(100.0)
    buffer.insert("odom", "base", 100.0 - back, SE2(7.0))
    assert (buffer.try_lookup("map", "odom") is None) is forgets
    assert (buffer.lookup("odom", "base") == SE2(7.0)) is forgets
    assert buffer.lookup("base", "lidar").distance(BASE_LIDAR) < 1e-9


def test_a_frame_with_another_parent_forgets_the_old_one() -> None:
    buffer = robot()
    buffer.insert("map", "base", 2.0, SE2(5.0))
    assert buffer.lookup("map", "base") == SE2(5.0)
    assert buffer.latest_common("odom", "base") == 1.0


def test_frames_that_nothing_connects_are_named_with_those_there_are() -> None:
    with pytest.raises(TransformError, match="'map' and 'moon'; known frames: base, camera, lidar"):
        robot().lookup("map", "moon")
    with pytest.raises(TransformError, match="known frames: none"):
        TransformBuffer().lookup("map", "moon")
    buffer = TransformBuffer()
    buffer.insert("a", "b", 0.0, SE2())
    buffer.insert("b", "a", 0.0, SE2())
    with pytest.raises(TransformError, match="frames form a loop: b -> a -> b"):
        buffer.lookup("b", "c")


@pytest.mark.parametrize(
    ("flips", "upside_down"), [((), False), (("lidar",), True), (("base", "lidar"), False)]
)
def test_two_turns_upside_down_are_upright(flips: tuple[str, ...], upside_down: bool) -> None:
    buffer = TransformBuffer()
    for parent, child in (("odom", "base"), ("base", "lidar")):
        mount = Pose3.from_rpy((0.0, 0.0, 0.0), (math.pi, 0.0, 0.0)) if child in flips else None
        buffer.insert(parent, child, 1.0, SE2(), mount=mount)
    assert buffer.upside_down("odom", "lidar") is upside_down
    assert buffer.upside_down("lidar", "odom") is upside_down


def test_a_mount_is_found_in_space() -> None:
    buffer = robot()
    tilted = Pose3.from_rpy((0.1, 0.0, 0.4), (0.0, 0.5, 0.0))
    buffer.insert("lidar", "imu", 0.0, SE2(0.1), static=True, mount=tilted)
    expected = Pose3.from_se2(BASE_LIDAR) @ tilted
    for found, pose in (
        (buffer.mount("base", "imu"), expected),
        (buffer.mount("imu", "base"), expected.inverse()),
    ):
        np.testing.assert_allclose(found.position, pose.position, atol=1e-12)
        np.testing.assert_allclose(found.rotation(), pose.rotation(), atol=1e-12)


def test_the_rigid_root_is_above_all_static_transforms() -> None:
    buffer = robot()
    buffer.insert("lidar", "imu", 0.0, SE2(0.1), static=True)
    assert [buffer.rigid_root(f) for f in ("imu", "base", "odom", "none")] == [
        *("base", "base", "odom", "none")
    ]


def test_the_base_is_what_moves_and_carries_something() -> None:
    buffer = robot()
    assert buffer.base_below("odom") == buffer.base_below("map") == "base"
    assert buffer.base_below("base") is None
    assert buffer.missing_base("base_frame", "base", "odom") == ""
    buffer.insert("odom", "person", 1.0, SE2())
    assert buffer.base_below("odom") == "base"
    problem = buffer.missing_base("base_frame", "base_footprint", "odom")
    assert "base_frame is 'base_footprint', a frame that does not exist" in problem
    assert "set base_frame: base, or start it with --base-frame base" in problem
    empty = TransformBuffer().missing_base("base_frame", "base", "odom")
    assert "nothing moves in 'odom' either" in empty


def test_a_turn_is_interpolated_along_the_shorter_arc() -> None:
    buffer = TransformBuffer()
    buffer.insert("odom", "base", 0.0, SE2(0.0, 0.0, 3.0))
    buffer.insert("odom", "base", 1.0, SE2(0.0, 0.0, -3.0))
    assert abs(buffer.lookup("odom", "base", 0.5).theta) == pytest.approx(math.pi)


FRAMES = ["map", "odom", "base", "lidar", "camera", "other"]


def receive(
    buffer: TransformBuffer, parent: str, child: str, now: float, static: bool = False
) -> str:
    """Insert as a listener does, and return why it does not."""
    return receive_late(buffer, parent, child, now, now, static)


def receive_late(
    buffer: TransformBuffer, parent: str, child: str, stamp: float, now: float, static: bool = False
) -> str:
    """Insert a transform of another time, as `receive`."""
    refusal = buffer.admit(parent, child, stamp, static, now)
    if not refusal:
        buffer.insert(parent, child, stamp, SE2(1.0), static, received=now)
    return refusal


@pytest.mark.parametrize("seed", range(40))
def test_what_contradicts_living_frames_is_refused_whatever_comes(seed: int) -> None:
    rng, buffer = np.random.default_rng(seed), TransformBuffer()
    for tick in range(20):
        now = 0.1 * tick
        if tick == 0:
            assert not receive(buffer, "base", "lidar", now, static=True)
        for parent, child in (("map", "odom"), ("odom", "base")):
            assert not receive(buffer, parent, child, now)
        parent, child = rng.choice(FRAMES, 2)
        refusal = receive(buffer, parent, child, now, static=bool(rng.integers(2)))
        true = {("map", "odom"), ("odom", "base"), ("base", "lidar")}
        if refusal:
            assert parent in refusal
            assert child in refusal
        elif (parent, child) not in true:
            assert child in ("camera", "other", "map")
        assert buffer.lookup("map", "lidar").x == pytest.approx(3.0)


def test_a_frame_that_is_silent_gets_another_parent_and_makes_room_for_a_loop() -> None:
    buffer = TransformBuffer()
    assert not receive(buffer, "map", "odom", 0.0)
    assert "'odom' has the parent 'map', so not 'other' too" in receive(
        buffer, "other", "odom", 5.0
    )
    assert "form a loop: map -> odom -> map" in receive(buffer, "odom", "map", 5.0)
    assert not receive(buffer, "other", "odom", 5.1)
    assert not receive(buffer, "odom", "other", 10.2)
    assert buffer.lookup("odom", "other") == SE2(1.0)


def test_a_static_transform_gives_way_to_one_that_goes_on_moving() -> None:
    buffer = TransformBuffer()
    assert not receive(buffer, "map", "odom", 0.0, static=True)
    assert "is static; one that moves replaces it if it goes on" in receive(
        buffer, "map", "odom", 1.0
    )
    assert "if it goes on" in receive(buffer, "map", "odom", 7.0), "a single one, long after"
    assert not receive(buffer, "map", "odom", 7.1)
    assert not receive(buffer, "map", "odom", 7.2)
    assert "one that moves, so not static" in receive(buffer, "map", "odom", 7.3, static=True)
    assert buffer.edges["odom"].stamps == [7.1, 7.2]


def test_of_another_run_even_static_frames_get_another_parent() -> None:
    buffer = TransformBuffer()
    receive(buffer, "base", "lidar", 50.0, static=True)
    assert receive(buffer, "mast", "lidar", 90.0, static=True)
    buffer.clear()
    assert not receive(buffer, "mast", "lidar", 0.0, static=True)


def test_a_stamp_of_another_time_is_refused_and_forgets_nothing() -> None:
    buffer = TransformBuffer()
    receive(buffer, "base", "lidar", 1.0, static=True)
    for stamp in (99.0, 99.5, 100.0):
        assert not receive(buffer, "odom", "base", stamp)
    assert "100.0 s ahead of the clock" in receive_late(buffer, "odom", "base", 200.0, 100.0)
    assert "50.0 s older than its newest" in receive_late(buffer, "odom", "base", 50.0, 100.0)
    assert not receive_late(buffer, "odom", "base", 99.2, 100.0), "late, as by another path"
    assert buffer.edges["base"].stamps == [99.0, 99.2, 99.5, 100.0]
    assert not receive_late(buffer, "odom", "base", 109.0, 100.0), "within what publishers allow"
    assert "59.0 s older" in receive_late(buffer, "odom", "base", 50.0, 100.0)
    assert not receive(buffer, "odom", "base", 100.1)
    assert buffer.edges["base"].stamps == [100.1], "what was ahead is gone"
    assert receive(buffer, "mast", "lidar", 100.1, static=True), "static frames keep their parents"


def test_a_clock_that_is_set_back_or_knows_nothing_of_the_stamps_refuses_none() -> None:
    buffer = TransformBuffer()
    for stamp, now in ((50.0, 0.0), (60.0, 60.0), (1.0, 1.0), (70.0, 1e9), (2.0, 1e9)):
        assert not receive_late(buffer, "odom", "base", stamp, now)
        assert buffer.edges["base"].stamps[-1] == stamp


def test_a_static_frame_that_is_set_or_moved_elsewhere_is_found_where_it_is_now() -> None:
    buffer = robot()
    assert buffer.lookup("odom", "lidar") == ODOM_BASE @ BASE_LIDAR
    assert buffer.mount("base", "lidar").planar().x == pytest.approx(BASE_LIDAR.x)
    buffer.insert("base", "lidar", 0.0, SE2(0.4), static=True)
    assert buffer.lookup("odom", "lidar").x == (ODOM_BASE @ SE2(0.4)).x
    assert buffer.mount("base", "lidar").position[0] == 0.4
    buffer.clear()
    buffer.insert("base", "lidar", 0.0, SE2(0.5), static=True)
    assert buffer.lookup("base", "lidar").x == 0.5
    with pytest.raises(TransformError, match="no transform connects 'odom' and 'lidar'"):
        buffer.lookup("odom", "lidar")
    buffer.insert("camera", "lidar", 0.0, SE2(0.5), static=True)
    assert buffer.lookup("base", "lidar").x == pytest.approx(0.8)
