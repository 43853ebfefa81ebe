"""The keyboard of a terminal as a joystick."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager

from bringup.client.keys import PAGES, Driving
from bringup.client.motion import stop, velocity_output
from bringup.client.session import ClientError, Connection
from bringup.terminal import Keys, show


def drive_by_keys(
    driving: Driving, arguments: argparse.Namespace, patience: float, period: float = 0.1
) -> None:
    """Drive until a key quits; the robot is stopped however this ends.

    Commands come at a period [s] well within the robot's time-out, so that it keeps driving. A
    robot that listens is waited for up to a patience [s].

    Raises:
        ClientError: There is no terminal, or no robot that listens.
    """
    keys = Keys(raw=True)
    if not keys.live:
        raise ClientError("teleop reads keys: it needs a terminal as its standard input")
    with closing(Connection("teleop", arguments.namespace)) as session, _interruptible():
        show(PAGES[driving.layout])
        output = velocity_output(session, patience, arguments.topic, arguments.stamped)
        try:
            with keys:
                while not driving.done:
                    session.run_until(keys.waits, period, required=False)
                    if keys.waits():
                        driving = driving.pressed(keys.wait(0.0))
                        _show_state(driving)
                    output.publish(driving.velocity)
        finally:
            stop(session, output)
            show("")  # ends the line of the state


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


def _show_state(driving: Driving) -> None:
    now = driving.velocity
    side = f" {now.y:5.2f} m/s to the left" if now.y else ""
    sys.stdout.write(f"\r\033[K{now.x:5.2f} m/s{side} {now.yaw_rate:5.2f} rad/s")
    sys.stdout.flush()
