"""Claims: viser's events become points of the ground and poses, while a tool is in hand."""

from __future__ import annotations

import asyncio
import math
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("viser", reason="no viewer here")

import viser

from arjuna_core.se2 import SE2
from bringup.viewing.browser.pointer import Point2, Pointer, dragged_pose, on_ground


@pytest.fixture
def pointed() -> list[tuple[Point2, Point2]]:
    return []


@pytest.fixture
def pointer(server: viser.ViserServer, pointed: list[tuple[Point2, Point2]]) -> Pointer:
    return Pointer(server, lambda start, end: pointed.append((start, end)))


def drag(phase: str, end: tuple[float, float, float]) -> Any:
    camera = SimpleNamespace(position=(0.0, 0.0, 4.0))
    client = SimpleNamespace(camera=camera)
    return SimpleNamespace(
        phase=phase, client=client, start_position=(1.0, 1.0, 0.0), end_position=end
    )


def test_a_drag_counts_when_it_ends(pointer: Pointer, pointed: list[tuple[Point2, Point2]]) -> None:
    for phase in ("start", "update", "end"):
        asyncio.run(pointer.on_drag(drag(phase, (1.0, 0.0, 2.0))))
    assert pointed == [((1.0, 1.0), (2.0, 0.0))]


def test_a_drag_into_the_sky_is_dropped(
    pointer: Pointer, pointed: list[tuple[Point2, Point2]]
) -> None:
    asyncio.run(pointer.on_drag(drag("end", (1.0, 0.0, 5.0))))
    assert pointed == []


def test_a_click_is_where_its_ray_meets_the_ground(
    pointer: Pointer, pointed: list[tuple[Point2, Point2]]
) -> None:
    ray = SimpleNamespace(ray_origin=(0.0, 0.0, 2.0), ray_direction=(0.5, 0.0, -0.5))
    asyncio.run(pointer.on_click(ray))
    assert pointed == [((2.0, 0.0), (2.0, 0.0))]


def test_the_ground_takes_the_mouse_only_while_a_tool_is_in_hand(pointer: Pointer) -> None:
    ground: Any = pointer._ground
    for held in (True, True, False):
        pointer.hold(held)
        assert bool(ground._impl.drag_cb) is held
        assert bool(ground._impl.click_cb) is held
    pointer.hold(True)
    pointer.hold(True)
    assert len(ground._impl.drag_cb) == 1


def test_a_line_of_sight_meets_the_ground_beyond_or_before_the_point_it_goes_through() -> None:
    assert on_ground((0.0, 0.0, 4.0), (1.0, 1.0, 2.0)) == pytest.approx((2.0, 2.0))
    assert on_ground((0.0, 0.0, 4.0), (3.0, 0.0, -2.0)) == pytest.approx((2.0, 0.0))


@pytest.mark.parametrize("through", [(1.0, 0.0, 4.0), (1.0, 0.0, 5.0)])
def test_a_look_at_the_sky_meets_no_ground(through: tuple[float, float, float]) -> None:
    assert on_ground((0.0, 0.0, 4.0), through) is None


def test_from_below_the_ground_nothing_is_met() -> None:
    assert on_ground((0.0, 0.0, -1.0), (0.0, 0.0, -2.0)) is None


def test_a_drag_heads_for_where_it_ended() -> None:
    assert dragged_pose((1.0, 1.0), (1.0, 3.0), SE2()) == SE2(1.0, 1.0, math.pi / 2)


def test_a_click_heads_away_from_the_robot() -> None:
    assert dragged_pose((0.0, 1.0), (0.0, 1.05), SE2(1.0, 1.0, 2.0)) == SE2(0.0, 1.0, math.pi)
    assert dragged_pose((0.0, 1.0), (0.0, 1.05), None) == SE2(0.0, 1.0, 0.0)
