"""Contexts of rclpy: what they set up where the environment says nothing."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from pathlib import Path

import pytest
from defusedxml import ElementTree
from nav2_msgs.action import Wait

from arjuna_core.ros import context
from arjuna_core.ros.context import class_of, discovery, new_context
from arjuna_core.ros.process import Process

PROFILES = [Path(context.__file__).with_name(name) for name in ("fastdds.xml", "fastdds_open.xml")]
_FAST_DDS = "{http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles}"
_SEGMENT = 4 << 20  # [bytes] what the profile asks for
_PORTS = """
import os
from rclpy.node import Node
from arjuna_core.ros.context import new_context

context = new_context(7)
node = Node("one", context=context)
sockets = [f"/proc/self/fd/{fd}" for fd in os.listdir("/proc/self/fd")]
sockets = {os.readlink(path) for path in sockets if os.path.lexists(path)}
for line in open("/proc/net/udp").read().splitlines()[1:]:
    address, port = line.split()[1].split(":")
    if f"socket:[{line.split()[9]}]" in sockets and 9150 <= int(port, 16) < 9400:
        print(address)
node.destroy_node()
context.shutdown()
"""
"""The addresses at which a participant of domain 7 is reached: DDS gives it 250 ports."""
_NODE = """
import os

os.umask(0)
from rclpy.node import Node
from arjuna_core.ros.context import class_of, discovery, new_context

context = new_context()
node = Node("one", context=context)
mine = [line.split()[-1] for line in open("/proc/self/maps") if "/dev/shm/fastrtps_" in line]
print(max(os.path.getsize(path) for path in mine), sum(os.stat(p).st_mode & 0o022 for p in mine))
node.destroy_node()
context.shutdown()
"""


def test_shared_memory_holds_pictures_and_nobody_else_writes_it() -> None:
    size, writable = map(int, run_alone(_NODE).split())
    assert size >= _SEGMENT
    assert writable == 0


def run_alone(code: str, **variables: str) -> str:
    """Return what a process of its own prints that has these variables of the middleware."""
    kept = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("FASTRTPS", "ROS_AUTOMATIC", "ROS_STATIC"))
    }
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=kept | variables,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.stderr == ""
    return done.stdout


@pytest.mark.parametrize(
    ("variables", "opens"),
    [
        ({}, False),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_STATIC_PEERS": ""}, False),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, True),
        ({"ROS_STATIC_PEERS": "192.0.2.9"}, True),
    ],
)
def test_only_a_range_or_peers_beyond_this_machine_open_sockets(
    variables: dict[str, str], opens: bool
) -> None:
    addresses = set(run_alone(_PORTS, **variables).split())
    assert addresses
    assert (addresses == {"0100007F"}) != opens  # 127.0.0.1


def test_the_open_profile_is_the_closed_one_without_its_white_list() -> None:
    closed, open_ = (ElementTree.fromstring(path.read_bytes()) for path in PROFILES)
    transport = closed.find(f".//{_FAST_DDS}interfaceWhiteList/..")
    assert transport is not None
    (listed,) = (child for child in transport if child.tag.endswith("interfaceWhiteList"))
    assert [address.text for address in listed] == ["127.0.0.1"]
    transport.remove(listed)
    assert [(e.tag, (e.text or "").strip()) for e in closed.iter()] == [
        (e.tag, (e.text or "").strip()) for e in open_.iter()
    ]


@pytest.mark.parametrize("own", [None, "mine.xml"])
def test_environment_comes_first(
    own: str | None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    name = "FASTRTPS_DEFAULT_PROFILES_FILE"
    monkeypatch.delenv(name, raising=False)
    if own is not None:
        monkeypatch.setenv(name, str(tmp_path / own))
    new_context().shutdown()
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "OFF"
    assert Path(os.environ[name]).name == (own or "fastdds.xml")


@pytest.mark.parametrize(
    ("before", "isolated", "within"),
    [(None, False, "LOCALHOST"), ("SUBNET", False, "SUBNET"), ("SUBNET", True, "OFF")],
)
def test_discovery_range_holds_for_what_is_made_within(
    before: str | None, isolated: bool, within: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = "ROS_AUTOMATIC_DISCOVERY_RANGE"
    monkeypatch.delenv(name, raising=False)
    if before:
        monkeypatch.setenv(name, before)
    with discovery(isolated):
        assert os.environ[name] == within
    assert os.environ.get(name) == before


def test_an_isolated_process_holds_no_port_of_the_domain(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "99")
    process = Process("alone", isolated=True)
    try:
        assert process.context.get_domain_id() != 99
        assert os.environ["ROS_DOMAIN_ID"] == "99"
    finally:
        process.close()


def test_a_collection_of_garbage_is_rare_and_still_comes() -> None:
    context = new_context(231)
    context.shutdown()
    assert gc.isenabled()
    assert gc.get_threshold()[0] >= 10_000


def test_interfaces_are_found_by_name() -> None:
    assert class_of("nav2_msgs/action/Wait") is Wait
    assert class_of("nav2_msgs/action/Wait_FeedbackMessage") is Wait.Impl.FeedbackMessage
    with pytest.raises(LookupError, match="is no type; valid: package/msg/Name"):
        class_of("nav2_msgs")
    with pytest.raises(LookupError, match="is not installed"):
        class_of("nav2_msgs/msg/None_")
