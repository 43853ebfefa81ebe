"""Which topics a command takes."""

from __future__ import annotations

import argparse
import re
from dataclasses import dataclass, field

_ACTION = ("/_action/status", "/_action/feedback")
Patterns = tuple[re.Pattern[str], ...]


@dataclass(frozen=True)
class TopicSelection:
    """A choice of topics; a pattern is a name or a regular expression for the whole name.

    Attributes:
        wanted: Patterns of which one must fit; all topics where there is none.
        unwanted: Patterns of which none may fit.
        hidden: Whether topics with a part that begins with `_` count too where none is named;
            the feedback and status of actions, which are such parts, always count.
    """

    wanted: Patterns = ()
    unwanted: Patterns = ()
    hidden: bool = field(default=True)

    def takes(self, topic: str) -> bool:
        """Return whether a topic is chosen."""
        if any(each.fullmatch(topic) for each in self.unwanted):
            return False
        if self.wanted:
            return any(each.fullmatch(topic) for each in self.wanted)
        return self.hidden or topic.endswith(_ACTION) or "/_" not in topic


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose topics, with the names that `ros2 bag` gives them too."""
    group = parser.add_argument_group("topics")
    group.add_argument(
        *("--topics", "--regex", "-e"),
        nargs="+",
        type=_pattern,
        default=[],
        metavar="TOPIC",
        help="only these: names or regular expressions, such as '/camera/.*'",
    )
    group.add_argument(
        *("--exclude", "--exclude-topics", "--exclude-regex", "-x"),
        nargs="+",
        type=_pattern,
        default=[],
        metavar="TOPIC",
        help="not these: names or regular expressions",
    )


def selection_of(arguments: argparse.Namespace, hidden: bool = True) -> TopicSelection:
    """Return the choice that the options of `add_options` make; `hidden` as in TopicSelection."""
    return TopicSelection(tuple(arguments.topics), tuple(arguments.exclude), hidden)


def _pattern(text: str) -> re.Pattern[str]:
    try:
        return re.compile(text if text.startswith(("/", "(", ".", "[", "^")) else f"/{text}")
    except re.error as error:
        problem = f"{text!r} is no regular expression: {error}"
        raise argparse.ArgumentTypeError(problem) from error
