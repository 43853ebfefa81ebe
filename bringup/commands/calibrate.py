"""`calibrate`: find a robot's effective track width and wheel radius by driving it."""

from __future__ import annotations

import argparse
from pathlib import Path

EXAMPLES = ("calibrate --robot my.urdf --out out/calibration",)


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--robot", type=Path, metavar="FILE", help="the URDF (urdf/arjuna.urdf)")
    parser.add_argument(
        "--world", type=Path, metavar="FILE", help="with 4 m free space (worlds/empty.world)"
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("out/calibration"),
        metavar="FOLDER",
        help="where parameter file, URDF snippet and picture go (%(default)s)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Calibrate and print the report."""
    from bringup.offline.calibration import write_calibration
    from bringup.terminal import show

    show(write_calibration(arguments.robot, arguments.world, arguments.out))
    return 0
