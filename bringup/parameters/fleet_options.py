"""Options of a simulator that may have several robots, and the parameters they stand for."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from typing import Any

from arjuna_core.errors import ConfigError
from bringup.parameters.options import finite


class Each(argparse.Action):
    """Keeps all values of an option: the last one by its name, all of them by its plural."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        """Take a value."""
        plural = f"{self.dest}s"
        setattr(namespace, self.dest, values)
        setattr(namespace, plural, [*(getattr(namespace, plural, None) or []), values])


def add_start(parser: argparse.ArgumentParser) -> None:
    """Add where robots start."""
    where = "where the robot starts, or the nearest free place [m] (0 0)"
    parser.add_argument("--at", nargs=2, type=finite, action=Each, metavar=("X", "Y"), help=where)
    about = "its heading there (0)"
    parser.add_argument("--yaw", type=finite, action=Each, metavar="RAD", help=about)


def is_fleet(options: Mapping[str, Any]) -> bool:
    """Tell whether options name several robots."""
    return any(len(options.get(name) or ()) > 1 for name in ("robots", "namespaces"))


def one_process(arguments: argparse.Namespace) -> None:
    """Leave robots' namespaces to the simulator's node, which has none, where there are several."""
    if is_fleet(vars(arguments)):
        arguments.namespace, arguments.robot = "", None


def of_starts(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of `sim` that say which robots there are, and where they start.

    Args:
        options: What the command line says; one robot's file is that of all namespaces.

    Raises:
        ConfigError: One robot has several starts, or not each place has a heading.
    """
    places: Sequence[Sequence[float]] = options.get("ats") or []
    headings: Sequence[float] = options.get("yaws") or []
    if not is_fleet(options):
        if max(len(places), len(headings)) > 1:
            raise ConfigError("--at or --yaw is given again, but there is one robot")
        given = dict(zip(("x", "y"), *places, strict=True)) if places else {}
        given |= dict(zip(("yaw",), headings, strict=False))
        return {f"initial_pose.{key}": value for key, value in given.items()}
    if headings and len(headings) != len(places):
        problem = f"{len(places)} places (--at) and {len(headings)} headings (--yaw) are given"
        raise ConfigError(f"{problem}; each place needs one, or none")
    names = options.get("namespaces") or []
    files = [str(path.resolve()) for path in options.get("robots") or []]
    starts = zip(places, headings or [0.0] * len(places), strict=True)
    values = {
        "namespaces": names,
        "robots": files * len(names) if len(files) == 1 else files,
        "starts": [number for (x, y), yaw in starts for number in (x, y, yaw)],
    }
    return {key: value for key, value in values.items() if value}
