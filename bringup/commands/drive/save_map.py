"""`save-map`: write the map to files."""

from __future__ import annotations

import argparse
from pathlib import Path

from bringup.parameters import options

EXAMPLES = ("save-map out/my_map",)


def configure(parser: argparse.ArgumentParser) -> None:
    options.add(parser, *options.ROBOT_CHOICE)
    parser.add_argument(
        "name", type=Path, metavar="NAME", help="path without suffix: NAME.pgm, NAME.yaml"
    )
    options.add(parser, "--timeout", default=10.0, help="wait for a map for [s] (%(default)g)")
    parser.add_argument("--topic", default="map", help="the map's (%(default)s)")
    parser.add_argument("--occ", type=_threshold, metavar="P", help="occupied from P on (0.65)")
    parser.add_argument("--free", type=_threshold, metavar="P", help="free up to P (0.25)")
    parser.add_argument("--mode", help="trinary, scale or raw: what the shades are (trinary)")
    parser.add_argument("--fmt", default="pgm", help="of the image: pgm, png or bmp (%(default)s)")


def _threshold(text: str) -> float:
    """Return a probability; as ROS 1 takes it, in percent, where it is above 1."""
    value = options.positive(text)
    return value / 100.0 if value > 1.0 else value


def run(arguments: argparse.Namespace) -> int:
    """Save the map."""
    from dataclasses import replace

    from arjuna_core.files.map_image import MAP_SAVER
    from bringup.client.robot import Robot
    from bringup.terminal import show

    names = {"occ": "occupied_thresh", "free": "free_thresh", "mode": "mode"}
    given = {new: vars(arguments)[old] for old, new in names.items()}
    options = replace(MAP_SAVER, **{k: v for k, v in given.items() if v is not None})
    with Robot(arguments.timeout, arguments.namespace) as robot:
        path = robot.save_map(arguments.name, arguments.topic, arguments.fmt, options)
        show(f"saved {path}")
    return 0
