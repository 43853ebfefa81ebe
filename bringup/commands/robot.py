"""`robot`: the same of a real robot, whose drivers run beside it."""

from __future__ import annotations

import argparse

from bringup.parameters import options

EXAMPLES = ("robot --map my_map.yaml", "robot --slam")


def configure(parser: argparse.ArgumentParser) -> None:
    options.add_parts(parser)
    about = "its URDF, xacro or SDF (none: a driver publishes the robot's transforms)"
    options.add(parser, "--robot", help=about)
    options.add(parser, "--package-path", "robot_arguments")
    names = options.add_robot_names(parser)
    names.add_argument(
        "--imu",
        metavar="TOPIC",
        help="of the IMU: makes the odometry of wheels and gyro, with its transform",
    )
    names.add_argument(
        "--wheel-odom", metavar="TOPIC", help="of the wheels' odometry, for --imu (wheel_odom)"
    )
    options.add(parser, *options.NODES, "--record", *options.SUPERVISED)
    options.add(parser, "--resume", "--maps-folder", "--seed")
    parser.set_defaults(use_sim_time=False)


def run(arguments: argparse.Namespace) -> int:
    """Run until stopped, on the system's clock."""
    from arjuna_core.errors import ArjunaError
    from bringup.processes.interactive import supervise

    if arguments.wheel_odom is not None and arguments.imu is None:
        raise ArjunaError("--wheel-odom is for --imu, which is missing")
    options.extend_search(arguments)
    return supervise(arguments)
