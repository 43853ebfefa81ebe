"""LineIterator: the points of a line, step by step, under the original's names."""

from __future__ import annotations

import math
from numbers import Real

from nav2_simple_commander.costmap_2d import value_of


class LineIterator:
    """Goes along a line by steps of x, or of y where x stays; the last point is the end.

    Raises:
        TypeError: A coordinate or the step is no number.
        ValueError: The step is not above 0, or the line has no length.
    """

    def __init__(self, x0: float, y0: float, x1: float, y1: float, step_size: float = 1.0) -> None:
        given = {"x0": x0, "y0": y0, "x1": x1, "y1": y1, "step_size": step_size}
        for name, value in given.items():
            if not isinstance(value, Real):
                raise TypeError(f"{name} must be a number (int or float)")
        if step_size <= 0:
            raise ValueError("step_size must be a positive number")
        if (x0, y0) == (x1, y1):
            raise ValueError("Line has zero length (All 4 points have same coordinates)")
        self.x0_, self.y0_, self.x1_, self.y1_ = x0, y0, x1, y1
        self.x_, self.y_ = x0, y0
        self.step_size_, self.valid_ = step_size, True

    def advance(self) -> None:
        """Go to the next point; past the end the iterator is not valid any more."""
        if (self.x_, self.y_) == (self.x1_, self.y1_):
            self.valid_ = False
            return
        across, up = self.x1_ - self.x0_, self.y1_ - self.y0_
        length, gone = (across, self.x_ - self.x0_) if across else (up, self.y_ - self.y0_)
        share = (abs(gone) + self.step_size_) / abs(length)
        if share >= 1.0:
            self.x_, self.y_ = self.x1_, self.y1_
        else:
            self.x_ = round(self.x0_ + share * across, 5)
            self.y_ = round(self.y0_ + share * up, 5)

    isValid = value_of("valid_")
    getX = value_of("x_")
    getY = value_of("y_")
    getX0 = value_of("x0_")
    getY0 = value_of("y0_")
    getX1 = value_of("x1_")
    getY1 = value_of("y1_")

    def get_line_length(self) -> float:
        return math.hypot(self.x1_ - self.x0_, self.y1_ - self.y0_)
