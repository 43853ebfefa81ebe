"""`class`: a robot for each student on one machine, each in a domain of its own, and a page."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from bringup.parameters import options

if TYPE_CHECKING:
    from collections.abc import Sequence

    from arjuna_core.grid import OccupancyGrid
    from bringup.homework.classroom import Seat

EXAMPLES = ("class --students 10", "class --students 10 --homework square --rtf 0.5")


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--students", type=int, required=True, metavar="N", help="how many")
    options.add(parser, "--out", default=Path("class"), help="where folders go (%(default)s)")
    parser.add_argument(
        "--first-domain", type=options.domain_id, default=1, metavar="N", help="of ROS (1)"
    )
    parser.add_argument(
        "--first-port", type=int, default=8101, metavar="N", help="for `view` (%(default)s)"
    )
    parser.add_argument("--homework", metavar="NAME", help="to hand out too")
    options.add(
        parser, *options.NODES, *options.SIMULATION, "--at", "--heading", "--seed", "--json"
    )
    parser.add_argument(
        "--rtf", type=options.factor, metavar="FACTOR", help="simulated per real seconds (1)"
    )
    sim = {"use_sim_time": True, "namespace": "", "record": None, "without_description": False}
    parser.set_defaults(**sim)


def run(arguments: argparse.Namespace) -> int:
    """Hand out, then run the robots until stopped."""
    from arjuna_core.files.whole_file import writing
    from bringup.homework.classroom import hand_out_seats, seats
    from bringup.homework.exercise import hand_out, load_exercise
    from bringup.terminal import show

    out = arguments.out.resolve()
    every = seats(arguments.students, out, arguments.first_domain, arguments.first_port)
    exercise = None if arguments.homework is None else load_exercise(arguments.homework)
    with writing(out):
        hand_out_seats(every, out)
    if exercise is not None:
        for seat in every:
            hand_out(exercise, Path(seat.folder) / exercise.name)
    show(f"{len(every)} places: {out / 'class.csv'}; the page: {out / 'index.html'}")
    return _supervise(arguments, every, out)


def _supervise(arguments: argparse.Namespace, every: Sequence[Seat], out: Path) -> int:
    from bringup.homework.classroom import watch
    from bringup.parameters.files import merged
    from bringup.parameters.inputs import gather
    from bringup.processes.child import ChildSpec
    from bringup.processes.fork import in_fork, warm_up
    from bringup.processes.interactive import host_command, run_host, run_supervised
    from bringup.stack import SIM_GROUP

    options.extend_search(arguments)
    arguments.command = "sim"
    parameters, grid = in_fork(lambda: gather(arguments)), _map_of(arguments)
    warm_up((SIM_GROUP,), also=("bringup.homework.classroom",))
    command = [sys.executable, "-m", "bringup", "class"]
    specs = [ChildSpec("page", command, needed=False, run=lambda: watch(every, out, grid))]
    with TemporaryDirectory(prefix="arjuna-class-") as kept:
        for seat in every:
            resume = {"sim": {"resume_file": str(Path(kept) / f"{seat.name}.resume")}}
            file = Path(kept) / f"{seat.name}.json"
            file.write_text(json.dumps(merged(parameters, resume)), encoding="utf-8")
            command = host_command(SIM_GROUP.name, file, arguments, seat.domain)
            specs.append(ChildSpec(seat.name, command, run=run_host))
        return run_supervised(arguments, specs, [seat.name for seat in every])


def _map_of(arguments: argparse.Namespace) -> OccupancyGrid | None:
    """Return the map that ships with a world, for the page."""
    from arjuna_core.files.maps import load_map
    from arjuna_core.files.shipped import shipped_file

    path = shipped_file(f"maps/{Path(arguments.world or 'arjuna_room').stem}.yaml")
    return load_map(path) if path.is_file() else None
