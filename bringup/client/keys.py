"""Driving by keys: what each key of a keyboard layout makes of the velocity."""

from __future__ import annotations

from dataclasses import dataclass, replace

from arjuna_core.twist import STILL, Velocity

WASD = {
    "w": (1.0, 0.0), "s": (-1.0, 0.0), "a": (0.0, 1.0), "d": (0.0, -1.0), "x": (0.0, 0.0),
}  # fmt: skip
"""Forward speed and turn to the left of each key, in shares of the speeds."""
TWIST = {
    "u": (1.0, 1.0), "i": (1.0, 0.0), "o": (1.0, -1.0),
    "j": (0.0, 1.0), "k": (0.0, 0.0), "l": (0.0, -1.0),
    "m": (-1.0, -1.0), ",": (-1.0, 0.0), ".": (-1.0, 1.0),
}  # fmt: skip
"""As teleop_twist_keyboard has them."""
STRAFE = {
    "U": (1.0, 1.0), "I": (1.0, 0.0), "O": (1.0, -1.0), "J": (0.0, 1.0), "L": (0.0, -1.0),
    "M": (-1.0, 1.0), "<": (-1.0, 0.0), ">": (-1.0, -1.0),
}  # fmt: skip
"""With Shift, for robots that drive sideways: forward and to the left."""
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
        "U I O, J L, M < >   with Shift: to the side in place of the turn\n"
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
        shares: Of a full key's motion that are asked for; each part -1 to 1.
        done: Whether to quit.
    """

    layout: str = "wasd"
    speed: float = 0.3
    turn: float = 0.5
    shares: Velocity = STILL
    done: bool = False

    @property
    def velocity(self) -> Velocity:
        """The velocity to drive."""
        x, y, turn = self.shares.x, self.shares.y, self.shares.yaw_rate
        return Velocity(x * self.speed, y=y * self.speed, yaw_rate=turn * self.turn)

    def pressed(self, key: str, step: float = 0.1) -> Driving:
        """Return the command after a key; one without a meaning stops the robot.

        Args:
            step: Share by which a key changes a speed; as in teleop_twist_keyboard.
        """
        if key in QUIT or (key == "q" and self.layout == "wasd"):
            return replace(self, shares=STILL, done=True)
        if key in SPEEDS and self.layout == "twist":
            speed, turn = (1.0 + step * steps for steps in SPEEDS[key])
            return replace(self, speed=self.speed * speed, turn=self.turn * turn)
        if key in STRAFE and self.layout == "twist":
            forward, left = STRAFE[key]
            return replace(self, shares=Velocity(forward, y=left))
        keys = WASD if self.layout == "wasd" else TWIST
        forward, left = keys.get(key, (0.0, 0.0))
        return replace(self, shares=Velocity(forward, yaw_rate=left))
