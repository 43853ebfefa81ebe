"""`ros2 topic`."""

from __future__ import annotations

import argparse

from bringup.ros2.grammar import Argument, Command, Verb, argument, switch

PRESETS = (
    *("unknown", "default", "system_default", "sensor_data", "services_default"),
    *("parameters", "parameter_events", "action_status_default", "best_available"),
)
_TOPIC = argument("topic_name", complete="topic", help="name of the topic, for example '/chatter'")
_TOPICS = (
    switch("-c", "--count-topics", help="only display the number of topics found"),
    switch(
        *("--include-hidden-topics", "-a", "--all"),
        default=argparse.SUPPRESS,
        help="consider hidden topics too",
    ),
)


def positive(text: str) -> int:
    """Return a whole number above 0."""
    return _number(text, "value must be a positive integer", 1)


def unsigned(text: str) -> int:
    """Return a whole number from 0."""
    return _number(text, "value must be non-negative integer", 0)


def _number(text: str, problem: str, least: int) -> int:
    if not text.isdecimal() or int(text) < least:
        raise argparse.ArgumentTypeError(problem)
    return int(text)


def rate(text: str) -> float:
    """Return a number above 0."""
    try:
        number = float(text)
    except ValueError:
        number = 0.0
    if not number > 0.0:
        raise argparse.ArgumentTypeError(f"{text!r} is no number above 0")
    return number


def _window(default: int) -> Argument:
    return argument(
        *("--window", "-w"),
        type=positive,
        default=default,
        metavar="WINDOW",
        help=f"how many messages to average over (default: {default})",
    )


def _qos(preset: str) -> tuple[Argument, ...]:
    reliability = ("system_default", "reliable", "best_effort", "unknown", "best_available")
    durability = ("system_default", "transient_local", "volatile", "unknown", "best_available")
    liveliness = ("system_default", "automatic", "manual_by_topic", "unknown", "best_available")
    return (
        argument("--qos-profile", choices=PRESETS, default=preset, help=f"preset ({preset})"),
        argument("--qos-depth", metavar="N", type=unsigned, help="queue size"),
        argument("--qos-history", choices=("system_default", "keep_last", "keep_all", "unknown")),
        argument("--qos-reliability", choices=reliability),
        argument("--qos-durability", choices=durability),
        argument("--qos-liveliness", choices=liveliness),
        argument("--qos-liveliness-lease-duration-seconds", type=float, metavar="S"),
    )


ECHO: tuple[Argument | tuple[Argument, ...], ...] = (
    _TOPIC,
    argument("message_type", nargs="?", help="type of the message; that of the graph if left out"),
    *_qos("sensor_data"),
    switch("--csv", help="all fields on one line, separated by commas"),
    argument("--field", help="show one field, '.' for fields of it: pose.pose.position"),
    switch("--full-length", "-f", help="show all of long arrays, bytes and strings"),
    argument(
        *("--truncate-length", "-l"),
        type=unsigned,
        default=128,
        help="where to cut arrays, bytes and strings (default: 128)",
    ),
    switch("--no-arr", help="leave arrays out"),
    switch("--no-str", help="leave strings out"),
    switch("--flow-style", help="collections on one line"),
    switch("--no-lost-messages", help="do not report lost messages"),
    switch("--raw", help="show the serialized bytes"),
    argument(
        "--filter", metavar="EXPR", help="show only where this Python expression of m is true"
    ),
    switch("--once", help="end after the first message"),
    argument("--timeout", metavar="N", type=rate, help="end after this many seconds"),
    switch("--include-message-info", "-i", help="show the message's times too"),
)
PUB: tuple[Argument | tuple[Argument, ...], ...] = (
    _TOPIC,
    argument("message_type", complete="message_type", help="for example 'std_msgs/msg/String'"),
    (
        argument("values", nargs="?", default="{}", help="the fields as YAML: 'data: Hello'"),
        switch("--stdin", help="read the values from standard input"),
    ),
    argument("-r", "--rate", metavar="N", type=rate, default=1.0, help="in Hz (default: 1)"),
    argument("-p", "--print", metavar="N", type=int, default=1, help="print every N-th message"),
    (
        switch("-1", "--once", help="publish one message and end"),
        argument("-t", "--times", type=unsigned, default=0, help="publish this often and end"),
    ),
    argument(
        *("-w", "--wait-matching-subscriptions"),
        type=unsigned,
        help="wait for this many subscriptions (1 with --once or --times, else 0)",
    ),
    argument(
        "--max-wait-time-secs", type=rate, metavar="N", help="how long to wait for them at most"
    ),
    argument(
        "--keep-alive",
        metavar="N",
        type=float,
        default=0.1,
        help="stay for N seconds after the last message (default: 0.1)",
    ),
    argument("-n", "--node-name", help="name of the node that publishes"),
    *_qos("default"),
)
TOPIC = Command(
    *("topic", "Various topic related sub-commands"),
    (
        Verb("bw", "Display bandwidth used by topic", (_TOPIC, _window(100)), "rates:bw"),
        Verb(
            *("delay", "Display delay of topic from timestamp in header"),
            *((_TOPIC, _window(10000)), "rates:delay"),
        ),
        Verb("echo", "Output messages from a topic", ECHO, "echo:echo"),
        Verb(
            *("find", "Output a list of available topics of a given type"),
            (
                argument(
                    "topic_type", complete="message_type", help="for example 'std_msgs/msg/String'"
                ),
                *_TOPICS,
            ),
            "names:find",
        ),
        Verb(
            *("hz", "Print the average receiving rate to screen"),
            (
                _TOPIC,
                _window(10000),
                argument("--filter", metavar="EXPR", help="count only where this is true of m"),
                switch("--wall-time", help="measure by the wall clock"),
            ),
            "rates:hz",
        ),
        Verb(
            *("info", "Print information about a topic"),
            (_TOPIC, switch("-v", "--verbose", help="node names, GIDs and QoS too")),
            "names:topic_info",
        ),
        Verb(
            *("list", "Output a list of available topics"),
            (
                switch("-t", "--show-types", help="show the types too"),
                *_TOPICS,
                switch("-v", "--verbose", help="with the numbers of publishers and subscribers"),
            ),
            "names:list_",
        ),
        Verb("pub", "Publish a message to a topic", PUB, "send:pub"),
        Verb("type", "Print a topic's type", (_TOPIC,), "names:type_"),
    ),
    (switch("--include-hidden-topics", help="consider hidden topics too"),),
    graph=True,
)
