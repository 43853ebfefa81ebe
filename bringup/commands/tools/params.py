"""`params`: all parameters, a file checked or converted, two files compared."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from bringup.parameters import options

if TYPE_CHECKING:
    from bringup.parameters.files import Parameters

EXAMPLES = (
    "params dump",
    "params check my.yaml",
    "params check my.yaml --robot my.urdf",
    "params diff my.yaml",
    "params convert amcl.launch",
)


def configure(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    dump = actions.add_parser("dump", help="every parameter, as a file that --params loads")
    dump.add_argument("nodes", nargs="*", metavar="NODE", help="only of these nodes")
    dump.add_argument(
        "--params", type=Path, action="append", default=[], metavar="FILE", help="with its values"
    )
    check = actions.add_parser("check", help="everything that is wrong with a file")
    check.add_argument("file", type=Path, metavar="FILE")
    about = "the robot that is driven, its URDF, xacro or SDF (urdf/arjuna.urdf)"
    options.add(check, "--robot", help=about)
    for action in (dump, check):
        options.add(action, "--plugin-path")
    check.add_argument("--strict", action="store_true", help="an unknown name is a problem")
    check.add_argument(
        "-v", "--verbose", action="store_true", help="list the names that are not needed here"
    )
    convert = actions.add_parser(
        "convert", help="a ROS 1 or Nav2 file, or a ROS 1 launch file, by the names used here"
    )
    convert.add_argument("file", type=Path, metavar="FILE")
    diff = actions.add_parser("diff", help="where a file differs from the shipped values")
    diff.add_argument("file", type=Path, metavar="A")
    diff.add_argument("other", nargs="?", type=Path, metavar="B", help="or from another file")


def run(arguments: argparse.Namespace) -> int:
    """Do the action; return 1 where a file is wrong, or where files differ."""
    actions = {"dump": _dump, "check": _check, "diff": _diff, "convert": _convert}
    options.extend_search(arguments)
    return actions[arguments.action](arguments)


def _dump(arguments: argparse.Namespace) -> int:
    from arjuna_core.errors import ConfigError, nearest
    from bringup.parameters.checking import over_shipped
    from bringup.parameters.files import for_node
    from bringup.parameters.listing import dump
    from bringup.stack import all_nodes
    from bringup.terminal import show

    specs = {spec.name: spec for spec in all_nodes()}
    wanted = [name.strip("/") for name in arguments.nodes] or list(specs)
    unknown = [f"no node '{name}'; {nearest(name, specs)}" for name in wanted if name not in specs]
    if unknown:
        raise ConfigError(*unknown)
    values = over_shipped(arguments.params)
    show(dump((name, specs[name].config, for_node(values, name)) for name in wanted))
    return 0


def _check(arguments: argparse.Namespace) -> int:
    from bringup.parameters.checking import check_file
    from bringup.parameters.remarks import Kind, lines
    from bringup.terminal import show

    read = check_file(arguments.file, str(arguments.robot or ""))
    problems = read.refused_by(arguments.strict)
    counted = () if arguments.verbose else (Kind.NOT_NEEDED,)
    remarks = lines(read.remarks, counted, f"'params check -v {arguments.file}'")
    for line in [*problems, *(() if problems else remarks)]:
        show(line)
    count = f"{len(problems)} problem{'s'[: len(problems) != 1]}"
    show(f"{arguments.file}: {count if problems else 'loads'}")
    return 1 if problems else 0


def _convert(arguments: argparse.Namespace) -> int:
    from bringup.parameters.foreign.conversion import converted
    from bringup.terminal import show

    result = converted(arguments.file)
    problems = [*result.unknown, *result.problems]
    for heading, lines in (("# without meaning here:", result.notes), ("", problems)):
        for line in [heading, *lines] if lines else []:
            sys.stderr.write(f"{line}\n" if line else "")
    show(result.text)
    return 1 if result.problems else 0


def _diff(arguments: argparse.Namespace) -> int:
    from bringup.parameters.listing import differences
    from bringup.terminal import show

    files = [arguments.file] if arguments.other is None else [arguments.file, arguments.other]
    lines = differences(_every_value(files[:-1]), _every_value(files[-1:]))
    for line in lines:
        show(line)
    return 1 if lines else 0


def _every_value(paths: Sequence[Path]) -> Parameters:
    """Return every value of every node."""
    from bringup.parameters.checking import over_shipped
    from bringup.parameters.files import for_node
    from bringup.parameters.listing import values_of
    from bringup.stack import all_nodes

    parameters, specs = over_shipped(paths), all_nodes()
    return {spec.name: values_of(spec.config, for_node(parameters, spec.name)) for spec in specs}
