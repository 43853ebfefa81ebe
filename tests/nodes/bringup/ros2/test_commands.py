"""Commands print and end as ros2cli's; endless ones until they are interrupted."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.helpers.processes import DEADLINE, Lines
from tests.helpers.ros2.commands import Outcome
from tests.nodes.bringup.ros2.conftest import ENVIRONMENT

Run = Callable[..., Outcome]

WAITING = ("waiting for at least", "waiting for service", "a message was lost", "\ttotal count")
TEXTS = re.split(r"^\$ (.*)\n", Path(__file__).with_name("ros2cli.txt").read_text(), flags=re.M)[1:]
CASES = dict(zip(TEXTS[::2], TEXTS[1::2], strict=True))
"""What ros2cli prints on the stand-in's graph for each line of words, numbers masked."""


def words_of(line: str) -> list[str]:
    """Split a line; colons in braces get the space that YAML wants."""
    return [re.sub(r":(?=\S)", ": ", word) if word[0] == "{" else word for word in line.split()]


def masked(text: str) -> str:
    """Replace what differs from run to run."""
    text = re.sub(r"(?<=with ID: )[0-9a-f]{32}", "ID", text)
    text = re.sub(r"RIHS01_[0-9a-f]{64}", "HASH", text)
    text = re.sub(r"(?<=GID: )[0-9a-f.]+", "GID", text)
    text = re.sub(r"(?<= ) *-?\d+\.\d{3}(?=[ \n])", lambda m: m[0].replace("-", " "), text)
    return re.sub(r"(?<![\w/])-?\d+(\.\d+)?", "#", text)


@pytest.mark.parametrize("line", CASES)
def test_prints_what_ros2cli_prints(line: str, ros2: Run) -> None:
    code, out, err = ros2(*words_of(line))
    assert [text for text in err.splitlines() if not text.startswith("[INFO]")] == []
    assert code == 0
    lines = masked(out).splitlines(keepends=True)
    printed = "".join(line for line in lines if not line.lower().startswith(WAITING))
    assert printed == masked(CASES[line])


FAILURES: dict[str, tuple[str, str]] = {
    "topic type /nope": ("", ""),
    "service type /nope": ("", ""),
    "action type /nope": ("", ""),
    "topic info /nope": ("", "Unknown topic '/nope'\n"),
    "service info /nope": ("", "Unknown service '/nope'\n"),
    "node info /nope": ("", "Unable to find node '/nope'\n"),
    "param get /nope gain": ("", "Node not found\n"),
    "param get /stand_in nope": ("", "Parameter not set\n"),
    "param get /stand_in gian": ("", "Parameter not set; the nearest to 'gian': gain\n"),
    "lifecycle get /nope": ("", "Node not found\n"),
    "lifecycle set /stand_in fly": (
        "",
        "Unknown transition requested, available ones are:\n- configure [1]\n- shutdown [5]\n",
    ),
    "topic echo /nope": (
        "WARNING: topic [/nope] does not appear to be published yet\n",
        "Could not determine the type for the passed topic\n",
    ),
    "topic echo /chatter --once --field data.nope": (
        "",
        "Invalid field 'data.nope': 'str' object has no attribute 'nope'\n",
    ),
    "topic pub -1 /x std_msgs/msg/Nope": ("", "The passed message type is invalid\n"),
    "topic pub -1 /x std_msgs/msg/String {nope:1}": (
        "",
        "Failed to populate field: 'String' object has no attribute 'nope'\n",
    ),
    "topic pub -1 /x std_msgs/msg/String text": (
        "",
        "The passed value needs to be a dictionary in YAML format\n",
    ),
    "topic pub -1 /x std_msgs/msg/UInt8MultiArray {data:[300]}": (
        "",
        "Failed to populate field: unsigned byte integer is greater than maximum\n",
    ),
    "topic pub -1 -w 1 --max-wait-time-secs 1 /x std_msgs/msg/String": (
        2 * "Waiting for at least 1 matching subscription(s)...\n",
        "Timed out waiting for subscribers: Expected 1 subscribers but only got 0 subscribers\n",
    ),
    "param set /stand_in gain @x": (
        "",
        "The passed value is no YAML: while scanning for the next token\n"
        "found character '@' that cannot start any token\n"
        '  in "<unicode string>", line 1, column 1:\n    @x\n    ^\n',
    ),
    "topic type /_hidden": ("", ""),
    "service call -r 0 /x std_srvs/srv/Empty": ("", "rate must be greater than zero\n"),
    "service call /toggle std_srvs/srv/SetBool text": (
        "",
        "Failed to populate field: Value 'text' is expected to be a dictionary but is a str\n",
    ),
    "action send_goal /wait nav2_msgs/action/Wait {nope:1}": (
        "",
        "Failed to populate message fields:"
        " AttributeError(\"'Wait_Goal' object has no attribute 'nope'\")\n",
    ),
    "topic echo /bad-name": (
        "",
        "Invalid topic name: topic name must not contain characters"
        " other than alphanumerics, '_', or '/':\n  '/bad-name'\n       ^\n",
    ),
    "topic pub -1 /bad-name std_msgs/msg/Empty": (
        "",
        "Invalid topic name: topic name must not contain characters"
        " other than alphanumerics, '_', '~', '{', or '}':\n  '/bad-name'\n       ^\n",
    ),
    "service call /x std_srvs/srv/Nope": ("", "The passed service type is invalid\n"),
    "action send_goal /x nav2_msgs/action/Nope {}": ("", "The passed action type is invalid\n"),
}


@pytest.mark.parametrize("line", FAILURES)
def test_fails_as_ros2cli_fails(line: str, ros2: Run) -> None:
    assert ros2(*words_of(line)) == (1, *FAILURES[line])


def test_a_refused_parameter_is_said_on_the_error_stream(ros2: Run) -> None:
    code, out, err = ros2("param", "set", "/stand_in", "gain", "99.0")
    assert (code, out) == (0, "")
    assert err.startswith("Setting parameter failed: Parameter gain out of range")


def test_an_unknown_parameter_is_refused_with_the_nearest_names(ros2: Run) -> None:
    _, out, err = ros2("param", "set", "/stand_in", "group.name", "1.0")
    assert (out, err.count("\n")) == ("", 1)
    assert err.endswith("; the nearest to 'group.name': group.names\n")


def test_a_node_s_interfaces_are_under_their_titles(ros2: Run) -> None:
    lines = ros2("node", "info", "/stand_in").out.splitlines()
    titles = ("Subscribers", "Publishers", "Service Servers", "Service Clients")
    expected = ["/stand_in", *(f"  {title}:" for title in titles)]
    expected += ["  Action Servers:", "  Action Clients:"]
    assert [line for line in lines if not line.startswith("    ") and line] == expected
    assert lines[lines.index("  Action Servers:") + 1] == "    /wait: nav2_msgs/action/Wait"
    assert "    /toggle: std_srvs/srv/SetBool" in lines
    assert lines[lines.index("  Service Clients:") + 1] == ""


def test_a_dump_loads_again(ros2: Run, tmp_path: Path) -> None:
    file = tmp_path / "dump.yaml"
    file.write_text(ros2("param", "dump", "/stand_in").out.replace("gain: 2.5", "gain: 1.25"))
    code, out, err = ros2("param", "load", "/stand_in", str(file))
    assert code == 0
    assert "Set parameter gain successful\n" in out
    assert "Set parameter size failed" in err
    assert ros2("param", "get", "/stand_in", "gain").out == "Double value is: 1.25\n"
    ros2("param", "set", "/stand_in", "gain", "2.5")


def test_service_list_has_what_the_node_serves(ros2: Run) -> None:
    assert "/toggle [std_srvs/srv/SetBool]" in ros2("service", "list", "-t").out.splitlines()


pytestmark = pytest.mark.usefixtures("stand_in")

LINES = {
    "run tf2_ros static_transform_publisher 1 0 0 0 0 0 a b --ros-args -r __node:=fixed": (
        r"translation: \('1.000000', '0.000000', '0.000000'\)"
    ),
    "topic hz /chatter --window 20": r"average rate: \d+\.\d{3}",
    "topic bw /chatter": r"\d+ B/s from \d+ messages",
    "topic delay /point": r"average delay: 0\.\d{3}",
    "topic echo /chatter": r"data: hello \d+",
    "service echo /toggle": r"  event_type: REQUEST_RECEIVED",
    "topic pub -r 20 /cmd_vel geometry_msgs/msg/Twist": (
        r"publishing #3: geometry_msgs.msg.Twist\(.*"
    ),
}


@pytest.mark.parametrize("line", LINES)
def test_runs_until_interrupted(line: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in ENVIRONMENT.items():
        monkeypatch.setenv(name, value)
    with Lines("-m", "bringup.ros2.main", *line.split()) as process:
        (first, *_) = process.wait_for(LINES[line].split("\\", maxsplit=1)[0] or "/s from")
        assert re.fullmatch(LINES[line], first)
        process.process.send_signal(signal.SIGINT)
        of_a_node = line.startswith("run ")  # `launch` calls any other end of one a death
        expected = 0 if of_a_node else signal.SIGINT
        assert process.read_to_end() == expected, process.seen
        assert not [text for text in process.seen if "Traceback" in text]


@pytest.mark.parametrize("words", ["topic echo /chatter", "topic echo -i /chatter"])
def test_echo_ends_in_order_where_nobody_reads_any_more(words: str, stand_in: None) -> None:
    command = [sys.executable, "-m", "bringup.ros2.main", *words.split()]
    environment = {**os.environ, **ENVIRONMENT}
    pipe = subprocess.PIPE
    with subprocess.Popen(command, env=environment, stdout=pipe, stderr=pipe) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline()
        process.stdout.close()
        process.wait(DEADLINE)
        assert process.stderr.read() == b""
