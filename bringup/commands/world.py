"""`world`: pause, step, reset and replace the simulated world."""

from __future__ import annotations

import argparse
from contextlib import closing
from pathlib import Path

from bringup.parameters import options

EXAMPLES = ("world pause", "world step 50", "world reset", "world load worlds/office.world")

SCOPES = {"all": 255, "time": 1, "state": 2, "spawned": 4}
STEPS_MAX = 1_000_000
_ABOUT = {
    "pause": "let simulated time stand still",
    "play": "let simulated time run",
    "step": "run a paused simulation for some ticks",
    "reset": "return to the start",
    "load": "replace the world; the simulation is stopped then",
    "quit": "end the simulator",
    "list": "print which worlds there are",
    "show": "print which world is loaded, and whether time runs",
}


def configure(parser: argparse.ArgumentParser) -> None:
    options.add(parser, *options.ROBOT_CHOICE)
    adder = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    actions = {
        name: adder.add_parser(name, help=about, description=f"{about.capitalize()}.")
        for name, about in _ABOUT.items()
    }
    actions["step"].add_argument(
        "steps", nargs="?", type=_steps, default=1, metavar="N", help="how many (1)"
    )
    actions["reset"].add_argument(
        "--scope", choices=sorted(SCOPES), default="all", help="what to reset (all)"
    )
    actions["load"].add_argument("world", type=Path, metavar="FILE", help="an SDF world")


def _steps(text: str) -> int:
    if not text.isascii() or not text.isdigit() or not 1 <= int(text) <= STEPS_MAX:
        raise argparse.ArgumentTypeError(f"{text!r} is no count; valid: 1 to {STEPS_MAX}")
    return int(text)


def run(arguments: argparse.Namespace) -> int:
    """Ask the simulator that runs on this machine.

    Raises:
        SimulatorError: Nobody answers in time, or the request is refused.
    """
    from simulation_interfaces.msg import SimulationState

    from bringup.client.simulator import SimulatorClient
    from bringup.terminal import show

    states = {
        "pause": SimulationState.STATE_PAUSED,
        "play": SimulationState.STATE_PLAYING,
        "quit": SimulationState.STATE_QUITTING,
    }
    with closing(SimulatorClient(namespace=arguments.namespace)) as client:
        action = arguments.action
        if action in states:
            client.enter(states[action])
        elif action == "step":
            client.step(arguments.steps)
        elif action == "reset":
            client.reset(SCOPES[arguments.scope])
        elif action == "load":
            client.load(arguments.world)
        if action == "list":
            show("\n".join(client.worlds()))
        elif action != "quit":
            show(client.status())
    return 0
