"""The keyboard of a terminal as a joystick."""

from __future__ import annotations

import argparse
import os
import select
import signal
import sys
import termios
import tty
from collections.abc import Iterator
from contextlib import closing, contextmanager

from bringup.client.keys import PAGES, Driving
from bringup.client.session import ClientError, Connection
from bringup.client.velocity import VelocityPublisher
from bringup.terminal import show


def drive_by_keys(
    driving: Driving, arguments: argparse.Namespace, period: float = 0.1, patience: float = 10.0
) -> None:
    """Drive until a key quits; the robot is stopped however this ends.

    Commands come at a period [s] well within the robot's time-out, so that it keeps driving.

    Raises:
        ClientError: There is no terminal, or no robot that listens.
    """
    if not sys.stdin.isatty():
        raise ClientError("teleop reads keys: it needs a terminal as its standard input")
    with closing(Connection("teleop", arguments.namespace)) as session, _interruptible():
        velocity = VelocityPublisher(session, arguments.topic, arguments.stamped)
        velocity.wait(patience)
        show(PAGES[driving.layout])
        try:
            with _raw_keys():
                while not driving.done:
                    session.run_until(_key_waits, period, required=False)
                    if _key_waits():
                        driving = driving.pressed(os.read(sys.stdin.fileno(), 1).decode("latin-1"))
                        _show_state(driving)
                    velocity.send(*driving.velocity)
        finally:
            velocity.stop()


@contextmanager
def _raw_keys() -> Iterator[None]:
    """Hand each key over as it is pressed; give the terminal back as it was."""
    keyboard = sys.stdin.fileno()
    before = termios.tcgetattr(keyboard)
    tty.setraw(keyboard)
    try:
        yield
    finally:
        termios.tcsetattr(keyboard, termios.TCSADRAIN, before)
        show("")


@contextmanager
def _interruptible() -> Iterator[None]:
    """Turn SIGTERM and a closed terminal into KeyboardInterrupt, so that the robot is stopped."""
    before = {
        number: signal.signal(number, signal.default_int_handler)
        for number in (signal.SIGTERM, signal.SIGHUP)
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _key_waits() -> bool:
    return bool(select.select([sys.stdin], [], [], 0.0)[0])


def _show_state(driving: Driving) -> None:
    v, w = driving.velocity
    sys.stdout.write(f"\r\033[K{v:5.2f} m/s {w:5.2f} rad/s")
    sys.stdout.flush()
