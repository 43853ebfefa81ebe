"""Processes that ROS 2 has and Arjuna does without: `ros2 daemon`, and containers of components."""

from __future__ import annotations

from bringup.ros2.errors import Ros2Error


def run(words: list[str]) -> None:
    """Print that there is no daemon, so that scripts that stop or start it continue."""
    absent = words[:1] in (["status"], ["stop"])
    print("The daemon is not running" if absent else "There is no daemon: none is needed")


def component(words: list[str]) -> None:
    """Refuse what needs a container; a list of those that there are is empty."""
    if words[:1] not in (["list"], ["types"], ["-h"], ["--help"], []):
        ways = "'ros2 run PACKAGE EXECUTABLE', or 'ros2 launch' of a file with containers"
        raise Ros2Error(f"There are no containers: each node is a process here; {ways}")
