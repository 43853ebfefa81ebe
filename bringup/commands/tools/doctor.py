"""`doctor`: what is wrong with the machine and the running robot, and the remedy."""

from __future__ import annotations

import argparse

from bringup.doctor.report import guides_page
from bringup.parameters import options

EXAMPLES = ("doctor", "doctor --json")


def configure(parser: argparse.ArgumentParser) -> None:
    options.add(parser, *options.ROBOT_CHOICE)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = guides_page()
    parser.add_argument("--json", action="store_true", help="findings and facts as JSON")
    options.add(parser, "--duration", default=3.0)


def run(arguments: argparse.Namespace) -> int:
    """Look; return 0 where all is well, 1 where something was found."""
    from contextlib import closing

    from bringup.client.session import Connection
    from bringup.doctor.observer import Observer
    from bringup.doctor.report import as_json, diagnose, page
    from bringup.terminal import show

    with closing(Connection("arjuna_doctor", arguments.namespace)) as session:
        snapshot = Observer(session).snapshot(arguments.duration)
    findings = diagnose(snapshot)
    show((as_json if arguments.json else page)(snapshot, findings))
    return 1 if any(findings.values()) else 0
