"""LineIterator: the points of a line one after another, under the original's names."""

# ruff: noqa: D102 - the names are the original's, and say what each method returns
from __future__ import annotations

import math


class LineIterator:
    """Walks along x from one end to the other, along y where the line is upright.

    Args:
        step_size: Of x, or of y where the line is upright.

    Raises:
        TypeError: A value is no number.
        ValueError: The step is not positive, or both ends are one.
    """

    def __init__(self, x0: float, y0: float, x1: float, y1: float, step_size: float = 1.0) -> None:
        given = {"x0": x0, "y0": y0, "x1": x1, "y1": y1, "step_size": step_size}
        for name, value in given.items():
            if type(value) not in (int, float):
                raise TypeError(f"{name} must be a number (int or float)")
        if step_size <= 0:
            raise ValueError("step_size must be a positive number")
        if (x0, y0) == (x1, y1):
            raise ValueError("Line has zero length (All 4 points have same coordinates)")
        self.x0_, self.y0_, self.x1_, self.y1_ = x0, y0, x1, y1
        self.x_, self.y_, self.step_size_, self.valid_ = x0, y0, step_size, True

    def isValid(self) -> bool:
        return self.valid_

    def advance(self) -> None:
        """Go one step on; at the end the line is no longer valid."""
        if self.x1_ != self.x0_:
            self.x_ = self._next(self.x_, self.x1_)
            slope = (self.y1_ - self.y0_) / (self.x1_ - self.x0_)
            self.y_ = round(self.y1_ + slope * (self.x_ - self.x1_), 5)
        else:
            self.y_ = self._next(self.y_, self.y1_)

    def _next(self, at: float, end: float) -> float:
        self.valid_ = at != end
        ahead = min(self.step_size_, abs(end - at))
        return end if ahead == abs(end - at) else round(at + math.copysign(ahead, end - at), 5)

    def getX(self) -> float:
        return self.x_

    def getY(self) -> float:
        return self.y_

    def getX0(self) -> float:
        return self.x0_

    def getY0(self) -> float:
        return self.y0_

    def getX1(self) -> float:
        return self.x1_

    def getY1(self) -> float:
        return self.y1_

    def get_line_length(self) -> float:
        return math.hypot(self.x1_ - self.x0_, self.y1_ - self.y0_)
