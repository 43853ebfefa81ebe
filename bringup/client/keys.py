"""Driving by keys: what each key of a keyboard layout makes of the velocity."""

from __future__ import annotations

from dataclasses import dataclass, replace

WASD = {
    "w": (1.0, 0.0), "s": (-1.0, 0.0), "a": (0.0, 1.0), "d": (0.0, -1.0), "x": (0.0, 0.0),
}  # fmt: skip
"""Forward and left of each key, in shares of the speeds."""
TWIST = {
    "u": (1.0, 1.0), "i": (1.0, 0.0), "o": (1.0, -1.0),
    "j": (0.0, 1.0), "k": (0.0, 0.0), "l": (0.0, -1.0),
    "m": (-1.0, -1.0), ",": (-1.0, 0.0), ".": (-1.0, 1.0),
}  # fmt: skip
"""As teleop_twist_keyboard has them."""
SPEEDS = {
    "q": (1, 1), "z": (-1, -1), "w": (1, 0), "x": (-1, 0), "e": (0, 1), "c": (0, -1),
}  # fmt: skip
"""By how many steps a key of that layout changes the speed and the turn rate."""
QUIT = ("\x03", "\x04", "\x1b")  # Ctrl-C, Ctrl-D, Escape

PAGES = {
    "wasd": "w forward   s backward   a turn left   d turn right   x stop   q quit",
    "twist": (
        "u i o   forward, with a turn left or right\n"
        "j k l   turn left, stop, turn right\n"
        "m , .   backward, with a turn\n"
        "q/z both speeds up/down 10 %   w/x forward speed   e/c turn rate   Ctrl-C quit"
    ),
}
"""The help text of each layout."""


@dataclass(frozen=True)
class Driving:
    """The command that the pressed keys stand for.

    Attributes:
        layout: `wasd` or `twist`.
        speed: Forward speed of a full key [m/s].
        turn: Turn rate of a full key [rad/s].
        forward: Share of the speed that is asked for, -1 to 1.
        left: Share of the turn rate that is asked for, -1 to 1.
        done: Whether to quit.
    """

    layout: str = "wasd"
    speed: float = 0.3
    turn: float = 0.5
    forward: float = 0.0
    left: float = 0.0
    done: bool = False

    @property
    def velocity(self) -> tuple[float, float]:
        """Forward speed [m/s] and turn rate [rad/s]."""
        return self.forward * self.speed, self.left * self.turn

    def pressed(self, key: str, step: float = 0.1) -> Driving:
        """Return the command after a key; one without a meaning stops the robot.

        Args:
            step: Share by which a key changes a speed; as in teleop_twist_keyboard.
        """
        if key in QUIT or (key == "q" and self.layout == "wasd"):
            return replace(self, forward=0.0, left=0.0, done=True)
        if key in SPEEDS and self.layout == "twist":
            speed, turn = (1.0 + step * steps for steps in SPEEDS[key])
            return replace(self, speed=self.speed * speed, turn=self.turn * turn)
        keys = WASD if self.layout == "wasd" else TWIST
        forward, left = keys.get(key, (0.0, 0.0))
        return replace(self, forward=forward, left=left)
