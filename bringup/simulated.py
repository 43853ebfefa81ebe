"""A simulated robot inside a script or notebook: in lock-step, as fast as it goes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from std_msgs.msg import String

from arjuna_core.errors import ArjunaError
from arjuna_core.files.shipped import found_or_shipped
from arjuna_core.ros import qos
from arjuna_core.se2 import SE2
from bringup.client.robot import Robot
from bringup.lockstep import LockStep
from bringup.parameters.files import merged
from bringup.stack import (
    EXPLORER_GROUP,
    LOCALIZATION_GROUP,
    NAVIGATION_GROUP,
    SIM_GROUP,
    SLAM_GROUP,
    Group,
)


class SimulatedRobot(Robot):
    """A robot whose simulator is in this process; its time passes only while it is waited for."""

    session: LockStep

    def close(self) -> None:
        """Stop, and end the simulation."""
        if self.session.nodes:
            super().close()
            self.session.close()
            self.session.nodes.clear()

    def explore(self, timeout: float = 1800.0) -> bool:
        """Drive to the edges of the map until all is seen; return whether it was in time [s]."""
        session, said = self.session, [""]
        client = session.client
        status = client.create_subscription(
            String, "explorer/status", lambda message: said.append(message.data), qos.LATCHED
        )
        session.start(EXPLORER_GROUP)
        done = session.run_until(lambda: said[-1].startswith("done"), timeout, required=False)
        session.stop(EXPLORER_GROUP)
        client.destroy_subscription(status)
        return done


def simulate(
    robot: str | Path = "",
    world: str | Path = "",
    map: str | Path = "",
    slam: bool = False,
    at: Sequence[float] | None = None,
    seed: int = 0,
    params: str | Path = "",
    timeout: float = 10.0,
    settle: float = 1.0,
) -> SimulatedRobot:
    """Return a robot in a simulation of its own; the same seed gives the same run.

    Args:
        robot: Its URDF, xacro or SDF; the shipped robot if empty. Files that only ship with
            Arjuna are found by their name, such as `urdf/burger.urdf`.
        world: The room if empty.
        map: Localizes on it and navigates, if given.
        slam: Whether it maps and navigates; else it drives by `forward`, `turn` and the like.
        at: Where it starts in the world [m, m, rad]; if None where a world that holds it puts it,
            else the origin.
        params: A parameter file.
        timeout: How long it waits for what should be there at once [s].
        settle: How long it stands still first [s].

    Raises:
        ArjunaError: A file or value is not valid, or the stack does not start.
    """
    from rclpy.logging import LoggingSeverity, set_logger_level

    from bringup.cli import parse
    from bringup.parameters.inputs import gather
    from bringup.scenarios.drive import placed

    if map and slam:
        raise ArjunaError("simulate: map and slam exclude each other: drive on a map or make one")
    words = ["demo", "--seed", str(seed)]
    for name, path in zip(("robot", "world", "params"), (robot, world, params), strict=True):
        words += [f"--{name}", found_or_shipped(str(path))] if path else []
    values = gather(parse(words))
    own = (values["sim"].get(f"initial_pose.{key}", 0.0) for key in ("x", "y", "yaw"))
    values = merged(values, placed(SE2(*(float(value) for value in (own if at is None else at)))))
    groups: tuple[Group, ...] = (SLAM_GROUP, NAVIGATION_GROUP) if slam else ()
    if map:
        values = merged(values, {"map_server": {"yaml_filename": found_or_shipped(str(map))}})
        groups = LOCALIZATION_GROUP, NAVIGATION_GROUP
    set_logger_level("", LoggingSeverity.ERROR)  # a start has nothing else to say
    session = LockStep(values, strict=True)
    try:
        session.start(SIM_GROUP, *groups)
        session.run(settle)
        set_logger_level("", LoggingSeverity.WARN)
    except BaseException:
        session.close()
        raise
    scan_topic = values["amcl"].get("scan_topic", "scan")
    cmd_vel_topic = values["collision_monitor"].get("cmd_vel_out_topic", "cmd_vel")
    return SimulatedRobot(timeout, "", session, scan_topic, cmd_vel_topic)
