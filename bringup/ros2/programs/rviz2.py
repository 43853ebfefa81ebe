"""`rviz2`: the view in a browser instead, with a configuration's displays."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from bringup.ros2.main import become_real
from bringup.ros2.verbs.forward import arjuna, ros_arguments


def main(words: Sequence[str]) -> None:
    """Become `arjuna view`, with RViz's options as ours; ROS's own words are passed over."""
    parser = argparse.ArgumentParser(prog="rviz2", description=__doc__)
    parser.add_argument("-d", "--display-config", metavar="FILE", help="an .rviz file")
    parser.add_argument("-f", "--fixed-frame", metavar="FRAME", help="to draw in")
    given, _ = parser.parse_known_args(ros_arguments(list(words)).own)
    options = ["--config", given.display_config] if given.display_config else []
    if options and not Path(given.display_config).exists():  # as RViz does
        print(f"{given.display_config} is not there: the usual displays are shown", flush=True)
        options = []
    arjuna("view", [*options, *(["--frame", given.fixed_frame] if given.fixed_frame else [])])


def run() -> None:
    """Start RViz where a ROS that has it is sourced, else the view."""
    become_real("rviz2")
    main(sys.argv[1:])
