"""`ros2 bag record|play|info`: rosbag2's options as those of `arjuna record`, `play`, `info`."""

from __future__ import annotations

import argparse

from arjuna_core.errors import nearest
from bringup.ros2.errors import Ros2Error
from bringup.ros2.tables.topic import positive

VERBS = {
    "info": "say what a recording holds",
    "play": "publish a recording's messages",
    "record": "record topics",
}


def translated(words: list[str]) -> list[str]:
    """Return the command of `arjuna` and its words for those after `ros2 bag`."""
    if not words or words[0] not in VERBS:
        given = words[0] if words else ""
        raise Ros2Error(f"ros2 bag: no verb '{given}'; {nearest(given, VERBS)}")
    if words[0] == "record":
        return ["record", *_record(words[1:])]
    storage = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    storage.add_argument("-s", "--storage")  # what is read says itself what it is
    return [words[0], *storage.parse_known_args(words[1:])[1]]


def _record(words: list[str]) -> list[str]:
    parser = argparse.ArgumentParser(prog="ros2 bag record", description="Record topics.")
    parser.add_argument("topic_names", nargs="*", help="the topics")
    parser.add_argument("--topics", nargs="+", default=[], help="the topics")
    parser.add_argument("-a", "--all", action="store_true", help="all topics")
    parser.add_argument("-o", "--output", help="the folder")
    parser.add_argument("-e", "--regex", nargs="+", default=[], help="topics that match")
    parser.add_argument("-x", "--exclude-regex", nargs="+", default=[], help="not these")
    parser.add_argument("-b", "--max-bag-size", type=positive, metavar="BYTES")
    parser.add_argument("-d", "--max-bag-duration", type=positive, metavar="SECONDS")
    parser.add_argument("-s", "--storage", choices=["mcap"], help="mcap is all there is")
    parser.add_argument("--include-hidden-topics", action="store_true")
    given = parser.parse_args(words)
    topics = [*given.topic_names, *given.topics, *given.regex]
    if not topics and not given.all:
        parser.error("must specify topics, --regex or --all")
    options = [] if given.output is None else ["--output", given.output]
    options += ["--include-hidden-topics"] if given.include_hidden_topics else []
    if given.max_bag_size is not None or given.max_bag_duration is not None:
        size, duration = given.max_bag_size, given.max_bag_duration
        options += ["--split", f"{size}B" if duration is None else f"{duration}s"]
    options += ["--exclude", *given.exclude_regex] if given.exclude_regex else []
    return [*options, "--topics", *topics] if topics and not given.all else options
