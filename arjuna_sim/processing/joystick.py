"""A gamepad by the kernel's joystick interface, and the velocity that its sticks stand for.

Source: Linux, Documentation/input/joydev/joystick-api.rst; ROS packages joy and teleop_twist_joy.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from arjuna_core.files.input_file import read_text

T = TypeVar("T", int, float)
_EVENT = struct.Struct("<IhBB")  # time [ms], value, type, number of the axis or button
_BUTTON, _AXIS, _INITIAL = 0x01, 0x02, 0x80
_FULL = 32767.0  # a stick's greatest deflection


@dataclass
class Gamepad:
    """The state of a gamepad, from the bytes of its device.

    Attributes:
        deadzone: Share of a stick's range that counts as its middle.
        sticky_buttons: Whether a press toggles a button.
        axes: Deflections, forward and left positive, each -1 to 1.
        buttons: 1 for each that is pressed.
    """

    deadzone: float = 0.05
    sticky_buttons: bool = False
    axes: list[float] = field(default_factory=list)
    buttons: list[int] = field(default_factory=list)
    _rest: bytes = b""

    def take(self, data: bytes) -> bool:
        """Take bytes of the device; return whether they changed anything."""
        before = [*self.axes], [*self.buttons]
        data = self._rest + data
        whole = len(data) - len(data) % _EVENT.size
        self._rest = data[whole:]
        for _, value, kind, number in _EVENT.iter_unpack(data[:whole]):
            if kind & ~_INITIAL == _AXIS:
                _grow(self.axes, number, 0.0)[number] = self._deflection(value)
            elif kind & ~_INITIAL == _BUTTON:
                self._press(number, value, bool(kind & _INITIAL))
        return before != (self.axes, self.buttons)

    def _press(self, number: int, value: int, initial: bool) -> None:
        buttons = _grow(self.buttons, number, 0)
        if not self.sticky_buttons:
            buttons[number] = int(value != 0)
        elif value and not initial:
            buttons[number] = 1 - buttons[number]

    def _deflection(self, raw: int) -> float:
        """Return a deflection that is 0 up to the dead zone; the kernel's is negated."""
        share = max(-1.0, raw / _FULL)
        beyond = max(0.0, abs(share) - self.deadzone) / max(1e-9, 1.0 - self.deadzone)
        return -beyond if share > 0.0 else beyond


def _grow(values: list[T], number: int, rest: T) -> list[T]:
    """Return a list that has an entry of a number; new ones are at rest."""
    values.extend([rest] * (number + 1 - len(values)))
    return values


class Device:
    """A gamepad's device that is read without waiting, and opened again after it was gone."""

    def __init__(self, path: str) -> None:
        self.path = path
        self._file: int | None = None

    @property
    def is_open(self) -> bool:
        """Return whether it is there."""
        return self._file is not None

    def read(self, most: int = 4096) -> bytes:
        """Return what it has sent since; nothing where it is not there."""
        try:
            if self._file is None:
                self._file = os.open(self.path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
            return os.read(self._file, most)
        except BlockingIOError:
            return b""
        except OSError:
            self.close()
            return b""

    def close(self) -> None:
        """Close it."""
        if self._file is not None:
            os.close(self._file)
        self._file = None


def device_path(number: int, name: str, folder: Path = Path("/sys/class/input")) -> str:
    """Return the path of the gamepad of a name, or of a number where the name is empty."""
    for entry in sorted(folder.glob("js*")) if name else ():
        file = entry / "device" / "name"
        if file.is_file() and read_text(file).strip() == name:
            return f"/dev/input/{entry.name}"
    return f"/dev/input/js{number}"


def deflected(axes: Iterable[float], axis: int, scale: float) -> float:
    """Return an axis's deflection times a scale; 0 for an axis that there is not."""
    values = list(axes)
    return values[axis] * scale if 0 <= axis < len(values) else 0.0
