"""Options that say which robot and world to load, and where to look for their parts."""

from __future__ import annotations

import argparse
import os
import re
from pathlib import Path

_PACKAGES, _MODELS = "ROS_PACKAGE_PATH", "GAZEBO_MODEL_PATH"
_ARGUMENT = re.compile(r"[A-Za-z_]\w*:=")


def add_options(
    parser: argparse.ArgumentParser, action: str | type[argparse.Action] = "store"
) -> None:
    """Add the options that every command with a simulator has.

    Args:
        parser: The command's.
        action: What is done with a robot's file.
    """
    add_robot(parser, "urdf/arjuna.urdf", action)
    parser.add_argument(
        "--world",
        type=Path,
        metavar="FILE",
        help="an SDF world, or a map's YAML whose walls are built (worlds/arjuna_room.world)",
    )
    parser.add_argument(
        "--model-path",
        type=_folder,
        action="append",
        default=[],
        metavar="DIR",
        help="folder of Gazebo models for model://; may be given again",
    )


def add_robot(
    parser: argparse.ArgumentParser,
    otherwise: str,
    action: str | type[argparse.Action] = "store",
) -> None:
    """Add the options that say which robot it is, and what is taken where none is named."""
    about = f"its URDF, xacro or SDF ({otherwise})"
    parser.add_argument("--robot", type=Path, action=action, metavar="FILE", help=about)
    add_package_path(parser, "package:// and $(find ...)")
    parser.add_argument(
        "robot_arguments",
        nargs="*",
        type=_argument,
        default=[],
        metavar="NAME:=VALUE",
        help="arguments of the robot's xacro file",
    )


def add_package_path(parser: argparse.ArgumentParser, what: str) -> None:
    """Add where a robot's packages are; `what` says what is looked for there."""
    parser.add_argument(
        "--package-path",
        type=_folder,
        action="append",
        default=[],
        metavar="DIR",
        help=f"folder of ROS packages for {what}; may be given again",
    )


def add_check(parser: argparse.ArgumentParser) -> None:
    """Add the options that check a file instead of running anything."""
    parser.add_argument(
        "--check",
        type=Path,
        metavar="FILE",
        help="say what is understood of a robot, world or map, and what is not, and end",
    )
    parser.add_argument(
        "--save-guess",
        type=Path,
        metavar="FILE",
        help="with --check: write the drive that was guessed; FILE then loads as the robot",
    )


def extend_search(arguments: argparse.Namespace) -> None:
    """Put the folders given in front of those of the environment, for this process and others."""
    for name, option in ((_PACKAGES, "package_path"), (_MODELS, "model_path")):
        given = [str(folder.resolve()) for folder in vars(arguments).get(option) or []]
        known = [os.environ[name]] if os.environ.get(name) else []
        if given:
            os.environ[name] = os.pathsep.join(given + known)


def check(arguments: argparse.Namespace) -> str:
    """Check a file and return the report.

    Raises:
        ArjunaError: It does not load.
    """
    from arjuna_sim.inputs import describe_file

    extend_search(arguments)
    return describe_file(arguments.check, arguments.robot_arguments, arguments.save_guess)


def _folder(text: str) -> Path:
    if not Path(text).is_dir():
        raise argparse.ArgumentTypeError(f"{text!r} is no folder")
    return Path(text)


def _argument(text: str) -> str:
    if not _ARGUMENT.match(text):
        raise argparse.ArgumentTypeError(f"{text!r} is no argument; valid: NAME:=VALUE")
    return text
