"""`ros2 interface list`, `package`, `packages`, `proto`, `show`."""

from __future__ import annotations

import argparse
import sys

from bringup.ros2.types import flattened, interface_class, interfaces_of
from bringup.ros2.types import packages as all_packages

_TITLES = {"msg": "Messages", "srv": "Services", "action": "Actions"}


def _kinds(arguments: argparse.Namespace) -> list[str]:
    options = {
        "msg": arguments.only_msgs,
        "srv": arguments.only_srvs,
        "action": arguments.only_actions,
    }
    return [kind for kind in options if options[kind]] or list(options)


def list_(arguments: argparse.Namespace) -> None:
    """List all interfaces."""
    found = all_packages()
    for kind in _kinds(arguments):
        print(f"{_TITLES[kind]}:")
        for package, names in found.items():
            for name in names:
                if name.startswith(f"{kind}/"):
                    print(f"    {package}/{name}")


def package(arguments: argparse.Namespace) -> None:
    """List the interfaces of a package."""
    for name in interfaces_of(arguments.package_name):
        if name.split("/")[0] in _kinds(arguments):
            print(f"{arguments.package_name}/{name}")


def packages(arguments: argparse.Namespace) -> None:
    """List the packages that have interfaces."""
    kinds = set(_kinds(arguments))
    for name, names in all_packages().items():
        if kinds & {item.split("/")[0] for item in names}:
            print(name)


def proto(arguments: argparse.Namespace) -> None:
    """Print an interface with its default values, to be filled in and sent."""
    from bringup.ros2.values import to_yaml  # only here: it takes as long as all the rest

    found = interface_class(arguments.type)
    for part in ("Goal", "Request"):
        found = getattr(found, part, found)
    text = to_yaml(found())
    print(text if arguments.no_quotes else f'"{text}"')


def show(arguments: argparse.Namespace) -> int:
    """Print a definition; `-` reads its name from the standard input."""
    name = sys.stdin.readline().strip() if arguments.type == "-" else arguments.type
    if not name:
        sys.stderr.write("ros2 interface show: error: the passed value is empty\n")
        return 2
    for line in flattened(name, not arguments.no_comments, arguments.all_comments):
        print(line)
    return 0
