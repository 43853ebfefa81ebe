"""The interactive stack: a process for each group of nodes, supervised until stopped."""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Sequence
from contextlib import closing
from datetime import datetime
from pathlib import Path

from arjuna_core.errors import ArjunaError, InputFileError
from arjuna_core.files.whole_file import own_folder
from bringup.parameters.files import Parameters, merged
from bringup.parameters.inputs import gather, groups_of
from bringup.processes.child import ChildSpec
from bringup.processes.fork import in_fork, warm_up
from bringup.processes.output import JsonOutput, RunLog, StartUp, TextOutput
from bringup.processes.supervisor import Supervisor
from bringup.stack import BT_NAVIGATOR, SIM, SLAM_TOOLBOX, WAYPOINT_FOLLOWER, Group


def supervise(arguments: argparse.Namespace) -> int:
    """Run a command's groups of nodes until stopped.

    Returns:
        The exit code: 0 after a clean stop, 1 where a process could not be kept.

    Raises:
        ArjunaError: A file cannot be used, or a node, key or value is not valid.
    """
    with own_folder("resume") as folder:
        # In a fork: it may import rclpy, which starts threads.
        parameters = in_fork(lambda: _gathered(arguments))
        resume = bool(vars(arguments).get("resume"))
        parameters = merged(parameters, _resuming(Path(folder), resume))
        groups = groups_of(arguments)
        warm_up(groups)
        file = Path(folder) / "parameters.json"
        file.write_text(json.dumps(parameters), encoding="utf-8")
        return _supervise(arguments, groups, file)


def _gathered(arguments: argparse.Namespace) -> Parameters:
    if arguments.command == "sim":
        refuse_second(f"/{arguments.namespace}/{SIM.name}".replace("//", "/"))
    return gather(arguments, ask=True)


def refuse_second(simulator: str, patience: float = 2.0) -> None:
    """Refuse a simulator beside one of its name, looked for within a time [s]; imports rclpy.

    Raises:
        ArjunaError: There is one.
    """
    from bringup.client.graph import nodes
    from bringup.client.session import Connection
    from bringup.ros2.discovery import discover, participants

    domain = int(os.environ.get("ROS_DOMAIN_ID") or 0)
    if participants(domain) == 0 and os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE") == "LOCALHOST":
        return
    with closing(Connection("simulator_probe")) as session:
        if discover(session, lambda: simulator in nodes(session), missing=0.0, limit=patience):
            raise ArjunaError(
                f"a simulator runs already: {simulator} in domain {domain}; end it (Ctrl-C in its"
                " terminal), or give this one a --namespace or another --domain-id"
            )


def _resuming(folder: Path, goals: bool) -> Parameters:
    """Return where nodes keep what they continue from after a crash; goals and maps if asked."""
    nodes = (SIM, *((BT_NAVIGATOR, WAYPOINT_FOLLOWER, SLAM_TOOLBOX) if goals else ()))
    return {spec.name: {"resume_file": str(folder / spec.name)} for spec in nodes}


def _supervise(arguments: argparse.Namespace, groups: Sequence[Group], parameters: Path) -> int:
    names = [group.name for group in groups]
    specs = [
        ChildSpec(name, host_command(name, parameters, arguments), run=run_host) for name in names
    ]
    if arguments.record is not None:
        specs.append(
            ChildSpec("record", record_command(arguments.record, arguments.namespace), needed=False)
        )
    return run_supervised(arguments, specs, names)


def run_supervised(
    arguments: argparse.Namespace, specs: Sequence[ChildSpec], names: Sequence[str]
) -> int:
    """Run processes, those that hold nodes by name, until stopped; return the exit code."""
    with closing(RunLog(arguments.command, datetime.now().astimezone())) as log:
        start_up = StartUp(names, time.monotonic())
        output = JsonOutput(start_up, log) if arguments.json else TextOutput(start_up, log)
        where = "no log file: its folder cannot be written" if log.path is None else log.path
        output.line("bringup", f"log: {where}")
        return Supervisor(specs, output).run()


def run_host() -> int:
    """Run what `sys.argv` says; rclpy is imported here, for a fork does not take its threads."""
    from bringup.processes.host import main

    return main()


def record_command(folder: Path, namespace: str) -> list[str]:
    """Return the recorder's command; started again it takes the next free name.

    Raises:
        InputFileError: The folder, which a time names if it has no name, exists.
    """
    if folder.name and folder.exists():
        raise InputFileError(folder, "exists already and is not overwritten")
    into = ["--next", "-o", str(folder)] if folder.name else []
    topics = ["--topics", f"/{namespace.strip('/')}/.*"] if namespace else []
    return [sys.executable, "-m", "bringup", "record", *into, *topics]


def host_command(
    group: str, parameters: Path, arguments: argparse.Namespace, domain: int | None = None
) -> list[str]:
    """Return the command of the process that runs a group of nodes, in a domain of ROS.

    Their parameters are in a file.
    """
    host = [sys.executable, "-m", "bringup.host", group, "--parameters", f"@{parameters}"]
    if arguments.namespace:
        host += ["--namespace", arguments.namespace]
    if domain is not None:
        host += ["--domain-id", f"{domain}"]
    ros = ["--ros-args", "--disable-external-lib-logs", "--log-level", arguments.log_level]
    given = vars(arguments)
    renamed = (word for rule in given.get("remap", ()) for word in ("--remap", rule))
    return [*host, *ros, *renamed]
