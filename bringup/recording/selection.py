"""The topics that a command takes, by our options or by rosbag2's."""

from __future__ import annotations

import argparse
import re
from dataclasses import dataclass

_ACTION = ("/_action/status", "/_action/feedback")
EVENTS = "/_service_event"
"""What a service's name becomes by as the topic of its events."""


def is_service(topic: str, type_name: str = "/srv/_Event") -> bool:
    """Return whether a topic is that of a service's events."""
    return topic.endswith(EVENTS) and "/srv/" in type_name and type_name.endswith("_Event")


@dataclass(frozen=True)
class RecordFilter:
    """rosbag2's choice of what `record` and `convert` write; names stand with their slash.

    An expression is found anywhere in the name of a topic or service.

    Source: rosbag2_transport's TopicFilter, release 0.26.
    """

    all_topics: bool = False
    all_services: bool = False
    topics: tuple[str, ...] = ()
    topic_types: tuple[str, ...] = ()
    services: tuple[str, ...] = ()
    regex: str = ""
    exclude_regex: str = ""
    exclude_topics: tuple[str, ...] = ()
    exclude_topic_types: tuple[str, ...] = ()
    exclude_services: tuple[str, ...] = ()
    include_hidden_topics: bool = False

    def takes(self, topic: str, type_name: str) -> bool:
        """Return whether a topic is chosen; the events of services are topics too."""
        if is_service(topic, type_name):
            name = topic.removesuffix(EVENTS)
            chosen = self.all_services or name in self.services
            refused = name in self.exclude_services
        else:
            name = topic
            chosen = self.all_topics or name in self.topics or type_name in self.topic_types
            refused = type_name in self.exclude_topic_types or name in self.exclude_topics
            refused |= "/_" in name and not self.include_hidden_topics
        chosen = chosen or bool(self.regex and re.search(self.regex, name))
        refused |= bool(self.exclude_regex and re.search(self.exclude_regex, name))
        return chosen and not refused


@dataclass(frozen=True)
class PlayFilter:
    """rosbag2's choice of what `play` and `burst` publish; names stand with their slash.

    An expression fits the whole name, that of a service's events with their ending.

    Attributes:
        hidden: Whether topics with a part that begins with `_` count too where none is named;
            the feedback and status of actions, which are such parts, always count.

    Source: rosbag2_transport's Player, release 0.26.
    """

    topics: tuple[str, ...] = ()
    services: tuple[str, ...] = ()
    regex: str = ""
    exclude_regex: str = ""
    exclude_topics: tuple[str, ...] = ()
    exclude_services: tuple[str, ...] = ()
    hidden: bool = True

    def takes(self, topic: str) -> bool:
        """Return whether a topic is chosen."""
        name, wanted, refused = topic, self.topics, self.exclude_topics
        if is_service(topic):
            name = topic.removesuffix(EVENTS)
            wanted, refused = self.services, self.exclude_services
        if name in refused or (self.exclude_regex and re.fullmatch(self.exclude_regex, topic)):
            return False
        if name in wanted:
            return True
        if self.regex:
            return re.fullmatch(self.regex, topic) is not None
        return not wanted and (self.hidden or topic.endswith(_ACTION) or "/_" not in topic)


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


def selection_of(arguments: argparse.Namespace, hidden: bool = True) -> PlayFilter:
    """Return the choice that the options of `add_options` make; `hidden` as in PlayFilter."""
    wanted, unwanted = "|".join(arguments.topics), "|".join(arguments.exclude)
    return PlayFilter(regex=wanted, exclude_regex=unwanted, hidden=hidden)


def _pattern(text: str) -> str:
    pattern = text if text.startswith(("/", "(", ".", "[", "^")) else f"/{text}"
    try:
        re.compile(pattern)
    except re.error as error:
        problem = f"{text!r} is no regular expression: {error}"
        raise argparse.ArgumentTypeError(problem) from error
    return pattern
