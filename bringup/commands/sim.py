"""`sim`: the simulated robot in its world, in real time."""

from __future__ import annotations

import argparse

from arjuna_core.errors import ConfigError
from bringup.parameters import options

EXAMPLES = (
    "sim",
    "sim --robot urdf/burger.urdf --world worlds/pillar_arena.world --at -2 -0.5",
    "sim --at -2 0.5 --heading 1.57",
    "sim --check my.urdf",
    "sim --viewer",
    "sim --namespace a --namespace b --at -2 0 --at 2 2",
    "sim --world worlds/office.world --record",
)

_SEVERAL = """Several robots in one world: give --namespace again for each, and --at, --heading
and --robot in the same order. Each is driven and seen below its own namespace, as
`nav --namespace NAME` takes it; one that is spawned while it runs too."""


def configure(parser: argparse.ArgumentParser) -> None:
    parser.epilog = _SEVERAL
    options.add(parser, *options.NODES, "--record")
    options.add(parser, "--namespace", action=options.Each)
    options.add(parser, "--domain-id", "--json")
    options.add(parser, "--robot", action=options.Each)
    options.add(parser, "--package-path", "robot_arguments", "--world", "--model-path")
    options.add(parser, "--at", "--heading", action=options.Each)
    options.add(parser, "--seed", "--check", "--save-guess")
    parser.set_defaults(use_sim_time=True)
    parser.add_argument(
        "--without-description",
        action="store_true",
        help="the simulator alone, as Gazebo: other nodes publish the robot's frames, and its"
        " odometry is what its file says",
    )
    parser.add_argument(
        "--viewer",
        action="store_true",
        help="show the world in MuJoCo's own viewer, where there is a screen",
    )
    parser.add_argument(
        "--rtf",
        type=options.factor,
        metavar="FACTOR",
        help="simulated seconds per real second, 0 for as fast as it goes (1)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the simulator until it is stopped, or check a file."""
    if arguments.check is not None:
        from arjuna_sim.check import describe_file
        from bringup.terminal import show

        options.extend_search(arguments)
        if ":=" in str(arguments.check):  # an argument of the robot's file, not --check's own
            arguments.robot_arguments += [str(arguments.check)]
            arguments.check = ""
        files = [arguments.check] if arguments.check else [arguments.robot, arguments.world]
        if not any(files):
            raise ConfigError("--check: lacks its file; valid: --check FILE, or with --robot FILE")
        for file in filter(None, files):
            named = not arguments.check and file is arguments.robot
            show(describe_file(file, arguments.robot_arguments, arguments.save_guess, named))
        return 0
    from bringup.parameters.sources import is_fleet
    from bringup.parameters.world_robots import take_robots_of_world
    from bringup.processes.interactive import supervise

    options.extend_search(arguments)
    take_robots_of_world(arguments)
    if is_fleet(vars(arguments)):  # the simulator's node, which has no namespace, makes the robots
        arguments.namespace, arguments.robot = "", None
    return supervise(arguments)
