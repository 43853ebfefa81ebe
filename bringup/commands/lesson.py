"""`lesson`: a page of the tutorial, command by command."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from bringup.parameters import options

if TYPE_CHECKING:
    from bringup.lessons.runner import Section

EXAMPLES = ("lesson 1", "lesson 3 --list", "lesson 4 --part 2")

PAGES = {1: "1-arjuna", 2: "2-fusion", 3: "3-ros2", 4: "4-turtlebot3", 5: "5-where-am-i"}
"""The pages in docs/tutorial, by the lesson's number."""


def configure(parser: argparse.ArgumentParser) -> None:
    names = ", ".join(f"{number} {name[2:]}" for number, name in PAGES.items())
    parser.add_argument("number", type=int, choices=PAGES, metavar="N", help=names)
    parser.add_argument(
        "--part", type=int, metavar="K", help="only its K-th section (all, one after the other)"
    )
    parser.add_argument("--list", action="store_true", help="print the page's sections and end")
    parser.add_argument(
        "--yes", action="store_true", help="do not wait for Enter, leave out what needs hands"
    )
    options.add(parser, "--domain-id", help="of ROS ($ROS_DOMAIN_ID)")


def run(arguments: argparse.Namespace) -> int:
    """Run the page; return 0 where all was as it says, 1 where not.

    Raises:
        ArjunaError: The page has no such section, or a command does not come up.
    """
    from arjuna_core.errors import ConfigError
    from arjuna_core.files.shipped import shipped_file
    from bringup.lessons.runner import load_page
    from bringup.terminal import show

    path = shipped_file(f"docs/tutorial/{PAGES[arguments.number]}.md")
    page = load_page(path)
    show(f"{page.title}  ({path})")
    count = len(page.sections)
    if arguments.part is not None and not 1 <= arguments.part <= count:
        raise ConfigError(f"--part {arguments.part} is no section; valid: 1 to {count}")
    parts = range(1, count + 1) if arguments.part is None else [arguments.part]
    if arguments.list:
        for part in parts:
            show(f"  {part}  {page.sections[part - 1].title}")
        return 0
    problems: list[str] = []
    for part in parts:
        show(f"\n== {part}/{count}  {page.sections[part - 1].title}\n")
        problems += _part(arguments, page.sections[part - 1], path.parents[2])
    return 1 if problems else 0


def _part(arguments: argparse.Namespace, section: Section, root: Path) -> list[str]:
    """Run a section; return what was not as its page says."""
    from bringup.lessons.runner import run_section
    from bringup.terminal import show, write

    show(section.text)
    problems = run_section(section, root, write, attended=not arguments.yes)
    for problem in problems:
        show(f"\nNot as the page says: {problem}")
    if not problems:
        show("\nAs the page says.")
    if not arguments.yes and sys.stdin.isatty():
        write("Enter goes on, Ctrl-C ends. ")
        input()
    return problems
