"""The ament index: where message definitions and hashes of installed packages are found."""

from __future__ import annotations

import os
import sys

_VARIABLE = "AMENT_PREFIX_PATH"


def add_environment_to_ament_index() -> None:
    """Append this Python environment to the ament index, behind a sourced ROS's prefixes."""
    prefixes = [entry for entry in os.environ.get(_VARIABLE, "").split(os.pathsep) if entry]
    if sys.prefix not in prefixes:
        os.environ[_VARIABLE] = os.pathsep.join([*prefixes, sys.prefix])
