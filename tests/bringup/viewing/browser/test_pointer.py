"""Claims: what viser tells of the mouse becomes a place on the ground, while a tool is in hand."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("viser", reason="no viewer here")

import viser

from bringup.viewing.browser.pointer import Pointer
from bringup.viewing.drawing.wishes import Pointed, Tool, Wish


@pytest.fixture
def wished() -> list[Wish]:
    return []


@pytest.fixture
def pointer(server: viser.ViserServer, wished: list[Wish]) -> Pointer:
    return Pointer(server, wished.append)


def drag(phase: str, end: tuple[float, float, float]) -> Any:
    camera = SimpleNamespace(position=(0.0, 0.0, 4.0))
    client = SimpleNamespace(camera=camera)
    return SimpleNamespace(
        phase=phase, client=client, start_position=(1.0, 1.0, 0.0), end_position=end
    )


def test_a_drag_counts_when_it_ends(pointer: Pointer, wished: list[Wish]) -> None:
    for phase in ("start", "update", "end"):
        asyncio.run(pointer.on_drag(drag(phase, (1.0, 0.0, 2.0))))
    assert wished == [Pointed((1.0, 1.0), (2.0, 0.0))]


def test_a_drag_into_the_sky_is_dropped(pointer: Pointer, wished: list[Wish]) -> None:
    asyncio.run(pointer.on_drag(drag("end", (1.0, 0.0, 5.0))))
    assert wished == []


def test_a_click_is_where_its_ray_meets_the_ground(pointer: Pointer, wished: list[Wish]) -> None:
    ray = SimpleNamespace(ray_origin=(0.0, 0.0, 2.0), ray_direction=(0.5, 0.0, -0.5))
    asyncio.run(pointer.on_click(ray))
    assert wished == [Pointed((2.0, 0.0), (2.0, 0.0))]


def test_the_ground_takes_the_mouse_only_while_a_tool_is_in_hand(pointer: Pointer) -> None:
    ground: Any = pointer._ground
    for tool, held in ((Tool.GOAL, True), (Tool.POSE, True), (Tool.LOOK, False)):
        pointer.take(tool)
        assert bool(ground._impl.drag_cb) is held
        assert bool(ground._impl.click_cb) is held
    pointer.take(Tool.POINT)
    pointer.take(Tool.GOAL)
    assert len(ground._impl.drag_cb) == 1
