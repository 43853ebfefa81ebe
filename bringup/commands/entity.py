"""`entity`: spawn, move, delete and list what is in the simulation."""

from __future__ import annotations

import argparse
from contextlib import closing
from typing import TYPE_CHECKING

from bringup.parameters import options

if TYPE_CHECKING:
    from simulation_interfaces.msg import Resource

    from bringup.client.simulator import SimulatorClient

EXAMPLES = (
    "entity list",
    "entity spawn crate box:0.5,0.5,0.5 --at 2 0",
    'entity spawn bob person --path "1,0 3,0"',
    "entity move robot 0 2",
)

_WHAT = (
    "box:X,Y,Z, cylinder:RADIUS,LENGTH, sphere:RADIUS or person, with ?mass=KG where it"
    " can be pushed; or an SDF or URDF file, or model://NAME"
)


def configure(parser: argparse.ArgumentParser) -> None:
    options.add(parser, *options.ROBOT_CHOICE)
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    _configure_spawn(_action(actions, "spawn", "put something into the world"))
    delete = _action(actions, "delete", "take something out of the world")
    delete.add_argument("name", metavar="NAME")
    move = _action(actions, "move", "put something, or the robot, somewhere else")
    move.add_argument("name", metavar="NAME", help="'robot' for the robot")
    move.add_argument("x", type=options.finite, metavar="X", help="where [m]")
    move.add_argument("y", type=options.finite, metavar="Y", help="where [m]")
    _add_height_and_heading(move)
    listing = _action(actions, "list", "print names and poses of what there is")
    listing.add_argument("--filter", default="", metavar="REGEX", help="only names that match")


def _action(
    actions: argparse._SubParsersAction[argparse.ArgumentParser], name: str, about: str
) -> argparse.ArgumentParser:
    return actions.add_parser(name, help=about, description=f"{about.capitalize()}.")


def _configure_spawn(spawn: argparse.ArgumentParser) -> None:
    spawn.add_argument("name", metavar="NAME", help="its name")
    spawn.add_argument("what", metavar="WHAT", help=_WHAT)
    spawn.add_argument(
        "--at",
        nargs=2,
        type=options.finite,
        default=(0.0, 0.0),
        metavar=("X", "Y"),
        help="where [m]",
    )
    _add_height_and_heading(spawn)
    spawn.add_argument(
        "--path",
        type=_path,
        metavar="POINTS",
        help="points that a person walks by, and back to the first, as '1,0 3,0 3,2'",
    )
    spawn.add_argument("--speed", type=options.positive, default=1.0, help="on the path [m/s] (1)")
    spawn.add_argument("--once", action="store_true", help="stop at the path's end")


def _add_height_and_heading(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--z", type=options.finite, default=0.0, help="height of its origin [m] (0)"
    )
    options.add(parser, "--heading", default=0.0, help="heading [rad] (0)")


def _path(text: str) -> list[tuple[float, float]]:
    points = []
    for word in text.split():
        x, comma, y = word.partition(",")
        if not comma:
            raise argparse.ArgumentTypeError(f"{word!r} is no point; valid: X,Y")
        points.append((options.finite(x), options.finite(y)))
    if len(points) < 2:
        raise argparse.ArgumentTypeError(f"{text!r} is no path; valid: two or more points X,Y")
    return points


def run(arguments: argparse.Namespace) -> int:
    """Ask the simulator that runs on this machine.

    Raises:
        SimulatorError: Nobody answers in time, or the request is refused.
    """
    from bringup.client.simulator import SimulatorClient
    from bringup.terminal import show

    with closing(SimulatorClient(namespace=arguments.namespace)) as client:
        for line in _done(client, arguments):
            show(line)
    return 0


def _done(client: SimulatorClient, given: argparse.Namespace) -> list[str]:
    """Do what is asked for; return what there is to say."""
    from bringup.client.simulator import pose_at

    if given.action == "list":
        return client.entities(given.filter)
    if given.action == "delete":
        client.delete(given.name)
        return [f"{given.name} is gone"]
    if given.action == "move":
        client.move(given.name, pose_at(given.x, given.y, given.z, given.yaw))
        return [f"{given.name} is at {given.x:g}, {given.y:g}"]
    x, y = given.at
    pose = pose_at(x, y, given.z, given.yaw)
    return [f"{client.spawn(given.name, _resource(client, given), pose)} is there"]


def _resource(client: SimulatorClient, given: argparse.Namespace) -> Resource:
    from bringup.client.simulator import SimulatorError, resource_of, walker

    if given.path is None:
        return resource_of(given.what)
    if given.what != "person":
        raise SimulatorError(f"only a person walks a path, not '{given.what}'")
    from bringup.scenarios.people import route_past

    path = given.path if given.once else [*given.path, given.path[0]]
    path = route_past(path, client.obstacles())
    return walker(given.name, path, given.speed, loop=not given.once)
