"""Runs a command; the one place where errors become messages and exit codes."""

from __future__ import annotations

import argparse
import os
import sys

from arjuna_core.errors import ArjunaError

OK, REFUSED, INTERRUPTED = 0, 2, 130


def run(arguments: argparse.Namespace) -> int:
    """Run a command.

    Args:
        arguments: What `cli_parser.parse` returned.

    Returns:
        The exit code: 0 done or stopped, 1 something failed, 2 an input was refused.
    """
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    if arguments.run is None:
        return OK
    if vars(arguments).get("domain_id") is not None:
        os.environ["ROS_DOMAIN_ID"] = str(arguments.domain_id)
    try:
        return int(arguments.run(arguments))
    except ArjunaError as error:
        sys.stderr.write(f"error: {error}\n")
    except ModuleNotFoundError as error:
        sys.stderr.write(f"error: the module {error.name} is not installed; run 'make setup'\n")
    except KeyboardInterrupt:
        sys.stderr.write("\nstopped\n")
        return INTERRUPTED
    return REFUSED
