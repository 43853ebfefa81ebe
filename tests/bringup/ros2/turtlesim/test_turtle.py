"""Turtles move and draw as turtlesim's do."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bringup.ros2.turtlesim.turtle import PIXELS, SIDE, Pen, Sheet, Turtle
from bringup.ros2.turtlesim.window import outline_of

BLUE = (69, 86, 255)
PERIOD = 0.016  # [s]


@pytest.fixture
def sheet() -> Sheet:
    return Sheet(BLUE)


def advanced(turtle: Turtle, sheet: Sheet, duration: float) -> list[bool]:
    """Move a turtle for a time [s] from 0 on; return whether it hit the wall in each period."""
    return [
        turtle.advance(PERIOD, step * PERIOD, sheet) for step in range(round(duration / PERIOD))
    ]


@pytest.mark.parametrize(
    ("velocity", "expected"),
    [
        ((1.0, 0.0, 0.0), (6.0, 5.0, 0.0)),
        ((0.0, 1.0, 0.0), (5.0, 6.0, 0.0)),
        ((math.pi, 0.0, math.pi), (5.0, 7.0, math.pi)),
    ],
)
def test_a_command_lasts_a_second(
    velocity: tuple[float, float, float], expected: tuple[float, float, float], sheet: Sheet
) -> None:
    turtle = Turtle(5.0, 5.0, 0.0)
    turtle.command(*velocity, now=0.0)
    assert not any(advanced(turtle, sheet, 3.0))
    assert (turtle.x, turtle.y) == pytest.approx(expected[:2], abs=0.1)
    assert math.cos(turtle.theta - expected[2]) == pytest.approx(1.0, abs=0.01)
    assert turtle.velocity == (0.0, 0.0, 0.0)


def test_the_wall_holds_a_turtle(sheet: Sheet) -> None:
    turtle = Turtle(0.5, 5.0, math.pi)
    turtle.command(1.0, 0.0, 0.0, now=0.0)
    hits = advanced(turtle, sheet, 1.0)
    assert not hits[10]
    assert hits[-1]
    assert turtle.x == 0.0


@pytest.mark.parametrize(("goal", "duration"), [(1.0, 1.0), (-3.0, 3.0), (4.0, 2.29)])
def test_a_turtle_turns_the_shorter_way_to_a_heading(
    goal: float, duration: float, sheet: Sheet
) -> None:
    turtle = Turtle(5.0, 5.0, 0.0)
    turtle.goal = goal
    advanced(turtle, sheet, duration - 0.1)
    assert turtle.goal == goal
    turtle = Turtle(5.0, 5.0, 0.0)
    turtle.goal = goal
    advanced(turtle, sheet, duration + 0.1)
    assert turtle.goal is None
    assert math.cos(turtle.theta - goal) > math.cos(0.02)
    assert (turtle.x, turtle.y) == (5.0, 5.0)


def test_a_pen_draws_where_it_is_down(sheet: Sheet) -> None:
    turtle = Turtle(1.0, 1.0, 0.0, Pen((255, 0, 0), 5))
    turtle.teleport(3.0, 1.0, 0.0, sheet)
    assert sheet.color_at(2.0, 1.0) == (255, 0, 0)
    assert sheet.color_at(2.0, 1.2) == BLUE
    assert (sheet.pixels[:, 90] == (255, 0, 0)).all(axis=1).sum() == 5
    turtle.pen.is_down = False
    turtle.teleport_ahead(1.0, math.pi / 2.0, sheet)
    assert (turtle.x, turtle.y, turtle.theta) == pytest.approx((3.0, 2.0, math.pi / 2.0))
    assert sheet.color_at(3.0, 1.5) == BLUE
    sheet.clear((0, 0, 0))
    assert not sheet.pixels.any()


@pytest.mark.parametrize("corner", [(0.0, 0.0), (SIDE, SIDE), (0.0, SIDE), (SIDE, 0.0)])
def test_corners_are_on_the_sheet(corner: tuple[float, float], sheet: Sheet) -> None:
    sheet.draw((SIDE / 2.0, SIDE / 2.0), corner, Pen((9, 9, 9), 8))
    assert sheet.color_at(*corner) == (9, 9, 9)


def test_a_turtle_s_outline_points_ahead() -> None:
    outline = np.reshape(outline_of(Turtle(SIDE / 2.0, SIDE / 2.0, math.pi / 2.0)), (-1, 2))
    middle = (PIXELS - 1) / 2.0
    assert outline[0] == pytest.approx((middle, middle - 18.0))
    assert (outline[1:, 1] > middle).all()
