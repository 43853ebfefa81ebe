"""Runs a command; only here do errors become messages and exit codes."""

from __future__ import annotations

import argparse
import os
import sys

from arjuna_core.errors import ArjunaError

OK, REFUSED, INTERRUPTED = 0, 2, 130
EXTRAS = {
    "foxglove": "view",
    "gymnasium": "learn",
    "mujoco_warp": "gpu",
    "optuna": "tune",
    "pyarrow": "campaign",
    "ray": "cluster",
    "rerun": "view",
}
"""The modules that not every command needs, and the extra of `make setup` that installs each."""


def run(arguments: argparse.Namespace) -> int:
    """Run a command.

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
        sys.stderr.write(f"error: {_lacking(error.name or '')}\n")
    except KeyboardInterrupt:
        sys.stderr.write("\nstopped\n")
        return INTERRUPTED
    return REFUSED


def _lacking(module: str) -> str:
    """Return what to say of a module that is not there, with the words that install it."""
    extra = EXTRAS.get(module.partition(".")[0])
    if extra is None:
        return f"the module {module} is not installed; run 'make setup'"
    return (
        f"the module {module} is not installed; run 'make setup EXTRAS={extra}',"
        " or 'make setup' for all there is"
    )
