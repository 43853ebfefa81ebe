"""The window in which turtles are seen, by tkinter where Python has it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any, ClassVar

from bringup.ros2.turtlesim.turtle import PIXELS, Sheet, Turtle, pixel_of

_SHAPE = ((1.0, 0.0), (-0.7, 0.6), (-0.4, 0.0), (-0.7, -0.6))
"""A turtle seen from above, ahead and to the left, in shares of its length."""
_LENGTH = 18.0  # [px]
_HEAD = "#d9f56b"


class Window:
    """A window with a sheet and its turtles.

    Attributes:
        PERIOD: From one picture to the next [s].
    """

    PERIOD: ClassVar[float] = 0.04

    def __init__(self, root: Any) -> None:
        import tkinter

        self._root, self._is_open = root, True
        root.title("TurtleSim")
        root.resizable(False, False)
        root.protocol("WM_DELETE_WINDOW", self._close)
        self._canvas = tkinter.Canvas(root, width=PIXELS, height=PIXELS, highlightthickness=0)
        self._canvas.pack()
        self._picture = tkinter.PhotoImage(width=PIXELS, height=PIXELS)
        self._canvas.create_image(0, 0, image=self._picture, anchor="nw")

    @classmethod
    def opened(cls, warn: Callable[[str], object]) -> Window | None:
        """Return a window; None, saying why, where there can be none."""
        try:
            import tkinter
        except ImportError:
            warn("no window: Python lacks tkinter ('apt install python3-tk'); the turtles move")
            return None
        try:
            return cls(tkinter.Tk())
        except tkinter.TclError as error:
            warn(f"no window: {error}; the turtles move: 'ros2 topic echo /turtle1/pose'")
            return None

    def show(self, sheet: Sheet, turtles: Iterable[Turtle]) -> bool:
        """Draw what there is; return whether the window is still open."""
        header = f"P6 {PIXELS} {PIXELS} 255 ".encode()
        self._picture.configure(data=header + sheet.pixels.tobytes(), format="PPM")
        self._canvas.delete("turtle")
        for turtle in turtles:
            self._canvas.create_polygon(outline_of(turtle), fill=_HEAD, tags="turtle")
        self._root.update()
        return self._is_open

    def _close(self) -> None:
        self._is_open = False


def outline_of(turtle: Turtle) -> list[float]:
    """Return the columns and rows of a turtle's outline [px], by turns."""
    row, column = pixel_of(turtle.x, turtle.y)
    cosine, sine = math.cos(turtle.theta) * _LENGTH, math.sin(turtle.theta) * _LENGTH
    found: list[float] = []
    for ahead, left in _SHAPE:
        found += [column + ahead * cosine - left * sine, row - ahead * sine - left * cosine]
    return found
