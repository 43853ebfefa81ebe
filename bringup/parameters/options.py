"""Options that several commands share, and the types of their values."""

from __future__ import annotations

import argparse
import math
import re
from pathlib import Path

_DOMAIN_MAX = 232  # ports above do not exist (OMG DDSI-RTPS 2.5, 9.6.2.3)
_NAMESPACE = re.compile(r"/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*/?", re.ASCII)
LOG_LEVELS = ("debug", "info", "warn", "error", "fatal")


def add_node_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of every command that runs nodes."""
    parser.add_argument(
        "--params",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="a ROS parameter file; may be given again, later files win",
    )
    parser.add_argument(
        "--param",
        action="append",
        default=[],
        metavar="NAME:=VALUE",
        help="a parameter, over those of files; NODE:NAME:=VALUE for one node; may be given again",
    )
    parser.add_argument(
        "--strict", action="store_true", help="refuse files with names that no node has"
    )
    parser.add_argument(
        "--log-level", choices=LOG_LEVELS, default="info", help="what to log at least (info)"
    )


def add_parts(parser: argparse.ArgumentParser) -> None:
    """Add where the robot is located by, and which half of the stack is left out."""
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--map", type=Path, metavar="FILE", help="the map's YAML file")
    where.add_argument("--slam", action="store_true", help="map while navigating")
    where.add_argument(
        "--without-localization", action="store_true", help="navigation alone: others localize"
    )
    parser.add_argument(
        "--without-navigation", action="store_true", help="localization or mapping alone"
    )


def add_clock(parser: argparse.ArgumentParser) -> None:
    """Add which clock the nodes take their time from."""
    parser.add_argument(
        "--use-sim-time",
        type=_truth,
        metavar="true|false",
        help="whether time is a simulator's (as the files say; true)",
    )


def _truth(text: str) -> bool:
    """Return a truth value as ROS writes it."""
    if text.lower() not in ("true", "false"):
        raise argparse.ArgumentTypeError(f"{text!r} is no truth value; valid: true, false")
    return text.lower() == "true"


def add_record(parser: argparse.ArgumentParser) -> None:
    """Add the recording of what the nodes say."""
    parser.add_argument(
        "--record",
        type=Path,
        nargs="?",
        const=Path(),
        metavar="FOLDER",
        help="record all topics meanwhile; the folder must not exist (rosbag2_ and the time)",
    )


def add_supervision(
    parser: argparse.ArgumentParser, action: str | type[argparse.Action] = "store"
) -> None:
    """Add the options of a command that runs supervised processes.

    Args:
        parser: The command's.
        action: What is done with a robot's namespace.
    """
    add_robot_choice(parser, action)
    parser.add_argument(
        "--json", action="store_true", help="print states and log as JSON, an object a line"
    )


def add_resume(parser: argparse.ArgumentParser) -> None:
    """Add whether goal and map outlive the processes that drive and map."""
    parser.add_argument(
        "--resume",
        action="store_true",
        help="go on with map and goal under way after a process died, with the goal also after "
        "time was set back",
    )


def add_robot_choice(
    parser: argparse.ArgumentParser, action: str | type[argparse.Action] = "store"
) -> None:
    """Add which robot is meant, where there may be several.

    Args:
        parser: The command's.
        action: What is done with the robot's namespace.
    """
    parser.add_argument(
        "--namespace",
        action=action,
        type=namespace,
        default="",
        metavar="NAME",
        help="the robot's: its nodes and topics, /tf and /clock too, are below /NAME",
    )
    parser.add_argument(
        "--domain-id", type=domain_id, metavar="N", help="of ROS, 0 to 232 ($ROS_DOMAIN_ID)"
    )


def namespace(text: str) -> str:
    """Return a namespace without the outer slashes."""
    if text and not _NAMESPACE.fullmatch(text):
        raise argparse.ArgumentTypeError(f"{text!r} is no namespace; valid: words of a-z, 0-9, _")
    return text.strip("/")


def domain_id(text: str) -> int:
    """Return a number of a ROS domain."""
    if not text.isascii() or not text.isdigit() or int(text) > _DOMAIN_MAX:
        raise argparse.ArgumentTypeError(f"{text!r} is no domain; valid: 0 to {_DOMAIN_MAX}")
    return int(text)


def add_maps_folder(parser: argparse.ArgumentParser) -> None:
    """Add where maps are."""
    parser.add_argument(
        "--maps-folder",
        type=Path,
        metavar="DIR",
        help="folder of relative paths that clients save and load maps by (the working folder)",
    )


def add_log_options(
    parser: argparse.ArgumentParser, out: str, what: str
) -> argparse._ArgumentGroup:
    """Add the options of a command that can run on a log instead of a robot.

    Args:
        parser: The command's.
        out: The folder that results go to by default.
        what: Says what goes there.

    Returns:
        The group they are in, for more.
    """
    group = parser.add_argument_group("on a log")
    group.add_argument(
        "--offline",
        type=Path,
        metavar="INPUT",
        help="a CARMEN log (.clf, .log, also .xz, .gz, .bz2), a recording (.mcap, .db3, .bag) or "
        "a rosbag2 folder",
    )
    group.add_argument(
        "--out", type=Path, default=Path(out), metavar="FOLDER", help=f"{what} (%(default)s)"
    )
    return group


def add_robot_names(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Add what the robot calls its topics and frames; each reaches every node that needs it.

    Returns:
        The group they are in, for more.
    """
    group = parser.add_argument_group("what the robot, or a recording, calls its own")
    group.add_argument("--scan-topic", metavar="TOPIC", help="of the lidar (scan)")
    group.add_argument("--odom-topic", metavar="TOPIC", help="of the odometry (odom)")
    group.add_argument("--cmd-vel-topic", metavar="TOPIC", help="it is driven by (cmd_vel)")
    group.add_argument("--base-frame", metavar="FRAME", help="of the robot (base_footprint)")
    group.add_argument("--odom-frame", metavar="FRAME", help="of its odometry (odom)")
    return group


def add_seed(parser: argparse.ArgumentParser) -> None:
    """Add the seed of every random choice."""
    parser.add_argument(
        "--seed", type=seed, metavar="N", help="seed of every random choice, 0 or more (0)"
    )


def seed(text: str) -> int:
    """Return a seed."""
    if not text.isascii() or not text.isdigit() or int(text) >= 2**63:
        raise argparse.ArgumentTypeError(f"{text!r} is no seed; valid: a whole number from 0")
    return int(text)


def factor(text: str) -> float:
    """Return a factor of time, 0 for as fast as it goes."""
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is no factor; valid: a number from 0")
    return value


def finite(text: str) -> float:
    """Return a finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is no finite number")
    return value


def positive(text: str) -> float:
    """Return a finite number above 0."""
    value = finite(text)
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f"{text!r} must be above 0")
    return value
