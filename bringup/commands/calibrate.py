"""`calibrate`: find a robot's effective track width and wheel radius by driving it."""

from __future__ import annotations

import argparse
from pathlib import Path

from bringup.parameters import options

EXAMPLES = ("calibrate --robot my.urdf --out out/calibration",)


def configure(parser: argparse.ArgumentParser) -> None:
    options.add(parser, "--robot", help="the URDF (urdf/arjuna.urdf)")
    options.add(parser, "--world", help="with 4 m free space (worlds/empty.world)")
    about = "where parameter file, URDF snippet and picture go (%(default)s)"
    options.add(parser, "--out", default=Path("out/calibration"), help=about)


def run(arguments: argparse.Namespace) -> int:
    """Calibrate and print the report."""
    from bringup.offline.calibration import write_calibration
    from bringup.terminal import show

    show(write_calibration(arguments.robot, arguments.world, arguments.out))
    return 0
