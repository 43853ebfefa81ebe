"""What the commands do; the one place where errors become messages and exit codes."""

from __future__ import annotations

import argparse
import importlib
import json
import os
import signal
import sys

from arjuna_core.errors import ArjunaError, InputFileError
from bringup import bench
from bringup.parameters import robot_options
from bringup.parameters.files import Parameters
from bringup.parameters.inputs import gather, groups_of
from bringup.processes.child import ChildSpec
from bringup.processes.supervisor import Supervisor

OK, FAILED, REFUSED, INTERRUPTED = 0, 1, 2, 130
_OFFLINE = {"slam": "bringup.offline.slam", "nav": "bringup.offline.amcl"}


def run(arguments: argparse.Namespace) -> int:
    """Run a command.

    Args:
        arguments: What `cli_parser.parse` returned.

    Returns:
        The exit code: 0 done or stopped, 1 something failed, 2 an input was refused.
    """
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    try:
        if arguments.command == "bench":
            bench.run(arguments.name, arguments.options)
            return OK
        if arguments.command == "calibrate":
            _show(importlib.import_module("bringup.offline.calibration").run(arguments))
            return OK
        if arguments.command in _OFFLINE and arguments.offline is not None:
            _show(importlib.import_module(_OFFLINE[arguments.command]).run(arguments))
            return OK
        if arguments.command in ("entity", "world"):
            from bringup.simulator import commands as simulator_commands

            simulator_commands.run(arguments, _show)
            return OK
        if arguments.command == "sim" and arguments.check is not None:
            _show(robot_options.check(arguments))
            return OK
        robot_options.extend_search(arguments)
        parameters = gather(arguments)
        if arguments.command == "demo":
            return _demo(arguments, parameters)
        return _supervise(arguments, parameters)
    except ArjunaError as error:
        sys.stderr.write(f"error: {error}\n")
    except ModuleNotFoundError as error:
        sys.stderr.write(f"error: the module {error.name} is not installed; run 'make setup'\n")
    except KeyboardInterrupt:
        sys.stderr.write("\nstopped\n")
        return INTERRUPTED
    return REFUSED


def _supervise(arguments: argparse.Namespace, parameters: Parameters) -> int:
    specs = [
        ChildSpec(group.name, host_command(group.name, parameters, arguments.log_level))
        for group in groups_of(arguments.command)
    ]
    return Supervisor(specs, _show).run()


def host_command(group: str, parameters: Parameters, log_level: str) -> list[str]:
    """Return the command of the process that runs a group of nodes."""
    values = json.dumps(parameters)
    ros = ["--ros-args", "--log-level", log_level]
    return [sys.executable, "-m", "bringup.processes.host", group, "--parameters", values, *ros]


def _show(line: str) -> None:
    """Print a line; where nobody reads any more, as after `| head`, stop."""
    try:
        print(line, flush=True)
    except BrokenPipeError:
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115, PTH123 - for the rest of the process
        os.kill(os.getpid(), signal.SIGTERM)


def _demo(arguments: argparse.Namespace, parameters: Parameters) -> int:
    from rclpy.logging import LoggingSeverity, set_logger_level

    from bringup.demo.demo import Demo, DemoOptions
    from bringup.demo.report import ARTIFACTS, summary
    from bringup.lockstep import LockStepError
    from bringup.progress import Progress

    out = arguments.out.resolve()
    try:
        out.mkdir(parents=True, exist_ok=True)
        for name in ARTIFACTS:  # an earlier demo's; the recorder overwrites nothing
            (out / name).unlink(missing_ok=True)
    except OSError as error:
        problem = f"cannot be written: {error.strerror}; valid: a folder that can be written"
        raise InputFileError(arguments.out, problem) from error
    set_logger_level("", LoggingSeverity[arguments.log_level.upper()])
    options = DemoOptions(arguments.seed or 0, out, parameters)
    try:
        report = Demo(options, Progress()).run()
    except LockStepError as error:
        sys.stderr.write(f"error: {error}\n")
        return FAILED
    print(summary(arguments.out, report))
    return OK if report.success else FAILED
