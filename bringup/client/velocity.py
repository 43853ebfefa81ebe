"""Velocity commands of a client, from the first listener to a stop that arrives."""

from __future__ import annotations

from arjuna_core.ros.velocity import VelocityOutput, listeners
from bringup.client.session import Session

_REMEDY = "is 'python -m bringup sim' running?"


def velocity_output(
    session: Session, timeout: float, topic: str = "cmd_vel", stamped: bool | None = None
) -> VelocityOutput:
    """Return the output of commands to a robot that listens.

    Raises:
        ArjunaError: None does in time [s].
    """
    node, what = session.client, f"a robot that listens on '{topic}'"
    session.wait_for(lambda: bool(listeners(node, topic)), timeout, what, _REMEDY)
    output = VelocityOutput(node, stamped, frame="", topic=topic)
    session.wait_for(output.has_listener, timeout, what, _REMEDY)
    return output


def stop(session: Session, output: VelocityOutput) -> None:
    """Stand still; the command reaches the robot before the client leaves."""
    for _ in range(3):
        output.stop()
        session.pause(0.05)
