"""The interactive stack: a process for each group of nodes, supervised until stopped."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from arjuna_core.errors import InputFileError
from bringup.parameters.files import Parameters
from bringup.parameters.inputs import gather, groups_of
from bringup.processes.child import ChildSpec
from bringup.processes.supervisor import Supervisor
from bringup.terminal import show


def supervise(arguments: argparse.Namespace) -> int:
    """Run a command's groups of nodes until stopped.

    Args:
        arguments: What `cli_parser.parse` returned.

    Returns:
        The exit code: 0 after a clean stop, 1 where a process could not be kept.

    Raises:
        ArjunaError: A file cannot be used, or a node, key or value is not valid.
    """
    parameters = gather(arguments)
    specs = [
        ChildSpec(group.name, host_command(group.name, parameters, arguments.log_level))
        for group in groups_of(arguments)
    ]
    if arguments.record is not None:
        specs.append(ChildSpec("record", _record_command(arguments.record), needed=False))
    return Supervisor(specs, show).run()


def _record_command(folder: Path) -> list[str]:
    """Return the command of the recorder; started again it takes the next free name."""
    if folder.name and folder.exists():
        raise InputFileError(folder, "exists already and is not overwritten")
    into = ["--next", "-o", str(folder)] if folder.name else []
    return [sys.executable, "-m", "bringup", "record", *into]


def host_command(group: str, parameters: Parameters, log_level: str) -> list[str]:
    """Return the command of the process that runs a group of nodes."""
    values = json.dumps(parameters)
    ros = ["--ros-args", "--log-level", log_level]
    return [sys.executable, "-m", "bringup.processes.host", group, "--parameters", values, *ros]
