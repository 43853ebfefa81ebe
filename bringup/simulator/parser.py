"""The commands `entity` and `world`: what a person asks of a running simulator."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

SCOPES = {"all": 255, "time": 1, "state": 2, "spawned": 4}
STEPS_MAX = 1_000_000
_Commands = argparse._SubParsersAction  # argparse has no public name for it


def add_commands(commands: _Commands[argparse.ArgumentParser]) -> None:
    """Add both commands to those of `python -m bringup`."""
    _add_entity(commands)
    _add_world(commands)


def _group(
    commands: _Commands[argparse.ArgumentParser], name: str, about: str
) -> _Commands[argparse.ArgumentParser]:
    parser = commands.add_parser(name, help=about, description=f"{about.capitalize()}.")
    return parser.add_subparsers(dest="action", required=True, metavar="ACTION")


def _add(
    actions: _Commands[argparse.ArgumentParser], name: str, about: str
) -> argparse.ArgumentParser:
    return actions.add_parser(name, help=about, description=f"{about.capitalize()}.")


def _add_entity(commands: _Commands[argparse.ArgumentParser]) -> None:
    actions = _group(commands, "entity", "spawn, move, delete and list what is in the simulation")
    spawn = _add(actions, "spawn", "put something into the world")
    spawn.add_argument("name", metavar="NAME", help="its name")
    spawn.add_argument(
        "what",
        metavar="WHAT",
        help="box:X,Y,Z, cylinder:RADIUS,LENGTH, sphere:RADIUS or person, with ?mass=KG where it"
        " can be pushed; or an SDF or URDF file, or model://NAME",
    )
    spawn.add_argument(
        "--at", nargs=2, type=_finite, default=(0.0, 0.0), metavar=("X", "Y"), help="where [m]"
    )
    spawn.add_argument("--z", type=_finite, default=0.0, help="height of its origin [m] (0)")
    spawn.add_argument("--yaw", type=_finite, default=0.0, help="heading [rad] (0)")
    spawn.add_argument(
        "--path",
        type=_path,
        metavar="POINTS",
        help="points that a person walks by, and back to the first, as '1,0 3,0 3,2'",
    )
    spawn.add_argument("--speed", type=_positive, default=1.0, help="on the path [m/s] (1)")
    spawn.add_argument("--once", action="store_true", help="stop at the path's end")
    delete = _add(actions, "delete", "take something out of the world")
    delete.add_argument("name", metavar="NAME")
    move = _add(actions, "move", "put something, or the robot, somewhere else")
    move.add_argument("name", metavar="NAME", help="'robot' for the robot")
    move.add_argument("at", nargs=2, type=_finite, metavar=("X", "Y"), help="where [m]")
    move.add_argument("--z", type=_finite, default=0.0, help="height of its origin [m] (0)")
    move.add_argument("--yaw", type=_finite, default=0.0, help="heading [rad] (0)")
    found = _add(actions, "list", "print names and poses of what there is")
    found.add_argument("--filter", default="", metavar="REGEX", help="only names that match")


def _add_world(commands: _Commands[argparse.ArgumentParser]) -> None:
    actions = _group(commands, "world", "pause, step, reset and replace the simulated world")
    _add(actions, "pause", "let simulated time stand still")
    _add(actions, "play", "let simulated time run")
    step = _add(actions, "step", "run a paused simulation for some ticks")
    step.add_argument("steps", nargs="?", type=_steps, default=1, metavar="N", help="how many (1)")
    reset = _add(actions, "reset", "return to the start")
    reset.add_argument("--scope", choices=sorted(SCOPES), default="all", help="what to reset (all)")
    load = _add(actions, "load", "replace the world; the simulation is stopped then")
    load.add_argument("world", type=Path, metavar="FILE", help="an SDF world")
    _add(actions, "quit", "end the simulator")
    _add(actions, "list", "print which worlds there are")
    _add(actions, "show", "print which world is loaded, and whether time runs")


def _finite(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is no finite number")
    return value


def _positive(text: str) -> float:
    value = _finite(text)
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f"{text!r} must be above 0")
    return value


def _path(text: str) -> list[tuple[float, float]]:
    points = []
    for word in text.split():
        x, comma, y = word.partition(",")
        if not comma:
            raise argparse.ArgumentTypeError(f"{word!r} is no point; valid: X,Y")
        points.append((_finite(x), _finite(y)))
    if len(points) < 2:
        raise argparse.ArgumentTypeError(f"{text!r} is no path; valid: two or more points X,Y")
    return points


def _steps(text: str) -> int:
    if not text.isascii() or not text.isdigit() or not 1 <= int(text) <= STEPS_MAX:
        raise argparse.ArgumentTypeError(f"{text!r} is no count; valid: 1 to {STEPS_MAX}")
    return int(text)
