"""Turtles on a sheet that they draw on; sizes, speeds and colors are turtlesim's 1.8, Jazzy's."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import wrap

PIXELS = 500
_METER = 45  # [px], the height of turtlesim's picture of a turtle
SIDE = (PIXELS - 1) / _METER
"""The sheet's width and height [m]."""
TURN_RATE = 1.0
"""How fast a turtle turns to a heading that it is told [rad/s]."""
_FACING = 0.02  # [rad]
_HOLDS = 1.0  # [s] for which a command lasts
Color = tuple[int, int, int]


@dataclass
class Pen:
    """The pen of a turtle."""

    color: Color = (179, 184, 255)
    width: int = 3
    is_down: bool = True


class Sheet:
    """The drawing.

    Attributes:
        pixels: `(500, 500, 3)` uint8, the top row first.
    """

    def __init__(self, background: Color) -> None:
        self.pixels: NDArray[np.uint8] = np.empty((PIXELS, PIXELS, 3), np.uint8)
        self.clear(background)

    def clear(self, background: Color) -> None:
        """Wipe the sheet."""
        self.pixels[:] = background

    def draw(self, start: tuple[float, float], end: tuple[float, float], pen: Pen) -> None:
        """Draw a line between two points [m]."""
        first, last = (np.array(pixel_of(*point)) for point in (start, end))
        steps = math.ceil(2.0 * float(np.abs(last - first).max())) + 1
        reach = np.arange(-(pen.width // 2), pen.width - pen.width // 2)
        for row, column in np.rint(np.linspace(first, last, steps)).astype(int):
            rows, columns = (np.clip(at + reach, 0, PIXELS - 1) for at in (row, column))
            self.pixels[np.ix_(rows, columns)] = pen.color

    def color_at(self, x: float, y: float) -> Color:
        """Return the color at a point [m]."""
        row, column = (round(value) for value in pixel_of(x, y))
        red, green, blue = (int(value) for value in self.pixels[row, column])
        return red, green, blue


def pixel_of(x: float, y: float) -> tuple[float, float]:
    """Return the row and column of a point [m]."""
    return (SIDE - y) * _METER, x * _METER


@dataclass
class Turtle:
    """A turtle.

    Attributes:
        x, y: Where it is, from the sheet's lower left corner [m].
        theta: Its heading [rad].
        velocity: Ahead, to the left [m/s] and turning [rad/s].
        goal: The heading that it turns to [rad], None if it does not.
        remaining: What is left of that turn [rad].
    """

    x: float
    y: float
    theta: float
    pen: Pen = field(default_factory=Pen)
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    goal: float | None = None
    remaining: float = 0.0
    _commanded: float = -math.inf

    def command(self, ahead: float, left: float, turning: float, now: float) -> None:
        """Move at a velocity [m/s, rad/s] for a second of time `now` [s]."""
        self.velocity, self._commanded = (ahead, left, turning), now

    def teleport(self, x: float, y: float, theta: float, sheet: Sheet) -> None:
        """Go to a pose [m, rad] at once, drawing on the way."""
        self._move_to(x, y, sheet)
        self.theta = wrap(theta)

    def teleport_ahead(self, distance: float, turn: float, sheet: Sheet) -> None:
        """Turn [rad], then go ahead [m] at once."""
        theta = self.theta + turn
        x, y = self.x + distance * math.cos(theta), self.y + distance * math.sin(theta)
        self.teleport(x, y, theta, sheet)

    def turned_back_to(self, theta: float) -> float:
        """Return the angle from its heading to another one [rad]."""
        return wrap(theta - self.theta)

    def advance(self, period: float, now: float, sheet: Sheet) -> bool:
        """Move for a period [s] at time `now` [s]; return whether it hit the wall."""
        if now - self._commanded > _HOLDS:
            self.velocity = (0.0, 0.0, 0.0)
        if self.goal is not None:
            self._turn_to(self.goal, now)
        ahead, left, turning = self.velocity
        self.theta = wrap(self.theta + turning * period)
        cosine, sine = math.cos(self.theta), math.sin(self.theta)
        return self._move_to(
            self.x + (ahead * cosine - left * sine) * period,
            self.y + (ahead * sine + left * cosine) * period,
            sheet,
        )

    def _turn_to(self, goal: float, now: float) -> None:
        self.remaining = wrap(goal - self.theta)
        if abs(self.remaining) < _FACING:
            self.goal, self.velocity = None, (0.0, 0.0, 0.0)
        else:
            self.command(0.0, 0.0, math.copysign(TURN_RATE, self.remaining), now)

    def _move_to(self, x: float, y: float, sheet: Sheet) -> bool:
        inside = min(max(x, 0.0), SIDE), min(max(y, 0.0), SIDE)
        if self.pen.is_down and inside != (self.x, self.y):
            sheet.draw((self.x, self.y), inside, self.pen)
        self.x, self.y = inside
        return inside != (x, y)
